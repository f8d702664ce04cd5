"""Energy spectra of the collisions of every condition, and what is read off each, for each contact set.

Settings: fingerprint.counting_rule; the runs of each contact set.
Inputs: `summaries` and `runs`.
Outputs: `spectra` and `summary` of each contact set.
"""

from pathlib import Path

from millprint.dose.spectra import tabulate_spectra
from millprint.fingerprint.readers import read_counted
from millprint.run.files import write_table
from millprint.run.job import job


def main(run_paths: list[str], spectra_path: str, summary_path: str, rules: list[dict]) -> None:
    """Read the runs, each with the summary in its folder, and write both tables."""
    runs = [(path, read_counted(Path(path).with_name("summary.json"), rules)) for path in run_paths]
    spectra, summary = tabulate_spectra(runs, [rule["name"] for rule in rules])
    write_table(spectra, spectra_path)
    write_table(summary, summary_path)


if "snakemake" in globals():
    own, output = snakemake.params, snakemake.output
    with job(snakemake.log[0], "tabulate energy spectra") as logger:
        for (contact, runs), *paths in zip(own.runs.items(), output.spectra, output.summary, strict=True):
            main(runs, *paths, own.rules)
            logger.info("%s: %d simulations", contact, len(runs))
