"""Every key simulates a finished case again, but words, drawn facets, kept tolerances, counting and restart files."""

import json

import pytest

from millprint.config.contact_set import ContactConfig
from millprint.config.counting import DEFAULT_RULES, CountingRule
from millprint.config.identity import TOLERANCES, identity, shared_identity, tolerances_of
from millprint.config.included import load_contact, load_mill
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig

MILL, CONTACT, DEM = load_mill("planetary"), load_contact("calibrated"), DemConfig()
CASE = Case(
    mill="planetary", contact="calibrated", ball_diameter_m=0.01, fill_ratio=0.1, speed_hz=5, seed=0, settle_s=0.1,
    discard_s=0.1, window_s=1.0,
)  # fmt: skip
RULES = [*DEFAULT_RULES, CountingRule(name="long", duration_min_s=1e-4)]
BY_FACET = [*DEFAULT_RULES, CountingRule(name="facets", by="facet")]


def changed(model, **values):
    return type(model)(**{**model.model_dump(exclude_none=True), **values})


def geometry(**values) -> MillConfig:
    return changed(MILL, geometry=MILL.geometry.model_dump() | values)


def of(folder, case: Case = CASE, mill: MillConfig = MILL, contact: ContactConfig = CONTACT, dem: DemConfig = DEM):
    return json.dumps(identity(case, shared_identity(mill, contact, dem), dem, folder), sort_keys=True)


@pytest.mark.parametrize(
    "given",
    [
        {"mill": changed(MILL, title="another")},
        {"mill": changed(MILL, source="another")},
        {"mill": geometry(facets=60)},
        {"mill": geometry(fillet_facets=7)},
        {"contact": changed(CONTACT, source="another")},
        {"dem": changed(DEM, restart_interval_s=5.0)},
        {"dem": changed(DEM, runtime_max_h=2.0)},
        # A case has its own durations.
        {"dem": changed(DEM, settle_s=0.3, discard_turns=4, window_s=2.0)},
        {"dem": changed(DEM, counting_rules=RULES)},
        {"dem": changed(DEM, counting_rules=DEFAULT_RULES[:2])},
    ],
)
def test_what_changes_no_number_simulates_nothing(tmp_path, given):
    assert of(tmp_path, **given) == of(tmp_path)


NUMBERS = {
    "time_step_s": 2e-6, "rayleigh_fraction_max": 0.3, "threads": 2, "counting_rules": BY_FACET,
}  # fmt: skip
OF_CONTACT = {
    "density_kg_m3": 7800.0, "restitution": 0.31, "static_friction": 0.2, "rolling_friction": 0.01,
    "young_modulus_gpa": 2.5, "poisson_ratio": 0.3, "wall_restitution": 0.2, "wall_static_friction": 0.1,
    "wall_rolling_friction": 0.02,
}  # fmt: skip
OF_CASE = {
    "ball_diameter_m": 0.009, "fill_ratio": 0.2, "speed_hz": 5.1, "seed": 1, "window_s": 3.0, "rayleigh_fraction": 0.1,
    "snapshot_interval_s": 0.1, "settle_s": 0.2, "discard_s": 0.2, "amplitude_mm": 70.0,
    "density_kg_m3": 5000.0, "power_error_max": 0.1,
}  # fmt: skip


@pytest.mark.parametrize(
    "given",
    [
        *({"dem": changed(DEM, **{key: value})} for key, value in NUMBERS.items()),
        *({"contact": CONTACT.model_copy(update={key: value})} for key, value in OF_CONTACT.items()),
        *({"case": changed(CASE, **{key: value})} for key, value in OF_CASE.items()),
        {"mill": geometry(radius_mm=37.6)},
        {"mill": geometry(faceted=True)},
        {"mill": changed(MILL, volume_ml=251)},
        {"mill": changed(MILL, motion=MILL.motion.model_dump() | {"sun_radius_mm": 99.0})},
    ],
)
def test_what_changes_a_number_simulates_again(tmp_path, given):
    assert of(tmp_path, **given) != of(tmp_path)


def test_facets_that_are_the_wall_or_that_are_counted_simulate_again(tmp_path):
    for dem, faceted in ((DEM, True), (changed(DEM, counting_rules=BY_FACET), False)):
        found = {of(tmp_path, mill=geometry(facets=number, faceted=faceted), dem=dem) for number in (48, 60)}
        assert len(found) == 2


def finished(folder, dem: DemConfig, closure: float, fraction: float | None = None, case: Case = CASE) -> str:
    """What is recorded of a run with these settings that reached a closure, and took a fraction as its step."""
    recorded = of(folder, dem=dem, case=case)
    summary = {"closure": closure, "case": {"rayleigh_fraction": fraction}}
    kept = tolerances_of(case, dem, summary, json.loads(recorded)["tolerances"])
    (folder / TOLERANCES).write_text(json.dumps(kept))
    return recorded


def test_a_tolerance_that_was_kept_simulates_nothing_and_one_that_was_not_simulates_once(tmp_path):
    recorded = finished(tmp_path, DEM, closure=0.002)
    assert of(tmp_path) == recorded
    for kept in ({"closure_max": 0.1}, {"closure_max": 0.002}, {"overlap_max": 0.2}):
        assert of(tmp_path, dem=changed(DEM, **kept)) == recorded
    assert of(tmp_path, case=changed(CASE, closure_max=0.05)) == recorded
    for strict in ({"closure_max": 0.001}, {"overlap_max": 0.1}):
        dem = changed(DEM, **strict)
        assert of(tmp_path, dem=dem) != recorded
    # It is simulated with these, closes better, and is done; back to the first tolerances it stays done.
    again = finished(tmp_path, dem, closure=0.0005)
    assert of(tmp_path, dem=dem) == again == of(tmp_path)


def test_a_step_that_was_shortened_belongs_to_its_tolerance(tmp_path):
    case = changed(CASE, rayleigh_fraction=0.1)
    recorded = finished(tmp_path, DEM, closure=0.002, fraction=0.07, case=case)
    assert of(tmp_path, case=case) == recorded
    assert of(tmp_path, case=case, dem=changed(DEM, closure_max=0.05)) != recorded


def test_a_looser_run_is_not_taken_for_one_that_kept_an_earlier_tolerance(tmp_path):
    finished(tmp_path, DEM, closure=0.002)
    loose = changed(DEM, closure_max=0.05, overlap_max=0.2)
    # The code has changed meanwhile, and the case is simulated with the looser ones.
    recorded = finished(tmp_path, loose, closure=0.03)
    assert of(tmp_path, dem=loose) == recorded != of(tmp_path)
