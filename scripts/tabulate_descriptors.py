"""Descriptors of every condition, collision counting rules, and the dissipation of single revolutions.

params: `mill`, `counting_rule`, `cycle_fill_ratio`. input: `summaries` and `published`. output: the five tables.
"""

from millprint.fingerprint.cycles import tabulate_cycles, tabulate_densities, tabulate_published
from millprint.fingerprint.descriptors import CHARGE, tabulate_counting_rules, tabulate_descriptors
from millprint.fingerprint.readers import read_summaries
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.thesis.curves.regimes import published_cycles, read_published


def main(
    summary_paths: list[str], published_paths: list[str], output, mill: str, counting_rule: str, fill_ratio: float
) -> None:
    """Read all summaries and write the five tables; revolutions are compared at one fill ratio."""
    summaries = read_summaries(summary_paths)
    cycles, published = tabulate_cycles(summaries), published_cycles(read_published(*published_paths))
    write_table(tabulate_descriptors(summaries, counting_rule), output.descriptors)
    # The chapters are of balls of one size.
    write_table(tabulate_counting_rules(summaries).drop(columns=CHARGE), output.counting_rules)
    write_table(cycles, output.cycles)
    write_table(tabulate_published(cycles, published, mill, fill_ratio), output.table_3_5)
    write_table(tabulate_densities(summaries, fill_ratio), output.densities)


if "snakemake" in globals():
    with job(snakemake.log[0], "tabulate descriptors") as logger:
        logger.info("%d simulations", len(snakemake.input.summaries))
        main(
            snakemake.input.summaries,
            snakemake.input.published,
            snakemake.output,
            snakemake.params.mill,
            snakemake.params.counting_rule,
            snakemake.params.cycle_fill_ratio,
        )
