"""Builds the explorer of one mill or several: one page with their fingerprints, spectra and temperatures.

params: `mills`, and `about`. input: for each mill the files of EXPLORED. output: `html`.
"""

from millprint.config.fingerprint import DescriptorSet
from millprint.config.heat import HeatConfig
from millprint.explorer.content import explorer_content
from millprint.explorer.page import explorer_page
from millprint.explorer.simulated import EXPLORED, simulated_content
from millprint.run.files import whole_file
from millprint.run.job import job


def main(mills: list[dict], output: str, name: str, *, descriptors: DescriptorSet, rule: str, heat: dict) -> None:
    """Write the page; mills: for each its section `mill` and its files, as `simulated_content` takes them."""
    settings = {
        "rule": rule, "heat": HeatConfig(**heat), "descriptors": descriptors,
    }  # fmt: skip
    content = explorer_content(name, [simulated_content(**each, settings=settings) for each in mills], descriptors)
    with whole_file(output) as partial:
        partial.write_text(explorer_page(content))


if "snakemake" in globals():
    with job(snakemake.log[0], "explore mills"):
        columns = zip(*(snakemake.input[key] for key in EXPLORED), strict=True)
        rows = zip(snakemake.params.mills, columns, strict=True)
        main(
            [{"mill": mill, "files": dict(zip(EXPLORED, row, strict=True))} for mill, row in rows],
            snakemake.output.html,
            **snakemake.params.about,
        )
