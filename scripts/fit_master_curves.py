"""The fingerprint of one contact set: its fitted curves as a table and as a model, and the coverage of its bands."""

from millprint.files import write_table
from millprint.fingerprint.coverage import tabulate_coverage
from millprint.fingerprint.curves import CURVE_COLUMNS, average_curves, conditions_of, fill_grid
from millprint.fingerprint.descriptors import as_built, read_descriptors
from millprint.fingerprint.model import Fingerprint
from millprint.job import job


def main(
    descriptors_path: str, output, mill: str, contact: str, volume_m3: float, interval: float, smooth_points: int
) -> None:
    """Average the descriptors of one mill and contact set, and fit the fingerprint."""
    conditions = conditions_of(read_descriptors(descriptors_path), mill, contact)
    built = as_built(conditions)
    write_table(average_curves(built), output.means)
    fingerprint = Fingerprint.fit(conditions, volume_m3, interval)
    write_table(fingerprint.curve(fill_grid(built["fill_ratio"].unique(), smooth_points))[CURVE_COLUMNS], output.curves)
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
