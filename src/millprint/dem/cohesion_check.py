"""Whether the springs of a contact set carry its cohesion: at rest, a pull presses two bodies into each other."""

import math
from itertools import combinations_with_replacement

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import SimulationError
from millprint.dem.laws.record import ball_mass
from millprint.dem.laws.registry import law_of


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
