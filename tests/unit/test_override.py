"""A sweep over amplitude or density: its cases, their names, what they change, and what is refused."""

import pytest

from millprint.config.errors import ConfigError
from millprint.config.included import load_contact, load_mill
from millprint.config.load import check_model
from millprint.config.mill import MillConfig
from millprint.config.sweep import DemConfig, SweepConfig, expand_sweep, overridden
from millprint.dem.simulation import Simulation

MILL = load_mill("emax")
CONTACT = load_contact("calibrated")
DEM = DemConfig(time_step_s=2e-6, settle_s=0.01, window_s=0.01)
BLOCK = {
    "name": "block",
    "contacts": ["calibrated"],
    "ball_diameters_mm": [10],
    "fill_ratios": [0.04],
    "speeds_rpm": [600],
    "seeds": [0],
}


def cases_of(**keys):
    return expand_sweep(SweepConfig(**BLOCK, **keys), DEM, "emax")


def test_every_combination_has_a_case_and_a_name_of_its_own():
    cases = cases_of(amplitudes_mm=[14, 20.5], densities_kg_m3=[3900, 15000])
    assert [case.name for case in cases] == [
        "d10_f0.04_n600_a14_rho3900_s0",
        "d10_f0.04_n600_a14_rho15000_s0",
        "d10_f0.04_n600_a20.5_rho3900_s0",
        "d10_f0.04_n600_a20.5_rho15000_s0",
    ]
    assert cases_of()[0].name == "d10_f0.04_n600_s0"


def test_a_simulation_runs_with_the_amplitude_and_density_of_its_case():
    plain, changed = (Simulation(case, MILL, CONTACT, DEM) for case in (
        cases_of()[0], cases_of(amplitudes_mm=[20], densities_kg_m3=[15400])[0],
    ))  # fmt: skip
    for simulation, amplitude_m in ((plain, 0.017), (changed, 0.020)):
        assert simulation.motion.position(0.0) == pytest.approx([amplitude_m, 0, 0])
    assert changed.balls.mass[0] == pytest.approx(2 * plain.balls.mass[0])
    # Denser balls have a longer Rayleigh time, with the root of the density.
    assert changed.step_scale_s == pytest.approx(2**0.5 * plain.step_scale_s)
    assert changed.mill.geometry == MILL.geometry and changed.contact.restitution == CONTACT.restitution


def test_the_sun_wheel_of_a_planetary_mill_is_its_amplitude():
    law = {"kind": "planetary", "sun_radius_mm": 120, "ratio": -2}
    mill = check_model({**MILL.model_dump(), "motion": law}, MillConfig, "planetary.yaml")
    changed, _ = overridden(cases_of(amplitudes_mm=[100])[0], mill, CONTACT)
    assert changed.motion.sun_radius_mm == 100 and changed.motion.ratio == -2


def test_a_motion_without_an_amplitude_is_refused_in_one_line(monkeypatch):
    drum = check_model({**MILL.model_dump(), "motion": {"kind": "rotation", "axis": [1, 0, 0]}}, MillConfig, "x")
    with pytest.raises(ConfigError, match="motion of mill emax is a rotation, which has no amplitude"):
        overridden(cases_of(amplitudes_mm=[14])[0], drum, CONTACT)
    with pytest.raises(ConfigError, match=r"amplitudes_mm = 99999 of mill emax: input should be less than"):
        overridden(cases_of(amplitudes_mm=[99999])[0], MILL, CONTACT)
