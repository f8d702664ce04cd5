"""The closed forms against each other, where two of them hold: the reference must be right first."""

import numpy as np
import pytest

from tests.physics.closed_forms import CLOSED_FORMS, HERTZ_DURATION, approach_of, pair_of, slides_throughout
from tests.physics.contact_cases import FOLDER, load_cases
from tests.physics.planar_impact import NORMAL_WORK, RADIAL, SPIN_1, TANGENTIAL, Pair, solve_impact


@pytest.fixture(scope="module")
def base():
    """One oblique impact on the wall."""
    return next(load_cases(FOLDER / "sliding_impulse.yaml"))[1]


def change(case, velocity=None, spin=None, **material):
    """The case with another velocity, spin or material."""
    ball = case.balls[0].model_copy(
        update={"velocity_m_s": velocity or case.balls[0].velocity_m_s, "spin_rad_s": spin or (0, 0, 0)}
    )
    return case.model_copy(update={"balls": (ball,), "material": case.material.model_copy(update=material)})


def test_duration_of_a_hertz_impact_is_the_textbooks():
    assert pytest.approx(2.94328, abs=5e-6) == HERTZ_DURATION


@pytest.mark.parametrize("restitution", [0.1, 0.3, 0.68, 0.98])
def test_the_damped_oscillator_and_the_equations_of_motion_agree(base, restitution):
    case = change(base, (0, 0, -1.0), restitution=restitution)
    expected = CLOSED_FORMS["damped_hertz_impact"](case)
    end, duration = solve_impact(pair_of(case), 1.0, 0.0, (0.0, 0.0))
    assert end[RADIAL] == pytest.approx(restitution, rel=1e-8)
    assert duration == pytest.approx(float(expected["duration_s"]), rel=1e-8)
    assert end[NORMAL_WORK] == pytest.approx(float(expected["normal_damping_J"]), rel=1e-8)


def test_without_damping_the_damped_oscillator_is_hertz(base):
    case = change(base, (0, 0, -2.0), restitution=1.0)
    damped, hertz = (CLOSED_FORMS[name](case) for name in ("damped_hertz_impact", "hertz_impact"))
    for quantity in ("velocity_m_s", "peak_overlap_m", "duration_s", "normal_damping_J"):
        assert damped[quantity] == pytest.approx(hertz[quantity], rel=1e-10, abs=1e-30)


@pytest.mark.parametrize("restitution", [0.3, 1.0])
def test_the_equations_of_motion_slide_throughout_in_the_sliding_regime(base, restitution):
    """At the boundary of the regime the impulse departs from mu (1 + e) m v. Stiff, so that levers are the radii."""
    stiff = change(base, restitution=restitution, young_modulus_gpa=2e7)
    pair, mu = pair_of(stiff), stiff.material.static_friction
    edge = mu * (3.5 * (1 + restitution) - (pair.kn / pair.kt if restitution == 1 else 0))
    for factor, slides in ((0.9, False), (0.97, False), (1.001, True), (1.5, True)):
        case = change(stiff, (factor * edge, 0, -1.0))
        assert slides_throughout(case) == slides
        end, _ = solve_impact(pair, *approach_of(case)[:2], (0.0, 0.0))
        lost = factor * edge - end[TANGENTIAL]
        assert (lost == pytest.approx(mu * (1 + restitution), rel=1e-6)) == slides


def test_much_friction_and_no_damping_keep_the_energy_of_a_small_slip():
    """Sticking without loss: what the slip had comes back, but for what the spring gives up as the overlap recedes."""
    pair = Pair((5e-3, np.inf), (4e-3, np.inf), (4e-8, np.inf), 1e8, 1.2e8, 0.0, 0.0, 1e3)
    end, _ = solve_impact(pair, 1.0, 0.01, (0.0, 0.0))
    before, after = 0.5 * 4e-3 * 0.01**2, 0.5 * 4e-3 * end[TANGENTIAL] ** 2 + 0.5 * 4e-8 * end[SPIN_1] ** 2
    assert 0.5 * before < after <= before * (1 + 1e-9)
