"""What must hold of the calibration before a job starts: the user's tables, and a ball that fits the jar."""

from collections.abc import Iterator

from millprint.calibration.drop_test import read_heights
from millprint.calibration.oscillation import make_swing
from millprint.calibration.track import read_track
from millprint.config.calibration import ExperimentConfig
from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.workflow import WorkflowConfig
from millprint.errors import ConfigError


def experiment_mills(config: WorkflowConfig, experiment: ExperimentConfig) -> dict[str, str]:
    """Names of the mill in which an experiment is fitted and of that in which a simulated track is made."""
    mill = experiment.mill or config.mill
    return {"mill": mill, "track_mill": experiment.track_mill or mill}


def calibration_faults(
    config: WorkflowConfig, mills: dict[str, MillConfig], contacts: dict[str, ContactConfig]
) -> Iterator[str]:
    """A line for each fault; none if all holds."""
    settings = config.calibration
    checks = [(read_heights, settings.drop_test.measured)] if settings.drop_test.measured else []
    checks += [(read_track, test.track) for test in settings.oscillation.experiments if test.track]
    for read, path in checks:
        try:
            read(path)
        except ConfigError as error:
            yield str(error)
    for test in settings.oscillation.experiments:
        for name in dict.fromkeys(experiment_mills(config, test).values()):
            diameter = test.ball_diameter_mm * 1e-3
            try:
                make_swing(mills[name], contacts[test.contact], config.dem, diameter, settings.oscillation)
            except ConfigError as error:
                yield str(error)
