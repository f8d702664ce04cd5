"""The fingerprint of one contact set: its fitted curves as a table and as a model, and the coverage of its bands."""

from millprint.files import read_table, write_table
from millprint.fingerprint.coverage import tabulate_coverage
from millprint.fingerprint.curves import PANELS, average_curves, conditions_of, fill_grid
from millprint.fingerprint.descriptors import NUMBERS, TEXT, as_built
from millprint.fingerprint.model import Fingerprint
from millprint.job import job

COLUMNS = ["fill_ratio", *(f"{name}{end}" for name in PANELS for end in ("", "_lower", "_upper"))]


def main(
    descriptors_path: str, output, mill: str, contact: str, volume_m3: float, interval: float, smooth_points: int
) -> None:
    """Average the descriptors of one mill and contact set, and fit the fingerprint."""
    conditions = conditions_of(read_table(descriptors_path, numeric=NUMBERS, text=TEXT), mill, contact)
    built = as_built(conditions)
    write_table(average_curves(built), output.means)
    fingerprint = Fingerprint.fit(conditions, volume_m3, interval)
    write_table(fingerprint.curve(fill_grid(built["fill_ratio"].unique(), smooth_points))[COLUMNS], output.curves)
    write_table(tabulate_coverage(fingerprint), output.coverage)
    fingerprint.write(output.fingerprint)


if "snakemake" in globals():
    with job(snakemake.log[0], f"fit master curves of {snakemake.wildcards.contact}"):
        main(
            snakemake.input.descriptors,
            snakemake.output,
            snakemake.params.mill,
            snakemake.wildcards.contact,
            snakemake.params.volume_m3,
            snakemake.params.interval,
            snakemake.params.smooth_points,
        )
