"""Builds the explorer: one page with the fingerprints and the yield model of a run, which needs no server."""

from millprint.config.fingerprint import InverseConfig
from millprint.config.proposals import PredictionConfig
from millprint.explorer.page import Yields, explorer_content, explorer_page
from millprint.files import whole_file
from millprint.job import job


def main(fingerprints: list[str], yield_model: str, output: str, about: dict) -> None:
    """Write the page; `about` holds name, title, request, prediction and level."""
    content = explorer_content(
        about["name"],
        about["title"],
        fingerprints,
        InverseConfig(**about["request"]),
        Yields(yield_model, PredictionConfig(**about["prediction"]), about["level"]),
    )
    with whole_file(output) as partial:
        partial.write_text(explorer_page(content))


if "snakemake" in globals():
    with job(snakemake.log[0], "build explorer"):
        main(
            list(snakemake.input.fingerprints),
            snakemake.input.yield_model,
            snakemake.output.html,
            dict(snakemake.params.about),
        )
