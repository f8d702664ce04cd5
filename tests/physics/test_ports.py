"""Ports and bosses in round mantles: exact to the edge, which is the curve of both surfaces and not its drawing.

The closed form of `tests.ports` shares no code with the walls.
"""

from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from millprint.config.mill import MillConfig
from millprint.config.sweep import Case as RunCase
from millprint.config.sweep import DemConfig
from millprint.dem.ledger import closure, ledger_series
from millprint.dem.simulation import Simulation
from millprint.mill.borders import borders_of
from millprint.mill.distance import signed_distance
from millprint.mill.vessel import Vessel
from millprint.mill.wall_words import walls_in_words
from tests.physics.setups import CALIBRATED, FewBalls
from tests.physics.test_closed_surfaces import MOTIONS
from tests.ports import Ported, places, triangles
from tests.profiles import write_stl
from tests.surfaces import ELASTIC, MM, put, vessel_of

PORTS = {
    "port": (Ported(20, 0, 50, (0, 0, 25), (1, 0, 0), 26, "round", 6), "2 cylinders, 3 discs"),
    "oblique port": (Ported(20, 0, 50, (0, 3, 20), (1, 0, 0.4), 30, "round", 5), "2 cylinders, 3 discs"),
    "grazing port": (Ported(20, 0, 50, (0, 11, 25), (1, 0, 0.3), 24, "round", 6), "2 cylinders, 3 discs"),
    "port in a cone": (Ported(20, 0.1, 50, (0, 0, 25), (1, 0, 0), 30, "round", 6), "1 cylinder, 1 cone, 3 discs"),
    "window": (Ported(20, 0, 50, (0, 0, 25), (1, 0, 0), 26, "square", 5, 0.0), "1 cylinder, 2 discs; 5 flat walls"),
    "turned window": (Ported(20, 0, 50, (0, 0, 25), (1, 0, 0), 26, "square", 5), "1 cylinder, 2 discs; 5 flat walls"),
    "boss": (Ported(20, 0, 50, (0, 0, 25), (1, 0, 0), 15, "round", 6), "2 cylinders, 3 discs"),
    "oblique boss": (Ported(20, 0.1, 50, (0, 0, 25), (1, 0, 0.2), 16, "round", 6), "1 cylinder, 1 cone, 3 discs"),
    "grazing boss": (Ported(20, 0, 50, (0, 11, 25), (1, 0, 0), 8, "round", 6), "2 cylinders, 3 discs"),
    "square boss": (Ported(20, 0, 50, (0, 0, 25), (1, 0, 0), 14, "square", 5), "1 cylinder, 2 discs; 5 flat walls"),
}  # fmt: skip


@pytest.fixture(scope="module", autouse=True)
def in_folder(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("ports"))
        yield


@cache
def drawn(name: str, around: int = 36, along: int = 24, decimals: int | None = None) -> Vessel:
    path = f"{name}_{around}_{along}_{decimals}.stl"
    write_stl(Path(path), triangles(PORTS[name][0], around, along), decimals)
    return vessel_of({"kind": "stl", "path": path, "unit": "mm"})


@pytest.mark.slow
@pytest.mark.parametrize("name", PORTS)
def test_a_port_is_touched_as_its_closed_form_says(name):
    """Where the wall is, as deep, and nowhere else: also in the port, where the mantle is not."""
    part, words = PORTS[name]
    vessel, rng = drawn(name), np.random.default_rng(0)
    assert walls_in_words([SimpleNamespace(vessel=vessel)]) == words
    for radius in (0.1, 2.0, 7.0):
        points = places(part, radius, 50, rng, (-0.02, 0.01))
        exact = part.distance(points)
        contacts, overlap = put(vessel, points, radius), np.zeros(len(points))
        np.maximum.at(overlap, contacts.ball, contacts.overlap)
        np.testing.assert_allclose(overlap, np.maximum(radius - exact, 0), atol=5e-6)
        np.testing.assert_allclose(signed_distance(vessel)(points * MM)[0], -exact * MM, atol=5e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name", PORTS)
@pytest.mark.parametrize("radius", [0.1, 2.0])
def test_a_hit_at_the_edge_of_a_port_keeps_its_energy(name, radius):
    """At edges that jut in it is one contact; in a seam the ball may touch both sides."""
    part, rng = PORTS[name][0], np.random.default_rng(1)
    vessel = drawn(name)
    for start in places(part, radius, 12, rng, (0.005, 0.03)):
        gradient = signed_distance(vessel)(start * MM)[1]
        way = gradient + rng.normal(scale=0.3, size=3)
        way /= np.linalg.norm(way)
        world = FewBalls(
            start * MM, way, vessel=vessel, contact=ELASTIC, radius=radius * MM, step=2e-8 * radius,
            skin=radius * MM / 5,
        )  # fmt: skip
        for _ in range(5):
            world.run(1.2e-4 * radius)
            if not (world.open_contacts.slot >= 0).any():
                break
        assert len(world.contacts) == 1 or (part.is_boss and len(world.contacts) == 2)
        assert (world.balls.velocity**2).sum() == pytest.approx(1, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "around", "along", "decimals"),
    [
        ("port in a cone", 24, 24, None), ("window", 24, 24, None), ("oblique port", 24, 24, None),
        ("oblique port", 61, 40, None), ("oblique port", 48, 30, 4), ("oblique port", 90, 96, None),
    ],
)  # fmt: skip
def test_a_port_is_found_however_it_is_drawn(name, around, along, decimals):
    vessel = drawn(name, around, along, decimals)
    assert walls_in_words([SimpleNamespace(vessel=vessel)]) == PORTS[name][1]
    assert name == "window" or len(borders_of(vessel).creases) >= along
    points = np.random.default_rng(0).uniform([-19, -19, 1], [25, 19, 49], (300, 3))
    points = points[PORTS[name][0].is_inside(points)]
    exact = PORTS[name][0].distance(points)
    np.testing.assert_allclose(signed_distance(vessel)(points * MM)[0], -exact * MM, atol=2e-7 if decimals else 5e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "motion"), [("grazing port", "planetary"), ("turned window", "shaken"), ("oblique boss", "shaken")]
)
def test_the_energy_balance_of_a_mill_with_a_port_closes(name, motion):
    """Small balls go in and out of the port; none is lost."""
    keys, speed_rpm = MOTIONS[motion]
    vessel = drawn(name)
    geometry = {"kind": "stl", "path": f"{name}_36_24_None.stl", "unit": "mm"}
    mill = MillConfig(name="made", title="x", source="x", volume_ml=vessel.volume_m3 * 1e6, geometry=geometry,
                      motion=keys)  # fmt: skip
    run = RunCase(mill="made", contact="calibrated", ball_diameter_m=0.004, fill_ratio=0.15, speed_hz=speed_rpm / 60,
                  seed=0, settle_s=0.02, discard_s=0.0, window_s=0.15, rayleigh_fraction=0.04)  # fmt: skip
    simulation = Simulation(run, mill, CALIBRATED, DemConfig())
    assert closure(ledger_series(np.concatenate(simulation.run("test").samples))) < 2e-3
