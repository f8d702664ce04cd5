"""Checks of the calibration before a job starts: the user's tables, and that the ball fits the jar."""

from collections.abc import Iterator

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.config.workflow import WorkflowConfig
from millprint.thesis.calibration.drop import read_heights
from millprint.thesis.calibration.oscillation import make_swing, read_track


def calibration_faults(
    config: WorkflowConfig, mills: dict[str, MillConfig], contacts: dict[str, ContactConfig]
) -> Iterator[str]:
    """A line for each fault; none if everything is valid, or if nothing is calibrated."""
    settings, fraction = config.calibration, config.dem.rayleigh_fraction_max
    if settings is None:
        return
    checks = [(read_heights, settings.drop_test.measured)] if settings.drop_test.measured else []
    checks += [(read_track, test.track) for test in settings.oscillation.experiments if test.track]
    for read, path in checks:
        try:
            read(path)
        except ConfigError as error:
            yield str(error)
    for test in settings.oscillation.experiments:
        for name in dict.fromkeys(test.mills(config.mill).values()):
            diameter = test.ball_diameter_mm * 1e-3
            try:
                make_swing(mills[name], contacts[test.contact], fraction, diameter, settings.oscillation)
            except ConfigError as error:
                yield str(error)
