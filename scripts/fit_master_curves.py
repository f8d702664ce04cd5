"""Master curves of one contact set: means at the simulated fill ratios, and a smooth curve with a band."""

from millprint.config.fingerprint import FingerprintConfig
from millprint.files import read_table, write_json, write_table
from millprint.fingerprint.curves import average_curves, conditions_of
from millprint.fingerprint.descriptors import NUMBERS, TEXT
from millprint.fingerprint.master import describe_curves
from millprint.fingerprint.smooth import smooth_curves
from millprint.job import job


def main(descriptors_path: str, output, mill: str, contact: str, volume_m3: float, settings: FingerprintConfig) -> None:
    """Average and smooth the descriptors of one mill and contact set."""
    descriptors = conditions_of(read_table(descriptors_path, numeric=NUMBERS, text=TEXT), mill, contact)
    write_table(average_curves(descriptors), output.curves)
    write_table(smooth_curves(descriptors, settings.smooth_points, settings.interval), output.smooth)
    write_json(describe_curves(descriptors, volume_m3), output.about)


if "snakemake" in globals():
    with job(snakemake.log[0], f"fit master curves of {snakemake.wildcards.contact}"):
        main(
            snakemake.input.descriptors,
            snakemake.output,
            snakemake.params.mill,
            snakemake.wildcards.contact,
            snakemake.params.volume_m3,
            FingerprintConfig(**snakemake.params.settings),
        )
