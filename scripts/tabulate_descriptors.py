"""Descriptors of every condition, collision counting rules, and the dissipation of single revolutions."""

from millprint.config.fingerprint import FingerprintConfig
from millprint.files import write_table
from millprint.fingerprint.cycles import tabulate_cycles, tabulate_densities
from millprint.fingerprint.descriptors import tabulate_counting_rules, tabulate_descriptors
from millprint.fingerprint.summaries import read_summaries
from millprint.job import job


def main(summary_paths: list[str], output, settings: FingerprintConfig) -> None:
    """Read all summaries and write the four tables."""
    summaries = read_summaries(summary_paths)
    write_table(tabulate_descriptors(summaries, settings.counting_rule), output.descriptors)
    write_table(tabulate_counting_rules(summaries), output.counting_rules)
    write_table(tabulate_cycles(summaries), output.cycles)
    write_table(tabulate_densities(summaries, settings.cycle_fill_ratio), output.densities)


if "snakemake" in globals():
    with job(snakemake.log[0], "tabulate descriptors") as logger:
        logger.info("%d simulations", len(snakemake.input.summaries))
        main(snakemake.input.summaries, snakemake.output, FingerprintConfig(**snakemake.params.settings))
