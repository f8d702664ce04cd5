"""The oscillating ball: the friction pair that fits one track, simulated or measured."""

from millprint.calibration.experiment import fit_experiment
from millprint.config.calibration import CalibrationConfig, ExperimentConfig
from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import DemConfig
from millprint.files import write_table
from millprint.job import job


def main(
    output,
    experiment: ExperimentConfig,
    mills: dict[str, MillConfig],
    contact: ContactConfig,
    dem: DemConfig,
    settings: CalibrationConfig,
) -> None:
    """Fit one track and write its fit, its profile, the paths of the ball and what they look like in numbers."""
    for name, table in fit_experiment(experiment, mills, contact, dem, settings).items():
        write_table(table, getattr(output, name))


if "snakemake" in globals():
    with job(snakemake.log[0], f"fit friction of {snakemake.wildcards.experiment}"):
        main(
            snakemake.output,
            ExperimentConfig(**snakemake.params.experiment),
            {name: MillConfig(**mill) for name, mill in snakemake.params.mills.items()},
            ContactConfig(**snakemake.params.contact),
            DemConfig(**snakemake.params.dem),
            CalibrationConfig(**snakemake.params.settings),
        )
