"""The fingerprint of a mill from its own sweep: descriptors, curves, collapse, zones, spectra, its sheet.

Settings: the mill; mills.counting_rule, fingerprint.interval, fingerprint.smooth_points,
dose.spectra.
Inputs: `summaries` and their `runs`.
Outputs: `descriptors`, `curves`, `fingerprint` (JSON), `collapse`, `zones`, `sheet`, `spectra`, `spectra_summary`.
"""

from millprint.config.mill import MillConfig
from millprint.dose.spectra import tabulate_spectra
from millprint.dose.spectra_shown import sheet_rows, with_rows
from millprint.fingerprint.descriptors import tabulate_descriptors, with_impacts
from millprint.fingerprint.mill_collapse import find_zones, tabulate_mill_collapse
from millprint.fingerprint.mill_sheet import tabulate_sheet
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.readers import charges_of, read_summaries
from millprint.observables.condition import fill_grid
from millprint.observables.definitions import CURVE_COLUMNS
from millprint.run.files import write_table
from millprint.run.job import job


def main(
    summaries: list[str],
    records: list[str],
    output,
    mill: MillConfig,
    *,
    counting_rule: str,
    rules: list[dict],
    interval: float,
    smooth_points: int,
    spectra_rules: list[str],
) -> None:
    """Read the summaries of the mill's sweep and their run.h5, `records` in the same order, and write its tables."""
    runs = read_summaries(summaries, rules)
    descriptors = tabulate_descriptors(runs, counting_rule)
    write_table(descriptors, output.descriptors)
    fitted = with_impacts(descriptors)
    fingerprint = Fingerprint.fit(descriptors, mill.volume_ml * 1e-6, interval, charges_of(runs))
    fills = fill_grid(fitted["fill_ratio"].unique(), smooth_points)
    write_table(fingerprint.curve(fills)[CURVE_COLUMNS], output.curves)
    fingerprint.write(output.fingerprint)
    collapse = tabulate_mill_collapse(fitted, interval)
    write_table(collapse, output.collapse)
    zones = find_zones(fingerprint)
    write_table(zones, output.zones)
    spectra, read_off = tabulate_spectra(list(zip(records, runs, strict=True)), spectra_rules)
    write_table(spectra, output.spectra)
    write_table(read_off, output.spectra_summary)
    sheet = tabulate_sheet(mill, fingerprint, collapse, zones, descriptors)
    write_table(with_rows(sheet, sheet_rows(read_off, fingerprint)), output.sheet)


if "snakemake" in globals():
    with job(snakemake.log[0], f"describe {snakemake.params.mill['name']}"):
        main(
            snakemake.input.summaries,
            snakemake.input.runs,
            snakemake.output,
            MillConfig(**snakemake.params.mill),
            counting_rule=snakemake.params.counting_rule,
            rules=snakemake.params.rules,
            interval=snakemake.params.interval,
            smooth_points=snakemake.params.smooth_points,
            spectra_rules=snakemake.params.spectra_rules,
        )
