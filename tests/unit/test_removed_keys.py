"""A key that was removed is refused with one line that says what is fixed in its place."""

import re
from pkgutil import resolve_name

import pytest
from snakemake.utils import update_config
from tools.write_reference import MODELS

from millprint.config.calibration import SwingConfig
from millprint.config.document import sections
from millprint.config.errors import ConfigError
from millprint.config.fingerprint import ConvergenceConfig, StudyConfig
from millprint.config.load import check_model
from millprint.config.removed import REMOVED, what_became_of
from millprint.config.workflow import WorkflowConfig
from millprint.dose.heat_table import AT_REST
from tests.conftest import ROOT, configuration

# Where the values are today, unless they are constants of the section.
FIXED = {
    "convergence.closure_max": "dem.step_choice.CLOSURE_MAX",
    "convergence.confidence": "dem.step_choice.CONFIDENCE",
    "convergence.study.confidence": "fingerprint.study.CONFIDENCE",
    "dem.collision_rows_max": "dem.resources.COLLISION_ROWS_MAX",
    "dem.occupancy_cell_m": "dem.case_cost.OCCUPANCY_CELL_M",
    "dem.occupancy_interval_s": "dem.case_cost.OCCUPANCY_INTERVAL_S",
    "dem.skin_share": "dem.timestep.SKIN_SHARE",
    "dose.heat.times": "dose.heat_table.TIMES",
    "dose.wear.fill_tolerance": "dose.wear.FILL_TOLERANCE",
    "dose.wear.probability": "dose.wear.PROBABILITY",
    "mills.collapse_max": "fingerprint.mill_collapse.COLLAPSE_MAX",
    "mills.scale_up.run_settle_s": "cases.large_mill.LARGE_SETTLE_S",
    "mills.scale_up.run_turns": "cases.large_mill.LARGE_TURNS",
    "uncertainty.closure_max": "cases.of_mill.SAMPLE_CLOSURE_MAX",
    "view.frames_per_second": "view.frames.FRAMES_PER_SECOND",
}


CONSTANTS = [
    f"{place}.{name}"
    for place, model in sections(MODELS["config"])
    for name in model.__class_vars__
    if place and " (" not in place and not place.startswith("sweep")
]


def written(value) -> str:
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(written, value))}]"
    return format(value, "g") if isinstance(value, float) else str(value)


@pytest.mark.parametrize(("key", "place"), FIXED.items())
def test_the_table_has_the_values_that_are_fixed(key, place):
    assert REMOVED[key] == f"fixed at {written(resolve_name(f'millprint.{place}'))}"


def test_a_constant_of_a_section_is_refused_with_its_value():
    assert len(CONSTANTS) > 50
    known = {key: what_became_of(key, dict(sections(MODELS["config"]))[key.rpartition(".")[0]]) for key in CONSTANTS}
    assert known["yields.evaluation.nominal"] == "fixed at [0.5, 0.8, 0.95]"
    assert known["partition.enthalpy_kJ_mol"] == "fixed at 1226" and known["claims.seed"] == "fixed at 0"
    assert known["dose.heat.parameters.heat_share"] == "fixed, in millprint.config.dose"


@pytest.mark.parametrize(
    ("caption", "shown"),
    [
        ("timestep", f"{ConvergenceConfig.tolerance_percent:g} %"),
        ("study", f"{StudyConfig.tolerance_percent:g} %"),
        ("friction_fit", f"{SwingConfig.noise_mm:g} mm"),
    ],
)
def test_a_caption_states_the_value_that_is_fixed(caption, shown):
    assert f" of {shown}" in (ROOT / f"workflow/report/{caption}.rst").read_text()


def test_the_table_has_the_other_values_that_are_fixed():
    from millprint.cases.of_mill import FACTORS
    from millprint.dose.spectra import BIN_EDGES

    for name, factors in FACTORS.items():
        assert REMOVED[f"convergence.study.{name}"] == f"fixed at [{', '.join(f'{each:g}' for each in factors)}]"
    for kind, resting in AT_REST.items():
        assert REMOVED[f"dose.heat.surroundings.{kind}.at_rest"] == f"fixed at {resting}"
    assert (BIN_EDGES[0], BIN_EDGES[-1], round((BIN_EDGES[5] / BIN_EDGES[0]), 9)) == (1e-12, 10, 10)


@pytest.mark.parametrize("key", [*REMOVED, *CONSTANTS])
def test_a_removed_key_is_refused_in_one_line_and_is_not_a_key(key):
    *outer, own = key.split(".")
    content = {own: 7}
    for name in reversed(outer):
        content = {name: [{"name": "a", **content}] if name == "sweeps" else content}
    thesis = configuration()
    update_config(thesis, content)
    with pytest.raises(ConfigError) as info:
        check_model(thesis, WorkflowConfig, "my.yaml")
    (line,) = [line for line in str(info.value).splitlines() if "removed" in line]
    fixed = re.escape(REMOVED[key]) if key in REMOVED else "fixed.+"
    assert re.match(rf"my.yaml: .*{own} = 7: this key was removed \({fixed}\); delete it$", line)
    keys = {f"{place}.{name}" for place, model in sections(MODELS["config"]) for name in model.model_fields}
    assert key not in keys
