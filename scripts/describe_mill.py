"""The fingerprint of a mill from its own sweep: descriptors, curves, exponents, collapse, zones, and its sheet."""

from millprint.config.mill import MillConfig
from millprint.files import write_table
from millprint.fingerprint.coverage import tabulate_coverage
from millprint.fingerprint.curves import CURVE_COLUMNS, average_curves, fill_grid
from millprint.fingerprint.descriptors import tabulate_counting_rules, tabulate_descriptors
from millprint.fingerprint.exponents import fit_exponents
from millprint.fingerprint.inputs import charges_of, read_summaries
from millprint.fingerprint.mill_collapse import tabulate_mill_collapse
from millprint.fingerprint.mill_sheet import tabulate_sheet
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.zones import find_zones
from millprint.job import job


def main(
    summaries: list[str],
    output,
    mill: MillConfig,
    *,
    counting_rule: str,
    interval: float,
    smooth_points: int,
    collapse_max: float,
) -> None:
    """Read the summaries of the mill's sweep and write its tables."""
    runs = read_summaries(summaries)
    descriptors = tabulate_descriptors(runs, counting_rule)
    write_table(descriptors, output.descriptors)
    write_table(average_curves(descriptors), output.means)
    fingerprint = Fingerprint.fit(descriptors, mill.volume_ml * 1e-6, interval, charges_of(runs))
    fills = fill_grid(descriptors["fill_ratio"].unique(), smooth_points)
    write_table(fingerprint.curve(fills)[CURVE_COLUMNS], output.curves)
    write_table(tabulate_coverage(fingerprint), output.coverage)
    fingerprint.write(output.fingerprint)
    write_table(fit_exponents(descriptors, tabulate_counting_rules(runs), interval), output.exponents)
    collapse = tabulate_mill_collapse(descriptors, interval, collapse_max)
    write_table(collapse, output.collapse)
    zones = find_zones(fingerprint)
    write_table(zones, output.zones)
    write_table(tabulate_sheet(mill, fingerprint, collapse, zones, descriptors["closure"].max()), output.sheet)


if "snakemake" in globals():
    with job(snakemake.log[0], f"describe {snakemake.params.mill['name']}"):
        main(
            snakemake.input.summaries,
            snakemake.output,
            MillConfig(**snakemake.params.mill),
            counting_rule=snakemake.params.counting_rule,
            interval=snakemake.params.interval,
            smooth_points=snakemake.params.smooth_points,
            collapse_max=snakemake.params.collapse_max,
        )
