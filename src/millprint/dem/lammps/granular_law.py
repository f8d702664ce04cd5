"""Our contact law in the words of `pair_style granular`.

- `damping coeff_restitution` is our normal dashpot. Our force may pull before a contact ends, and our Coulomb cap is mu
  times the elastic force, whose impulse is m (1 + e) v; LAMMPS caps at mu times the damped force. With `limit_damping`
  its force never pulls, and its impulse is m (1 + e) v too, if the coefficient is the one with which such a force has
  the restitution e: `damped_coefficient`.
- `tangential mindlin/force NULL x mu` is our spring, and x makes its dashpot that of Eq. 3.9. A spring that is stored
  as a displacement would be drawn backwards by a dashpot above the cap and stick where ours slides.
- `rolling sds` and `twisting sds` resist by a spring, dashpot and slider; the spring is as stiff as the step allows,
  so that the slider's constant torque acts. Its lever is the reduced radius, ours the ball's.

docs/how_to/lammps.md has how near single impacts are.
"""

from functools import lru_cache
from typing import cast

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.dem.laws.record import InLammps, ball_mass, damping_ratio
from millprint.dem.laws.registry import LAWS

# Angle that a ball's rolling spring swings through in a step [rad].
ROLLING_PHASE = 0.2
# The smallest coefficient that is tried.
LEAST = 1e-4
REMEDY = "take dem.engine: numba for it"


def law_for(kind: str) -> tuple[float, InLammps]:
    """The power of the overlap in the normal force of a law, and its words. Raises ConfigError for one without any."""
    law = LAWS.get(kind)
    if law is None or law.lammps is None:
        known = ", ".join(name for name, each in LAWS.items() if each.lammps)
        raise ConfigError(f"kind = {kind}: LAMMPS gets {known}; {REMEDY}")
    return law.overlap_power - 1, law.lammps


def restitution_without_pull(coefficient: float, kind: str) -> float:
    """The restitution of an impact whose damped force x^p + c x^((p - 1) / 2) v, of `coefficient`, may not pull."""
    from scipy.integrate import solve_ivp

    if coefficient == 1:
        return 1.0
    power, own = law_for(kind)
    damping = -damping_ratio(coefficient) * own.damping

    def force(_: float, y: tuple[float, float]) -> float:
        overlap = max(y[0], 0.0)
        return float(overlap**power + damping * overlap ** ((power - 1) / 2) * y[1])

    force.terminal, force.direction = True, -1  # type: ignore[attr-defined]
    found = solve_ivp(
        lambda t, y: (y[1], -force(t, y)), (0, 1e3), (1e-9, 1.0), rtol=1e-9, atol=1e-13, events=force, max_step=0.1
    )
    return float(-found.y[1, -1])


@lru_cache(maxsize=64)
def damped_coefficient(restitution: float, kind: str) -> float:
    """The coefficient with which LAMMPS's force that may not pull has a restitution. Raises ConfigError below any."""
    # Slow to import, and the Snakefile imports this module.
    from scipy.optimize import brentq

    if restitution == 1:
        return 1.0
    least = restitution_without_pull(LEAST, kind)
    if restitution <= least:
        raise ConfigError(
            f"restitution = {restitution:g}: a force of LAMMPS that never pulls has {least:.2g} at least; "
            "take a larger one, or dem.engine: numba"
        )
    return cast(float, brentq(lambda own: restitution_without_pull(own, kind) - restitution, LEAST, 1.0))


def law_text(contact: ContactConfig, radius: float, step_s: float, lever: float) -> str:
    """The law of equal balls of a radius [m] at a step [s]; lever: that radius over the reduced one [-]."""
    coefficient = damped_coefficient(contact.value_of("restitution"), contact.kind)
    words = law_for(contact.kind)[1].words(contact, coefficient, contact.value_of("static_friction"))
    if contact.rolling_friction:
        # Of a ball on a wall, I w^2 = k R^2 with w = ROLLING_PHASE / step and I = 2/5 m R^2; damped to a half.
        inertia = 0.4 * ball_mass(contact, radius)
        stiffness, damping = inertia * (ROLLING_PHASE / step_s) ** 2, inertia * ROLLING_PHASE / step_s
        words.append(f"rolling sds {stiffness!r} {damping!r} {contact.rolling_friction * lever!r}")
        arm = radius**2
        words.append(f"twisting sds {stiffness * arm!r} {damping * arm!r} {contact.rolling_friction * radius!r}")
    return " ".join([*words, "damping coeff_restitution limit_damping"])
