"""The oscillating ball: the friction pair that fits one track, simulated or measured."""

from millprint.calibration.experiment import fit_experiment
from millprint.config.calibration import ExperimentConfig, SwingConfig
from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.files import write_table
from millprint.job import job


def main(
    output,
    experiment: ExperimentConfig,
    mills: dict[str, MillConfig],
    contact: ContactConfig,
    rayleigh_fraction_max: float,
    settings: SwingConfig,
    interval: float,
) -> None:
    """Fit one track; write its fit, its profile, the paths of the ball, and the numbers that describe each path."""
    tables = fit_experiment(experiment, mills, contact, rayleigh_fraction_max, settings, interval)
    for name, table in tables.items():
        write_table(table, getattr(output, name))


if "snakemake" in globals():
    with job(snakemake.log[0], f"fit friction of {snakemake.wildcards.experiment}"):
        main(
            snakemake.output,
            ExperimentConfig(**snakemake.params.experiment),
            {name: MillConfig(**mill) for name, mill in snakemake.params.mills.items()},
            ContactConfig(**snakemake.params.contact),
            snakemake.params.rayleigh_fraction_max,
            SwingConfig(**snakemake.params.settings),
            snakemake.params.interval,
        )
