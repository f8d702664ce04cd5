"""Tabulates simulations of the sweeps: what each was and gave, or the energy spectra of its collisions.

Settings: none; for spectra the counting rules, and the runs of each contact set.
Inputs: `summaries` and `runs`, of either engine; of spectra only of millprint's own.
Outputs: `table` (simulations.tsv): power, speed of the balls, contacts between balls, toe and shoulder; or `spectra`
and `summary`, what is read off each spectrum, of each contact set.
"""

from pathlib import Path

from millprint.dose.spectra import tabulate_spectra
from millprint.fingerprint.readers import read_counted
from millprint.run.files import write_table
from millprint.run.job import job


def write_spectra(run_paths: list[str], spectra_path: str, summary_path: str, rules: list[dict]) -> None:
    """Read the runs, each with the summary in its folder, and write both tables."""
    runs = [(path, read_counted(Path(path).with_name("summary.json"), rules)) for path in run_paths]
    spectra, summary = tabulate_spectra(runs, [rule["name"] for rule in rules])
    write_table(spectra, spectra_path)
    write_table(summary, summary_path)


if "snakemake" in globals():
    given, made, own = snakemake.input, snakemake.output, snakemake.params
    with job(snakemake.log[0], "tabulate simulations") as logger:
        if made.get("table"):
            # Slow to import, and spectra do not need it.
            from millprint.validation.tumbling_runs import tabulate

            write_table(tabulate(given.summaries), made.table)
        else:
            for (contact, runs), *paths in zip(own.runs.items(), made.spectra, made.summary, strict=True):
                write_spectra(runs, *paths, own.rules)
                logger.info("spectra of %s: %d simulations", contact, len(runs))
