"""Predictions for drums of flowing beds, from made-up runs whose surface and speeds are known."""

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.load import read_yaml
from millprint.config.mill import MillConfig
from millprint.config.setup_models import FILES, setup_cases
from millprint.config.sweep import DemConfig
from millprint.run.hdf5 import whole_hdf5
from millprint.validation import drums
from millprint.validation.measured import DEM, PLACE_COLUMNS, Inputs, check_predictions
from tests.unit.test_validation_flowing_bed import RATE, ZERO, bed

SHOTS, BALLS = 8, 6000
# Angle of the surface by contact set [deg].
ANGLES = {"glass_beads": 25.0, "glass_beads_clean": 20.0, "glass_beads_worn": 32.0, "generic_spheres": 28.0}


def write_bed(path: Path, slope_deg: float, seed: int) -> None:
    places, velocities = bed(slope_deg, SHOTS * BALLS, seed)
    across = np.random.default_rng(seed).uniform(-0.012, 0.012, SHOTS * BALLS)
    path.parent.mkdir(parents=True)
    with whole_hdf5(path) as file:
        for name, values, along in (("position_m", places, across), ("velocity_m_s", velocities, 0 * across)):
            whole = np.column_stack([values[:, 0], along, values[:, 1]]).reshape(SHOTS, BALLS, 3)
            file.create_dataset(f"snapshots/{name}", data=whole)


def inputs_of(settings, runs: Path, places: list[tuple], **changes) -> Inputs:
    """The inputs of a set-up, with a made-up run for each of its cases."""
    dem = DemConfig()
    cases = setup_cases(settings, dem)
    for seed, (path, case) in enumerate(cases.items()):
        if not (runs / path).exists():
            write_bed(runs / path / "run.h5", ANGLES[case.contact], seed)
    mill = MillConfig(**read_yaml(f"config/mills/{settings.mill}.yaml"))
    contacts = {name: ContactConfig(**read_yaml(f"config/contacts/{name}.yaml")) for name in settings.contact_names}
    given = {"settings": settings, "mill": mill, "contacts": contacts, "dem": dem, "cases": cases, "runs": runs}
    return Inputs(**{**given, **changes}, places=pd.DataFrame(places, columns=list(PLACE_COLUMNS)))


BEAD_PLACES = [
    ("4a", drums.FLOW_SPEED, "m/s", -0.045),
    ("4a", drums.FLOW_SPEED, "m/s", -0.0901),
    ("4a", drums.FLOW_SPEED, "m/s", 0.05),
    ("4b", drums.SURFACE_ANGLE, "deg", math.nan),
    ("4c", drums.STILL_PLACE, "m", math.nan),
]


@pytest.mark.slow
def test_the_drum_of_beads_is_predicted_at_every_measured_place_that_holds_beads(tmp_path):
    settings = FILES["bead_drum"].read(further_contacts=["glass_beads_clean", "glass_beads_worn"])
    inputs = inputs_of(settings, tmp_path, BEAD_PLACES)
    table = check_predictions(drums.predict_bead_drum(inputs), "bead_drum")
    dem = table[table["model"] == DEM]
    angle, zero = (dem[dem["id"] == id].iloc[0] for id in ("4b", "4c"))
    assert angle["predicted"] == pytest.approx(25.0, abs=0.4)
    # The other contact sets reach from 20 to 32 degrees in the short slice.
    assert angle["lower"] == pytest.approx(20.0, abs=1.5)
    assert angle["upper"] == pytest.approx(32.0, abs=1.5)
    assert zero["predicted"] == pytest.approx(ZERO, abs=1e-3)
    speeds = dem[dem["id"] == "4a"]
    assert speeds["x"].tolist() == [-0.0901, -0.045]
    assert speeds["predicted"].tolist() == pytest.approx([RATE * (-0.0901 - ZERO), RATE * (-0.045 - ZERO)], abs=0.02)
    assert ((dem["lower"] <= dem["predicted"]) & (dem["predicted"] <= dem["upper"])).all()
    turning = table[(table["model"] == drums.TURNING) & (table["x"] == -0.0901)].iloc[0]
    assert turning["predicted"] == pytest.approx(-0.0901 * 11.6 * 2 * math.pi / 60)


@pytest.mark.slow
def test_without_further_contact_sets_the_interval_is_scatter_alone(tmp_path):
    table = drums.predict_bead_drum(inputs_of(FILES["bead_drum"].read(further_contacts=[]), tmp_path, BEAD_PLACES))
    angle = table[(table["id"] == "4b") & (table["model"] == DEM)].iloc[0]
    assert angle["interval"] == "scatter of blocks of time"
    assert 0 < angle["upper"] - angle["lower"] < 2


def test_the_angle_of_repose_spans_what_contact_parameters_change_in_slices(tmp_path, monkeypatch):
    changes = iter([30.0, 24.0, 33.0])
    monkeypatch.setattr(drums, "_slice_angle", lambda *_: {"angle_deg": next(changes)})
    settings = FILES["repose_drum"].read(samples=2, surface_share=0.8)
    places = [("7", drums.REPOSE, "deg", math.nan)]
    table = check_predictions(drums.predict_repose_drum(inputs_of(settings, tmp_path, places)), "repose_drum")
    row = table[table["model"] == DEM].iloc[0]
    assert row["id"] == "7"
    assert row["predicted"] == pytest.approx(28.0, abs=0.5)
    scatter = row["upper"] - row["predicted"] - 3
    assert 0 < scatter < 1
    assert row["predicted"] - row["lower"] == pytest.approx(6 + scatter)


def test_a_mill_that_is_no_cylinder_is_refused(tmp_path):
    box = MillConfig(**read_yaml("config/mills/mixer.yaml")).model_copy(update={"name": "bead_drum"})
    geometry = MillConfig(**read_yaml("config/mills/slice_mill.yaml")).geometry
    inputs = inputs_of(
        FILES["bead_drum"].read(), tmp_path, BEAD_PLACES, mill=box.model_copy(update={"geometry": geometry})
    )
    with pytest.raises(ConfigError, match="bead_drum: must be a cylinder about the axis y"):
        drums.predict_bead_drum(inputs)
