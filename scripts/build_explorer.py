"""Builds the explorer of a run: its mill with the yield model, and every other mill that has been run.

params: `about`, and `others` (their mills). input: files of the mill and, as other_KEY, of the others. output: `html`.
"""

from millprint.config.dose import SpectraConfig
from millprint.config.fingerprint import InverseConfig
from millprint.config.heat import HeatConfig
from millprint.config.mill import MillConfig
from millprint.config.next_experiments import PredictionConfig
from millprint.explorer.condition_tables import Heat, Spectra
from millprint.explorer.content import Machine, explorer_content, mill_content
from millprint.explorer.page import explorer_page
from millprint.explorer.simulated import EXPLORED, simulated_content
from millprint.run.files import whole_file
from millprint.run.job import job
from millprint.thesis.yields.new_conditions import explorer_yields


def main(inputs, output: str, about: dict, others: list[dict]) -> None:
    """Write the page.

    inputs: fingerprints, yield_model, spectra with summaries, temperatures, limits; about: name, mill, request,
    prediction, level, spectra, own_rule, rule, heat, descriptors; others: section `mill` and files of each further
    mill.
    """
    spectra, heat, names = SpectraConfig(**about["spectra"]), HeatConfig(**about["heat"]), about["descriptors"]
    own = mill_content(
        Machine.of_mill(MillConfig(**about["mill"])),
        list(inputs.fingerprints),
        InverseConfig(**about["request"]),
        explorer_yields(inputs.yield_model, PredictionConfig(**about["prediction"]), about["level"]),
        Spectra(list(zip(inputs.spectra, inputs.summaries, strict=True)), spectra, about["own_rule"]),
        Heat(inputs.temperatures, inputs.limits, heat),
    )
    settings = {"spectra": spectra, "rule": about["rule"], "heat": heat, "descriptors": names}
    further = [simulated_content(each["mill"], each["files"], settings) for each in others]
    with whole_file(output) as partial:
        partial.write_text(explorer_page(explorer_content(about["name"], [own, *further], names)))


if "snakemake" in globals():
    with job(snakemake.log[0], "build explorer"):
        given, mills = snakemake.input, snakemake.params.others
        columns = zip(*(given[f"other_{key}"] for key in EXPLORED), strict=True)
        others = [
            {"mill": mill, "files": dict(zip(EXPLORED, row, strict=True))}
            for mill, row in zip(mills, columns, strict=True)
        ]
        main(given, snakemake.output.html, dict(snakemake.params.about), others)
