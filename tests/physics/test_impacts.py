"""Single impacts on a plate, at the stiffness of real materials: closed forms, balances, symmetries, partial slip."""

import math

import numpy as np
import pytest

from millprint.config.contact_set import ContactConfig
from millprint.config.load import check_model, read_yaml
from millprint.dem.simulation import FewBalls
from millprint.validation.setups import Plate, Rebound, impact_duration, partial_slip, sliding
from tests.physics.setups import FewBalls as InBox
from tests.workflow.conftest import ROOT

RADIUS, SPEED, STEPS = 2.5e-3, 3.9, 4000
QUANTITIES = ("normal", "tangential", "spin")


def contact_set(name: str, **changes) -> ContactConfig:
    path = ROOT / f"config/contacts/{name}.yaml"
    return check_model(read_yaml(path), ContactConfig, str(path)).model_copy(update=changes)


ALUMINA = contact_set("alumina_on_glass")


@pytest.fixture(scope="module")
def plate() -> Plate:
    return Plate(RADIUS)


def speeds(angle_deg: float) -> tuple[float, float]:
    return SPEED * math.cos(math.radians(angle_deg)), SPEED * math.sin(math.radians(angle_deg))


def energy(normal: float, tangential: float, spin: float) -> float:
    """Kinetic energy over the mass [J/kg]."""
    return (normal**2 + tangential**2) / 2 + (RADIUS * spin) ** 2 / 5


@pytest.mark.parametrize("angle_deg", [40, 50, 60, 70, 80, 88])
def test_full_sliding_is_that_of_rigid_bodies(plate, angle_deg):
    hit = plate.hit(ALUMINA, *speeds(angle_deg), STEPS)
    form = sliding(ALUMINA, RADIUS, *speeds(angle_deg))
    assert hit.tangential_restitution == pytest.approx(form.tangential_restitution, rel=1e-3)
    assert hit.angle_deg == pytest.approx(form.angle_deg, rel=1e-3)
    # The overlap shortens the lever, by 0.6 % of the radius at 3 m/s.
    assert hit.spin == pytest.approx(form.spin, rel=8e-3)


def test_an_impact_that_sticks_has_no_form_of_full_sliding():
    assert sliding(ALUMINA, RADIUS, *speeds(32)) is None
    assert sliding(ALUMINA, RADIUS, *speeds(33)) is not None


@pytest.mark.parametrize("restitution", [0.5, 0.98, 1.0])
def test_a_normal_impact_has_the_restitution_of_the_contact_set(plate, restitution):
    contact = ALUMINA.model_copy(update={"restitution": restitution})
    hit = plate.hit(contact, SPEED, 0.0, STEPS)
    assert hit.restitution == pytest.approx(restitution, abs=2e-4)
    assert hit.tangential == 0.0 and hit.spin == 0.0


@pytest.mark.parametrize("angle_deg", [2, 10, 20, 30, 45, 80])
def test_no_impact_gains_energy(plate, angle_deg):
    normal, tangential = speeds(angle_deg)
    for solve in (lambda: plate.hit(ALUMINA, normal, tangential, STEPS),
                  lambda: partial_slip(ALUMINA, RADIUS, normal, tangential)):  # fmt: skip
        hit = solve()
        before, after = energy(normal, tangential, 0.0), energy(hit.normal, hit.tangential, hit.spin)
        assert after < before
        assert after > 0.5 * ALUMINA.restitution**2 * normal**2


def test_an_elastic_impact_without_friction_keeps_its_energy(plate):
    contact = ALUMINA.model_copy(update={"restitution": 1.0, "static_friction": 0.0})
    hit = plate.hit(contact, *speeds(30), STEPS)
    assert energy(hit.normal, hit.tangential, hit.spin) == pytest.approx(SPEED**2 / 2, rel=1e-6)
    assert hit.tangential == pytest.approx(speeds(30)[1], rel=1e-12)


@pytest.mark.parametrize("angle_deg", [3, 20, 60])
def test_left_and_right_are_the_same(plate, angle_deg):
    normal, tangential = speeds(angle_deg)
    right, left = (plate.hit(ALUMINA, normal, sign * tangential, STEPS, sign * 50.0) for sign in (1, -1))
    assert left.normal == pytest.approx(right.normal, rel=1e-12)
    assert left.tangential == pytest.approx(-right.tangential, rel=1e-9)
    assert left.spin == pytest.approx(-right.spin, rel=1e-9)


@pytest.mark.parametrize("angle_deg", [4.22, 20.22, 49.6])
def test_the_step_is_small_enough(plate, angle_deg):
    """Half the step changes the rebound by less than a tenth of what was read off the measured figure."""
    coarse, fine = (plate.hit(ALUMINA, *speeds(angle_deg), steps) for steps in (STEPS, 2 * STEPS))
    assert coarse.tangential_restitution == pytest.approx(fine.tangential_restitution, abs=1e-3)


def test_the_angular_momentum_about_the_contact_point_is_kept(plate):
    """The force acts at the contact point, so that R v + 2/5 R^2 w is conserved, but for the overlap's share."""
    for angle in (5, 20, 60):
        hit = plate.hit(ALUMINA, *speeds(angle), STEPS)
        gained = 0.4 * RADIUS * hit.spin
        lost = hit.tangential_before - hit.tangential
        assert gained == pytest.approx(lost, rel=8e-3)


def test_partial_slip_is_full_sliding_at_large_angles_and_rolls_back_below():
    for angle in (45, 70):
        form = sliding(ALUMINA, RADIUS, *speeds(angle))
        hit = partial_slip(ALUMINA, RADIUS, *speeds(angle))
        for name in QUANTITIES:
            assert getattr(hit, name) == pytest.approx(getattr(form, name), rel=1e-3)
    # At medium angles the elastic rim turns the surface velocity round (Maw, Barber and Fawcett 1976).
    assert partial_slip(ALUMINA, RADIUS, *speeds(15)).surface_velocity < 0


def test_partial_slip_has_converged():
    coarse, fine = (
        partial_slip(ALUMINA, RADIUS, *speeds(5), steps, springs) for steps, springs in ((2000, 300), (4000, 600))
    )
    assert coarse.tangential_restitution == pytest.approx(fine.tangential_restitution, abs=5e-4)


def test_an_elastic_impact_depends_on_the_scaled_slope_alone(plate):
    """No length or modulus is left in tangential over mu times normal velocity (Chung and Ooi 2011, test 5)."""
    small, soft = contact_set("steel_elastic"), contact_set("steel_elastic", young_modulus_gpa=2.0, density_kg_m3=1000)
    scaled = []
    for own, contact, normal in ((Plate(1e-5), small, 0.1), (plate, soft, 0.01)):
        scale = contact.static_friction * normal
        scaled.append(own.hit(contact, normal, 3 * scale, STEPS).surface_velocity / scale)
    assert scaled[0] == pytest.approx(scaled[1], rel=5e-3)


def test_the_contact_set_has_the_stiffness_of_the_pair():
    sphere, glass = 380.0, 72.0
    # 1/E* = (1 - nu^2) (1/E1 + 1/E2) and 1/G* = 2 (2 - nu) (1 + nu) (1/E1 + 1/E2).
    assert ALUMINA.young_modulus_gpa == pytest.approx(2 * sphere * glass / (sphere + glass), rel=1e-5)
    nu = ALUMINA.poisson_ratio
    of_pair = 1 / ((1 - nu**2) / sphere + (1 - nu**2) / glass)
    assert ALUMINA.young_modulus_gpa / (2 * (1 - nu**2)) == pytest.approx(of_pair, rel=1e-5)


def test_the_duration_is_that_of_hertz(plate):
    contact = ALUMINA.model_copy(update={"restitution": 1.0})
    duration = impact_duration(contact, RADIUS, SPEED)
    world = FewBalls(
        plate.vessel, contact, [0.0, 0.0, plate.vessel.bounds[0][2] + RADIUS], [0.0, 0.0, -SPEED], None, RADIUS,
        step=duration / STEPS, skin=0.1 * RADIUS, walls=plate.walls,
    )  # fmt: skip
    world.run(2 * duration)
    assert world.contacts["duration_s"].to_numpy() == pytest.approx([duration], rel=2e-3)


def test_angles_of_a_rebound_are_from_the_normal():
    hit = Rebound(1.0, 1.0, 0.5, 0.5, 100.0, 1e-2)
    assert hit.angle_deg == pytest.approx(45.0)
    assert hit.surface_angle_deg == pytest.approx(-45.0)


def test_the_speeds_at_touch_are_those_of_the_surfaces_along_normal_and_surface():
    """On the floor, and of two balls of unequal size; no force acts before they touch, so the speeds are as given."""
    spin = np.array([[0.0, 150.0, 40.0]])
    ball = InBox([[0, 0, 6e-3]], [[0.6, -0.3, -1.0]], spin, gravity=0.0, skin=2e-3)
    ball.run(2e-3)
    (hit,) = ball.contacts.to_dict("records")
    # The lowest point has v + w x (0, 0, -r).
    lowest = np.array([0.6, -0.3]) + np.cross(spin[0], [0, 0, -5e-3])[:2]
    assert (hit["approach_speed_m_s"], hit["slip_speed_m_s"]) == pytest.approx((1.0, np.hypot(*lowest)), rel=1e-6)

    # Side by side along x, 10.1 mm apart: radii of 4 and 6 mm, which touch when they are 10 mm apart.
    places, speeds = [[-5.05e-3, 0, 0.1], [5.05e-3, 0, 0.1]], [[0.5, 0.2, 0.0], [-0.5, -0.1, 0.0]]
    spins = np.array([[0.0, 30.0, -20.0], [0.0, 10.0, 50.0]])
    pair = InBox(places, speeds, spins, radius=[4e-3, 6e-3], gravity=0.0, skin=2e-3)
    pair.run(1e-3)
    (hit,) = pair.contacts.to_dict("records")
    along = np.subtract(*speeds) + np.cross(spins[0], [4e-3, 0, 0]) - np.cross(spins[1], [-6e-3, 0, 0])
    # They pass by each other a little on the way, which turns the normal by 3e-4 / 10.
    assert hit["approach_speed_m_s"] == pytest.approx(1.0, rel=1e-2)
    assert hit["slip_speed_m_s"] == pytest.approx(np.hypot(*along[1:]), rel=2e-2)
