"""The simulations of an experiment. The Snakefile imports this, so no heavy imports here."""

from collections.abc import Iterable

from millprint.config.card import Experiment
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.config.mill_sweep import MillsConfig
from millprint.config.mixture import diameter_of
from millprint.config.sweep import Case, balls_of
from millprint.config.view import ViewConfig
from millprint.fingerprint.cases import durations_of

# Turns of an animation and frames per turn; it has the seed of the first simulation.
TURNS, FRAMES = 2, 40
ANIMATION = ViewConfig(revolutions=TURNS, frames_per_revolution=FRAMES)
# Denser than any powder [g/mL].
DENSEST_G_ML = 25.0


def fill_of(experiment: Experiment, mill: MillConfig, contact: ContactConfig, place: str) -> float:
    """The fill ratio of an experiment [-]. Raises ConfigError, in one line, for too many balls; place: its file."""
    balls = experiment.balls
    density = balls.density_kg_m3 or contact.density_kg_m3
    try:
        return balls.fill_in(mill.volume_ml, diameter_of(balls.diameter_mm), density)
    except ValueError as error:
        raise ConfigError(f"{place}: balls: {error}") from None


def own_cases(
    experiment: Experiment, mill: MillConfig, contact: ContactConfig, settings: MillsConfig, place: str
) -> list[Case]:
    """A case for each seed, with the settings of a mill's sweep. Raises ConfigError as `fill_of`, and for powder
    that the jar cannot hold.
    """
    powder = experiment.powder
    if powder and powder.mass_g and powder.mass_g > DENSEST_G_ML * mill.volume_ml:
        raise ConfigError(
            f"{place}: powder.mass_g = {powder.mass_g:g}: more than the jar of {mill.volume_ml:g} mL can hold"
        )
    return [
        Case(
            mill=mill.name, contact=contact.name,
            **balls_of(experiment.balls.diameter_mm), fill_ratio=fill_of(experiment, mill, contact, place),
            speed_rpm=experiment.rpm, seed=seed, density_kg_m3=experiment.balls.density_kg_m3,
            rayleigh_fraction=settings.rayleigh_fraction, settle_s=settings.settle_s,
            **durations_of(experiment.rpm, experiment.discard_turns, experiment.window_turns),
        )
        for seed in experiment.seeds
    ]  # fmt: skip


def cases_of(
    experiment: Experiment,
    mill: MillConfig,
    contact: ContactConfig,
    settings: MillsConfig,
    groups: Iterable[Iterable[Case]],
    place: str,
) -> list[Case]:
    """The cases of an experiment: from the first group that simulates its condition, or the experiment's own.

    groups: the cases of the configuration, then of the mill's own sweep. If these have one seed and the experiment
    several, the experiment's seeds are added.
    """
    fill = fill_of(experiment, mill, contact, place)
    own = own_cases(experiment, mill, contact, settings, place)
    for group in groups:
        if found := [case for case in group if experiment.is_case(case, contact.name, fill)]:
            paths = {case.path for case in found}
            few = len(found) < min(2, len(own))
            return [*found, *(case for case in own if few and case.path not in paths)]
    return own


def animated_case(case: Case) -> Case:
    """The first turns of a case after its balls circulate, with a snapshot for each frame."""
    turn_s = 60 / case.speed_rpm
    return case.model_copy(
        update={
            "window_s": TURNS * turn_s,
            "power_error_max": None,
            "window_max_s": None,
            "snapshot_interval_s": turn_s / FRAMES,
        }
    )
