"""Checks of one experiment before its simulations: shape, balls that fit, speed, time step and cost."""

from millprint.card.read import check_material
from millprint.cases.table import own_cases
from millprint.config.card import Experiment
from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, overridden
from millprint.config.workflow import WorkflowConfig
from millprint.dem.case_checks import (
    check_ball_size,
    check_mixtures,
    check_room,
    check_step_and_cost,
    checked_bodies,
)
from millprint.dem.resources import resources_of
from millprint.dose.wear import read_materials
from millprint.fingerprint.sweep_checks import SpeedSetting, check_speeds, smallest_balls, speed_warnings, with_paces


def check_experiment(
    experiment: Experiment, mill: MillConfig, contact: ContactConfig, config: WorkflowConfig, place: str
) -> tuple[list[str], float]:
    """Warnings, a line each, and the approximate time of the simulations of all seeds on one core [s].

    config: the settings of a run; place: file of the experiment. Raises ConfigError with a line for each fault of the
    first part that has faults.
    """
    cases = own_cases(experiment, mill, contact, config.mills, place)
    changed = overridden(cases[0], mill, contact)[1]
    materials = config.dose.wear.materials
    check_material(experiment, changed.density_kg_m3, read_materials(materials), place, materials)
    key, unit = ("speed_hz", "Hz") if experiment.speed_hz is not None else ("speed_rpm", "rpm")
    return check_cases(cases, mill, changed, config, place, (key, unit))


def check_cases(
    cases: list[Case],
    mill: MillConfig,
    contact: ContactConfig,
    config: WorkflowConfig,
    place: str,
    speed: tuple[str, str] = ("speed_rpm", "rpm"),
) -> tuple[list[str], float]:
    """Warnings and time as of `check_experiment`, for cases of one mill; speed: its key and unit, rpm or Hz.

    contact: the contact set as simulated. Raises ConfigError as `check_experiment`.
    """
    mills, (key, unit) = {mill.name: mill}, speed
    bodies = checked_bodies(mills)
    settings = [SpeedSetting(f"{place}: {key}", unit, mill, *pair) for pair in sorted(smallest_balls(cases).items())]
    speeds = with_paces(settings, bodies)
    check_speeds(speeds)
    for diameter in sorted({size for case in cases for size in case.sizes_m}):
        check_ball_size(bodies[mill.name][0].vessel, mill, diameter, place)
    for case in cases:
        told = (place, place, f"{place}: rayleigh_fraction")
        check_step_and_cost(config, mill, contact, case, bodies[mill.name], told)
    check_room(cases, mills, bodies, place)
    check_mixtures(cases, mills, bodies, place)
    seconds = sum(resources_of(case, config.dem, mill, contact).processor_s for case in cases)
    return speed_warnings(speeds), seconds
