"""The contact cases of tests/physics/cases against their closed forms, as set up and in a turned frame."""

from functools import cache

import numpy as np
import pytest

from tests.physics.closed_forms import CLOSED_FORMS, pair_of, slides_throughout
from tests.physics.contact_cases import FOLDER, ContactCase, load_cases
from tests.physics.contact_run import TURNED, UPRIGHT, Outcome, balance_error, measure, run_case

FILES = sorted(FOLDER.glob("*.yaml"))
POINTS = {f"{path.stem}-{label}": case for path in FILES for label, case in load_cases(path)}
FRAMES = {"upright": UPRIGHT, "turned": TURNED}
# Impacts on the wall from near normal to grazing, in order of slip over approach speed.
SWEEPS = ("chung_ooi_4_oblique_angle", "chung_ooi_5_tangential_velocity", "chung_ooi_6_spin_wall")


@cache
def outcome_of(point: str, frame: str = "upright") -> Outcome:
    """The run of one point; kept, since several tests look at it."""
    return run_case(POINTS[point], FRAMES[frame])


def points_of(name: str) -> list[str]:
    """The points of one case."""
    return [point for point, case in POINTS.items() if case.name == name]


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("point", POINTS)
@pytest.mark.slow
def test_a_case_ends_as_in_its_closed_form(point, frame):
    case, outcome, failures = POINTS[point], outcome_of(point, frame), []
    for check in case.checks:
        expected = CLOSED_FORMS[check.form](case)
        # A form that does not hold in this regime gives nothing.
        for quantity, bound in check.bounds.items() if expected else ():
            measured = measure(case, outcome, quantity)
            error, allowed = float(np.abs(measured - expected[quantity]).max()), bound.allowed(expected[quantity])
            if not error <= allowed:
                failures.append(
                    f"{check.form}.{quantity}: {measured} for {expected[quantity]}, off by {error:.3g} > {allowed:.3g}"
                )
    assert not failures, "\n".join(failures)


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("point", POINTS)
def test_the_energy_balance_of_a_case_closes(point, frame):
    """At every sample, and no channel that only ever takes energy gives any back."""
    case, outcome = POINTS[point], outcome_of(point, frame)
    assert balance_error(outcome) <= case.balance
    taken = outcome.ledger[["normal_damping_J", "tangential_damping_J", "rolling_J"]].to_numpy()
    # A normal force that damps also pulls: its work is a square all the same.
    assert (np.diff(taken, axis=0) >= -1e-15 * taken.max()).all()


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_closed_form_of_a_case_is_met_at_some_point(path):
    cases = [case for _, case in load_cases(path)]
    for check in cases[0].checks:
        assert any(CLOSED_FORMS[check.form](case) is not None for case in cases), check.form


def test_every_closed_form_has_a_case():
    used = {check.form for case in POINTS.values() for check in case.checks}
    assert used == set(CLOSED_FORMS)


def slip_of(case: ContactCase, velocity: np.ndarray, spin: np.ndarray) -> float:
    """Tangential velocity at the contact point of a ball on the wall, the lever taken as the radius [m/s]."""
    return float(velocity[0, 0] - case.radius[0] * spin[0, 1])


@pytest.mark.parametrize("name", SWEEPS)
@pytest.mark.slow
def test_friction_takes_more_impulse_the_more_slip_up_to_coulombs_bound(name):
    """J_t <= mu (1 + e) m v, met by every impact that slides throughout; monotone in u / (mu v)."""
    rows = []
    for point in points_of(name):
        case, outcome = POINTS[point], outcome_of(point)
        (mass,), speed = case.mass, -case.velocity[0, 2]
        impulse = mass * abs(outcome.velocity[0, 0] - case.velocity[0, 0])
        bound = case.material.static_friction * (1 + case.material.restitution) * mass * speed
        slip = abs(slip_of(case, case.velocity, case.spin)) / speed
        rows.append((slip, impulse / bound, slides_throughout(case)))
    rows.sort()
    slip, share, slides = (np.array(column) for column in zip(*rows, strict=True))
    assert (share <= 1 + 1e-4).all()
    assert share[slides] == pytest.approx(1, abs=1e-4)
    assert (share[~slides] < 1 - 1e-3).all()
    assert (np.diff(share[~slides]) > 0).all()
    # Towards normal impact the impulse vanishes with the slip: it is at most that which would turn the slip round.
    assert slides.any()
    assert share[0] < 0.1 + 0.5 * slip[0]


@pytest.mark.parametrize("name", SWEEPS)
def test_friction_never_gives_energy_to_the_tangential_motion(name):
    """Sticking may return what the spring held, never more, however little slip there was."""
    for point in points_of(name):
        case, outcome = POINTS[point], outcome_of(point)
        (mass,), (inertia,) = case.mass, case.inertia

        def energy(velocity, spin, mass=mass, inertia=inertia) -> float:
            return 0.5 * mass * velocity[0, 0] ** 2 + 0.5 * inertia * spin[0, 1] ** 2

        before = energy(case.velocity, case.spin)
        assert energy(outcome.velocity, outcome.spin) < before * (1 + 1e-9), point
        work = outcome.ledger[["tangential_damping_J", "sliding_J"]].iloc[-1].sum()
        assert work == pytest.approx(before - energy(outcome.velocity, outcome.spin), abs=1e-3 * before)


@pytest.mark.parametrize("name", SWEEPS)
def test_the_regime_tells_whether_the_contact_ever_sticks(name):
    """Sliding throughout: no work of the dashpot, and no slip against the friction but the spring's own recoil."""
    for point in points_of(name):
        case, outcome = POINTS[point], outcome_of(point)
        sense = np.sign(slip_of(case, case.velocity, case.spin))
        left = sense * slip_of(case, outcome.velocity, outcome.spin)
        damping = outcome.ledger["tangential_damping_J"].iloc[-1]
        if slides_throughout(case):
            pair = pair_of(case)
            assert damping == 0
            assert left >= -pair.mu * pair.kn / pair.kt * abs(case.velocity[0, 2])
        else:
            assert left < sense * slip_of(case, case.velocity, case.spin)
            assert (damping > 0) == (case.material.restitution < 1)


def test_spheres_that_part_have_given_each_other_the_same_spin():
    """Equal spheres: friction adds as much spin to the one as to the other, whatever the regime."""
    for point in points_of("chung_ooi_7_spin_equal_pair"):
        case, outcome = POINTS[point], outcome_of(point)
        gained = outcome.spin - case.spin
        assert gained[0] == pytest.approx(gained[1], abs=1e-9)
