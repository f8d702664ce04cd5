"""The step of a case, as a fraction of the time of its contact law; and whether its springs carry its cohesion."""

import math
from collections.abc import Iterable, Mapping
from itertools import combinations_with_replacement

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import SimulationError
from millprint.config.sweep import Case, DemConfig
from millprint.dem.laws.record import ball_mass
from millprint.dem.laws.registry import law_of, step_scale

# The skin over the smallest ball's radius and the root of the step over the Rayleigh time [-].
SKIN_SHARE = 1.5
# The longest step of which nothing is recorded, over the recorded one.
LONGEST_RUN_UP = 4


def aligned_step(longest_s: float, interval_s: float) -> tuple[float, int]:
    """The largest step [s] up to `longest_s` of which a whole number makes `interval_s`, and that number."""
    steps = max(1, math.ceil(interval_s / longest_s - 1e-9))
    return interval_s / steps, steps


def requested_step(case: Case, dem: DemConfig, scale_s: float) -> float:
    """The requested step of a case [s]: its own, its fraction of the law's scale, or that of `dem`."""
    if case.time_step_s:
        return case.time_step_s
    if case.rayleigh_fraction:
        return case.rayleigh_fraction * scale_s
    return dem.time_step_s


def run_up_step(case: Case, dem: DemConfig, scale_s: float) -> float:
    """The requested step while balls settle and until the window begins [s], of which nothing is recorded.

    `dem.run_up_fraction` of the law's scale, and one to LONGEST_RUN_UP times the recorded one: where balls are so soft
    or fast that this has to be short, a far longer one is too long. A case with snapshots has one step: its motion,
    which other runs go on from, does not depend on when its window begins.
    """
    recorded = requested_step(case, dem, scale_s)
    if case.snapshot_interval_s:
        return recorded
    longer = min(dem.run_up_fraction, dem.rayleigh_fraction_max) * scale_s
    return min(max(recorded, longer), LONGEST_RUN_UP * recorded)


def longest_step(
    ball_diameter_m: float, cases: Iterable[Case], contacts: Mapping[str, ContactConfig], dem: DemConfig
) -> float:
    """The longest requested step [s] of the cases with balls of a diameter [m] and the density of their contact set.

    That of `dem` if there are none.
    """
    steps = []
    for case in cases:
        if (case.ball_diameter_m, case.mixture, case.density_kg_m3) == (ball_diameter_m, None, None):
            scale_s = step_scale(contacts[case.contact], ball_diameter_m / 2)
            steps.append(requested_step(case, dem, scale_s))
    return max(steps, default=dem.time_step_s)


def largest_fraction(case: Case, dem: DemConfig) -> float:
    """The largest step that is allowed for a case, over its scale [-]."""
    return case.rayleigh_fraction_max or dem.rayleigh_fraction_max


def skin_of(radius_m: float, step_over_scale: float) -> float:
    """The skin of the lists of candidates [m]: SKIN_SHARE R sqrt(step / scale). A contact is listed at a smaller gap.

    Lists are made again when a ball has moved by half the skin, so that their cost in a step goes with step / skin.
    That of going through them goes with their length, and so with skin / R. The sum is least where the skin goes with
    the root of R times the step, and the Rayleigh time goes with R.
    """
    return SKIN_SHARE * radius_m * math.sqrt(step_over_scale)


def resolved_step(contact: ContactConfig, radius_m: float, wanted_s: float, rayleigh_fraction_max: float) -> float:
    """The requested step [s], or a shorter one if the law requires it for a ball."""
    return min(wanted_s, rayleigh_fraction_max * step_scale(contact, radius_m))


def check_cohesion(contact: ContactConfig, radii_m: list[float], overlap_max: float) -> None:
    """Check that no pull presses balls of these radii [m] farther than the bound, over the smaller radius [-].

    Raises SimulationError that names the key, and the largest value that the springs carry.
    """
    if contact.cohesion is None:
        return
    pairs = [("ball_ball", a, b, a * b / (a + b)) for a, b in combinations_with_replacement(radii_m, 2)]
    for pair, a, b, radius in [*pairs, *(("ball_wall", a, math.inf, a) for a in radii_m)]:
        law, pull, limit = law_of(contact), contact.cohesion.pull_N(pair, radius), overlap_max * min(a, b)
        carried = law.springs(limit, *law.coefficients(contact, radius, ball_mass(contact, min(a, b))))[0]
        if pull > carried:
            key = f"{pair}_N" if getattr(contact.cohesion, f"{pair}_N") is not None else f"{pair}_J_m2"
            value = getattr(contact.cohesion, key)
            raise SimulationError(
                f"contact set {contact.name}: cohesion.{key} = {value:g}: its pull of {pull:.3g} N presses a ball of "
                f"{2e3 * min(a, b):g} mm in by more than dem.overlap_max = {overlap_max:g} of its radius; at most "
                f"{value * carried / pull:.3g} with these springs"
            )
