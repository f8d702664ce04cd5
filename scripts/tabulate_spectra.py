"""Energy spectra of the collisions of every condition, and what is read off each."""

from pathlib import Path

from millprint.config.dose import SpectraConfig
from millprint.dose.spectra import tabulate_spectra
from millprint.files import read_json, write_table
from millprint.job import job


def main(run_paths: list[str], output, rule_names: list[str], settings: SpectraConfig) -> None:
    """Read the runs, each with the summary beside it, and write both tables."""
    runs = [(path, read_json(Path(path).with_name("summary.json"))) for path in run_paths]
    spectra, summary = tabulate_spectra(runs, rule_names, settings)
    write_table(spectra, output.spectra)
    write_table(summary, output.summary)


if "snakemake" in globals():
    with job(snakemake.log[0], "tabulate energy spectra") as logger:
        logger.info("%d simulations", len(snakemake.input.runs))
        main(
            snakemake.input.runs,
            snakemake.output,
            snakemake.params.rules,
            SpectraConfig(**snakemake.params.settings),
        )
