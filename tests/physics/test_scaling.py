"""The scaling of descriptors (Eqs 3.28, 3.29) where mechanics makes it exact: similar mills have equal descriptors."""

from pathlib import Path

import pytest

from millprint.config.contact_set import ContactConfig
from millprint.config.counting import CountingRule
from millprint.config.load import load_named
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.run import run_case
from millprint.fingerprint.descriptors import tabulate_descriptors

CONFIG = Path(__file__).parents[2] / "config"
GAP_TURNS = 0.04
SCALED = ("Pn", "Pt", "f", "ratio", "En", "Et", "En_star", "Et_star", "fn_star", "ft_star", "f90")


def descriptors(folder, length=1, density=1):
    """Descriptors of a short run of a mill `length` times as large, of balls `density` times as heavy.

    Froude similarity: times grow with the root of the length and stresses with density times length, so every force
    keeps its share and the motion is the same in scaled units. Factors of two keep most of the rounding of floats too,
    so one revolution agrees to seven digits; after three, chaos has made its last digits into other trajectories.
    """
    mill = load_named(CONFIG / "mills", "emax", MillConfig, "mill")
    contact = load_named(CONFIG / "contacts", "calibrated", ContactConfig, "contact set")
    root = length**0.5
    shape = mill.geometry.model_copy(
        update={
            name: getattr(mill.geometry, name) * length
            for name in ("end_radius_mm", "straight_mm", "height_mm", "fillet_radius_mm")
        }
    )
    motion = mill.motion.model_copy(update={"amplitude_mm": mill.motion.amplitude_mm * length})
    mill = mill.model_copy(update={"geometry": shape, "motion": motion, "volume_ml": mill.volume_ml * length**3})
    contact = contact.model_copy(
        update={
            "density_kg_m3": contact.density_kg_m3 * density,
            "young_modulus_gpa": contact.young_modulus_gpa * density * length,
        }
    )
    settings = DemConfig(
        time_step_s=2.0**-18 * root,
        # A power of two too: rounding is the same.
        run_up_fraction=0,
        settle_s=0.05 * root,
        window_s=0.05 * root,
        counting_rules=[CountingRule(name="merged", gap_turns=GAP_TURNS)],
    )
    case = Case(
        mill="emax",
        contact="calibrated",
        ball_diameter_m=10.0 * length / 1e3,
        fill_ratio=0.06,
        speed_hz=1200.0 / root / 60,
        seed=3,
        settle_s=settings.settle_s,
        discard_s=0.0,
        window_s=settings.window_s,
    )
    summary = run_case(case, mill, contact, settings, folder / "run.h5", folder / "summary.json")
    return tabulate_descriptors([summary], "merged").iloc[0]


@pytest.fixture(scope="module")
def base(tmp_path_factory):
    return descriptors(tmp_path_factory.mktemp("base"))


def test_power_is_proportional_to_density(base, tmp_path):
    heavy = descriptors(tmp_path, density=2)
    assert heavy["normal_power_W"] == pytest.approx(2 * base["normal_power_W"], rel=1e-9)
    for name in SCALED:
        assert heavy[name] == pytest.approx(base[name], rel=1e-9)


@pytest.mark.slow
def test_a_mill_four_times_as_large_has_the_same_descriptors(base, tmp_path):
    large = descriptors(tmp_path, length=4)
    # rho omega^3 A^2 d^3 grows by 1/8 * 16 * 64.
    assert large["tangential_power_W"] == pytest.approx(128 * base["tangential_power_W"], rel=1e-5)
    for name in SCALED:
        assert large[name] == pytest.approx(base[name], rel=1e-5)
