"""Checks before the first job: tables, shapes of mills, balls that fit, stable time steps.

The start of a run (millprint.checks.check_once) calls it as a program, with a configuration as JSON on standard input
and the modules of further checks as arguments. Its exit status is 1 if anything is refused.
"""

import json
import math
import sys
from collections.abc import Callable, Sequence
from importlib import import_module

from millprint.card.read import check_material
from millprint.cases.of_mill import place_of_sweep, uncertainty_cases
from millprint.cases.table import CaseTable, Why, own_cases
from millprint.config.checks import collect_cases, stop_on_bad_input
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.load import MILL_FOLDER
from millprint.config.mill import MillConfig, PaddlesGeometry
from millprint.config.motion_kinds import PlanetaryMotion
from millprint.config.sweep import Case, overridden
from millprint.config.workflow import WorkflowConfig
from millprint.dem.case_checks import check_ball_size, check_mixtures, check_room, check_step_and_cost, checked_bodies
from millprint.dem.lammps.support import check_engine
from millprint.dose.wear import read_materials
from millprint.fingerprint.sweep_checks import (
    SpeedSetting,
    check_speeds,
    fingerprint_faults,
    speed_settings,
    speed_warnings,
    with_paces,
)
from millprint.mill.bodies import Body, build_bodies
from millprint.mill.wall_words import drawn_in_words, off_axis_in_words
from millprint.validation.measured import check_validation


def check_before_running(
    config: WorkflowConfig,
    mills: dict[str, MillConfig],
    contacts: dict[str, ContactConfig],
    cases: dict[str, Case],
    source: str,
    *further: Callable[..., list[str]],
) -> list[str]:
    """Raise ConfigError with a line for each fault of the first part of the input that would make a job fail.

    further: what gives faults in addition, as `millprint.thesis.chapter_checks.chapter_faults` for a run with chapters.
    Returns warnings, a line each, about values that are unusual but may be intended.
    """
    check_validation(config)
    bodies = checked_bodies(mills)
    table = CaseTable(config, mills, contacts)
    # What the section of uncertainty names is checked by its own largest and smallest charges.
    named = [config.mill, *config.mills.named, *config.dose.heat.mills]
    swept = {name: list(table.cases(Why.MILL, name).values()) for name in dict.fromkeys(named)}
    carded = card_cases(table)
    settings = [*speed_settings(config, mills, swept, cases, source), *(speed for speed, _ in carded.values())]
    speeds = with_paces(settings, bodies)
    check_speeds(speeds)
    groups = [(place_of_sweep(config, name, source), own) for name, own in swept.items()]
    groups.append((f"{source}: sweeps", list(cases.values())))
    groups.append((f"{source}: uncertainty", uncertainty_cases(config, mills)))
    for name in config.validation.chosen:
        rows = [*table.rows(Why.SET_UP, name), *table.rows(Why.IN_SET_UP, name)]
        # Size, step and cost of every charge at every speed; seeds have the same.
        charges = {row.case.model_copy(update={"seed": 0}).path: row.case for row in rows}
        groups.append((f"{source}: validation.{name}", list(charges.values())))
    groups += [(place, own) for place, (_, own) in carded.items()]
    for place, group in groups:
        for name, diameter in sorted({(case.mill, size) for case in group for size in case.sizes_m}):
            check_ball_size(bodies[name][0].vessel, mills[name], diameter, place)
    # The key of the step: the sweeps of the configuration are a list; for mills' own sweeps it is set for all mills.
    steps = {place: f"{place}.rayleigh_fraction" for place, _ in groups}
    own, factor = config.mills, config.mills.level.step
    times = "" if factor == 1 else f" = {own.rayleigh_fraction:g}, times {factor:g} by mills.precision {own.precision}"
    steps |= {place_of_sweep(config, name, source): f"{source}: mills.rayleigh_fraction{times}" for name in swept}
    steps[f"{source}: sweeps"] = f"{source}: sweeps: rayleigh_fraction"
    # The sweeps of the configuration first, where a user looks first.
    for place, group in sorted(groups, key=lambda pair: pair[0] != f"{source}: sweeps"):
        for case in group:
            try:
                _, contact = overridden(case, mills[case.mill], contacts[case.contact])
            except ConfigError as error:
                raise ConfigError(f"{source}: {error}") from None
            told = (source, place, steps[place])
            check_step_and_cost(config, mills[case.mill], contact, case, bodies[case.mill], told)
    check_same_charges(cases, swept, source)
    # Last, because it takes longest.
    for place, group in groups:
        check_room(group, mills, bodies, place)
        check_mixtures(group, mills, bodies, place)
    check_movie(config, source)
    if config.dem.engine == "lammps":
        check_engine(cases.values(), mills, contacts, config.dem.lammps, source)
    faults = list(fingerprint_faults(config, source))
    if config.uncertainty.mills:
        # Imported here: slow to import, and few configurations name such a mill.
        from millprint.uncertainty.samples import uncertainty_faults

        faults += uncertainty_faults(config, mills, contacts, source)
    for more in further:
        faults += more(config, mills, contacts, cases, source)
    if faults:
        raise ConfigError("\n".join(faults))
    return [*speed_warnings(speeds), *mill_warnings(mills)]


def mill_warnings(mills: dict[str, MillConfig]) -> list[str]:
    """A line for each planetary mill whose jar turns in the sense of its wheel, or reaches over the wheel's axis.

    Further: for each mill of which a round wall of a file stays as it is drawn, that turns about another axis than its
    own, or whose arms catch balls.
    """
    found = []
    for name, mill in mills.items():
        shapes = [mill.geometry, *(insert.geometry for insert in mill.inserts)]
        bodies = build_bodies(mill)
        for body, shape in zip(bodies, shapes, strict=True):
            if not shape.faceted and (words := drawn_in_words(body.vessel)):
                found.append(f"{body.vessel.name}: {words}")
        found += caught_balls(mill, bodies[0])
        place, motion = f"{MILL_FOLDER}/{name}.yaml: motion", mill.motion
        if words := off_axis_in_words(bodies[0], motion):
            found.append(f"{place}: {words}")
        if not isinstance(motion, PlanetaryMotion):
            continue
        if motion.ratio > 0:
            found.append(
                f"{place}.ratio = {motion.ratio:g}: the jar turns in the sense of the wheel; jars of most mills turn "
                f"against it, and what makers print as 1:-2 or 1:2 is -2: write {-motion.ratio:g}"
            )
        radius = getattr(mill.geometry, "radius_mm", 0.0)
        if motion.sun_radius_mm < radius:
            found.append(
                f"{place}.sun_radius_mm = {motion.sun_radius_mm:g}: is less than the radius of the jar, {radius:g} mm, "
                "which thus reaches over the axis of the wheel; is a digit missing?"
            )
    return found


def caught_balls(mill: MillConfig, vessel: Body) -> list[str]:
    """A line for a mill whose lowest arms are so high above the floor that a ball of its sweep gets below them."""
    arms = {insert.geometry.bottom_mm: insert.name for insert in mill.inserts
            if isinstance(insert.geometry, PaddlesGeometry)}  # fmt: skip
    sizes = (mill.sweep.ball_diameters_mm if mill.sweep else None) or []
    smallest = min((size for size in sizes if isinstance(size, float)), default=math.inf)
    bottom, floor = min(arms, default=-math.inf), 1e3 * vessel.vessel.bounds[0, 2]
    if bottom - floor < smallest:
        return []
    return [
        f"{MILL_FOLDER}/{mill.name}.yaml: inserts: {arms[bottom]}: bottom_mm = {bottom:g}: balls of {smallest:g} mm "
        f"get below the arms, and one that just fits is caught there; write less than {floor + smallest:g}"
    ]


def card_cases(table: CaseTable) -> dict[str, tuple[SpeedSetting, list[Case]]]:
    """The cases of every experiment of the milling cards with its speed, by file and name; checks the material."""
    found, config = {}, table.config
    for name, experiment in table.experiments.items():
        place = f"{config.cards.experiments}: {name}"
        mill, balls = table.mills[experiment.mill], table.contact_of(name)
        own = own_cases(experiment, mill, balls, config.mills, place)
        key, unit = ("speed_hz", "Hz") if experiment.speed_hz is not None else ("speed_rpm", "rpm")
        ball_m = min(size for case in own for size in case.sizes_m)
        found[place] = SpeedSetting(f"{place}: {key}", unit, mill, experiment.hz, ball_m), own
        contact = overridden(own[0], mill, balls)[1]
        materials = config.dose.wear.materials
        check_material(experiment, contact.density_kg_m3, read_materials(materials), place, materials)
    return found


def check_same_charges(cases: dict[str, Case], swept: dict[str, list[Case]], source: str) -> None:
    """Refuse two charges of one name: a case of a sweep that is also in the sweep of its mill is simulated once."""
    for mill, own in swept.items():
        for case in own:
            if case.path in cases and cases[case.path].mixture != case.mixture:
                name = case.mixture.name if case.mixture else case.name
                raise ConfigError(
                    f"{source}: sweeps: ball_diameters_mm: charge {name} has other balls in the sweep of mill {mill}; "
                    "give one of the two another name"
                )


def check_movie(config: WorkflowConfig, source: str) -> None:
    """Check that the case of the report's animation records snapshots."""
    for sweep in config.sweeps:
        if sweep.name == "movie" and sweep.snapshot_interval_s is None:
            raise ConfigError(
                f"{source}: sweeps.movie.snapshot_interval_s: this key is missing; an animation is made of snapshots"
            )


def main(content: dict, modules: Sequence[str]) -> None:
    """Print a line for each warning; raise ConfigError with a line for each fault. modules: with `chapter_faults`."""
    config, source = WorkflowConfig(**content["config"]), content["source"]
    mills = {name: MillConfig(**mill) for name, mill in content["mills"].items()}
    contacts = {name: ContactConfig(**contact) for name, contact in content["contacts"].items()}
    further = [import_module(name).chapter_faults for name in modules]
    for line in check_before_running(config, mills, contacts, collect_cases(config, source), source, *further):
        print(f"warning: {line}", file=sys.stderr)


if __name__ == "__main__":
    with stop_on_bad_input():
        main(json.load(sys.stdin), sys.argv[1:])
