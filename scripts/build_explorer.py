"""Builds the explorer, a page that needs no server: of one mill, of several, or of the run's chapters.

Settings: name, mills.rule, dose.heat, fingerprint.descriptors; the `mills` of the page. For the chapters instead
fingerprint.counting_rule, fingerprint.inverse, yields.prediction, yields.interval_level, and their mill.
Inputs: `fingerprint`, `spectra`, `summary`, `temperatures`, `limits` of each mill. Of the chapters `own_fingerprints`,
`own_spectra`, `own_summaries` (one for each contact set), `own_temperatures`, `own_limits`, `yield_model`.
Outputs: `html`.
"""

from millprint.config.dose import HeatConfig
from millprint.config.fingerprint import InverseConfig
from millprint.config.mill import MillConfig
from millprint.config.yields import PredictionConfig
from millprint.explorer.content import (
    EXPLORED,
    Heat,
    Machine,
    Settings,
    Spectra,
    explorer_content,
    explorer_page,
    mill_content,
    simulated_content,
)
from millprint.run.files import whole_file
from millprint.run.job import job


def settings_of(about: dict) -> Settings:
    """The settings that hold for every mill of the page."""
    return {"rule": about["rule"], "heat": HeatConfig(**about["heat"]), "descriptors": about["descriptors"]}


def chapter_content(inputs, own: dict, settings: Settings) -> dict:
    """The data of the page for the mill of the chapters, with its yields.

    own: mill, request, prediction and level as plain values, and the counting rule of its spectra.
    """
    # The page of another mill needs no library of the yield models.
    from millprint.thesis.yields.new_conditions import explorer_yields

    spectra = list(zip(inputs.own_spectra, inputs.own_summaries, strict=True))
    return mill_content(
        Machine.of_mill(MillConfig(**own["mill"])),
        list(inputs.own_fingerprints),
        InverseConfig(**own["request"]),
        explorer_yields(inputs.yield_model, PredictionConfig(**own["prediction"]), own["level"]),
        Spectra(spectra, own["rule"]),
        Heat(inputs.own_temperatures, inputs.own_limits, settings["heat"]),
    )


if "snakemake" in globals():
    given, own = snakemake.input, snakemake.params
    with job(snakemake.log[0], "build explorer"):
        settings = settings_of(own.about)
        if own.get("chapters"):
            content = [chapter_content(given, own.chapters, settings)]
        else:
            paths = zip(*(given[key] for key in EXPLORED), strict=True)
            files = (dict(zip(EXPLORED, own_paths, strict=True)) for own_paths in paths)
            content = [simulated_content(mill, each, settings) for mill, each in zip(own.mills, files, strict=True)]
        with whole_file(snakemake.output.html) as partial:
            partial.write_text(explorer_page(explorer_content(own.about["name"], content, settings["descriptors"])))
