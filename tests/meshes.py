"""The same jars drawn in different ways, and what is simulated in them: python -m tests.meshes [SEEDS].

Prints the table of docs/why/jar_and_motion.md: jars from their sizes with N, 2 N and 4 N facets, and from binary STL
files of three tolerances, each with means and standard errors over the seeds. The last line says how far the drawings
of a jar are apart: by Welch's t, at the most, over all descriptors.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
import trimesh

from millprint.config.contact_set import ContactConfig
from millprint.config.load import load_named
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.collisions import by_surface, collision_table
from millprint.dem.ledger import ledger_series, ledger_summary
from millprint.dem.simulation import Simulation
from millprint.mill.vessel import build_vessel

CONFIG = Path(__file__).parents[1] / "config"
# Mill, speed [rpm], ball diameter [mm], fill ratio, window [s], facets.
JARS = (
    ("planetary", 300, 10, 0.25, 1.0, 24),
    ("emax_smooth", 600, 10, 0.10, 2.0, 12),
    ("mixer", 1500, 10, 0.20, 2.0, 24),
    ("spex", 1060, 12.7, 0.10, 2.0, 24),
)
TOLERANCES_MM = (0.1, 0.03, 0.01)
COLUMNS = ("Pn (W)", "Pt (W)", "f (1/s)", "En (J)", "Et (J)", "En* (J)", "Et* (J)")


def drawn(mill: MillConfig, facets: int) -> MillConfig:
    """The mill with another number of facets, and as fine ones across its fillet."""
    key = mill.geometry.facets_key
    fillet = max(5, round(mill.geometry.fillet_facets * facets / getattr(mill.geometry, key)))
    return mill.model_copy(update={"geometry": mill.geometry.model_copy(update={key: facets, "fillet_facets": fillet})})


def from_file(mill: MillConfig, tolerance_mm: float, folder: Path) -> MillConfig:
    """The mill from a binary STL whose chords are off its round walls by up to a tolerance."""
    radius = getattr(mill.geometry, "radius_mm", None) or mill.geometry.end_radius_mm
    turn = 2 * np.arccos(1 - tolerance_mm / radius)
    around = np.pi if hasattr(mill.geometry, "end_radius_mm") else 2 * np.pi
    points, triangles = build_vessel(drawn(mill, int(np.ceil(around / turn)))).triangles()
    mesh = trimesh.Trimesh(points * 1e3, triangles[:, ::-1], process=False)
    path = folder / f"{mill.name}_{tolerance_mm}.stl"
    mesh.export(path)
    content = mill.model_dump(exclude={"geometry"}, exclude_none=True)
    return MillConfig(**content, geometry={"kind": "stl", "path": str(path.relative_to(Path.cwd())), "unit": "mm"})


def descriptors(mill: MillConfig, speed_rpm: float, diameter_mm: float, fill: float, window_s: float, seed: int):
    """The numbers of COLUMNS for one run; f and the energies are of contacts by surface."""
    contact = load_named(CONFIG / "contacts", "calibrated", ContactConfig, "contact set")
    case = Case(
        mill=mill.name, contact="calibrated", ball_diameter_m=diameter_mm / 1e3, fill_ratio=fill,
        speed_hz=speed_rpm / 60, seed=seed, settle_s=0.15, discard_s=0.3, window_s=window_s, rayleigh_fraction=0.08,
    )  # fmt: skip
    simulation = Simulation(case, mill, contact, DemConfig())
    recording = simulation.run()
    ledger = ledger_summary(ledger_series(np.concatenate(recording.samples)))
    table = by_surface(collision_table(recording.table))
    normal = table["normal_J"].to_numpy()
    tangential = (table["damping_J"] + table["sliding_J"]).to_numpy()
    return (
        ledger["normal_damping"] / simulation.window_s,
        (ledger["tangential_damping"] + ledger["sliding"]) / simulation.window_s,
        len(table) / simulation.window_s / simulation.count,
        normal.mean(),
        tangential.mean(),
        (normal**2).sum() / normal.sum(),
        (tangential**2).sum() / tangential.sum(),
    )


def main(seeds: int) -> None:
    """Print the table."""
    print("| jar | drawn with | " + " | ".join(COLUMNS) + " |\n" + "|---" * (2 + len(COLUMNS)) + "|")
    farthest = {}
    with tempfile.TemporaryDirectory(dir=Path.cwd()) as folder:
        for name, *condition, facets in JARS:
            mill = load_named(CONFIG / "mills", name, MillConfig, "mill")
            ways = {f"{n * facets} facets": drawn(mill, n * facets) for n in (1, 2, 4)}
            ways |= {f"STL, {off:g} mm": from_file(mill, off, Path(folder)) for off in TOLERANCES_MM}
            found = {}
            for way, made in ways.items():
                runs = np.array([descriptors(made, *condition, seed) for seed in range(seeds)])
                found[way] = runs.mean(axis=0), runs.std(axis=0, ddof=1) / np.sqrt(seeds)
                cells = [f"{mean:.4g} ± {error:.1g}" for mean, error in zip(*found[way], strict=True)]
                print(f"| {name} | {way} | " + " | ".join(cells) + " |", flush=True)
            means, errors = (np.array(part) for part in zip(*found.values(), strict=True))
            pairs = [(i, j) for i in range(len(means)) for j in range(i)]
            apart = [np.abs(means[i] - means[j]) / np.hypot(errors[i], errors[j]) for i, j in pairs]
            farthest[name] = np.max(apart, axis=0)
    for name, values in farthest.items():
        print(f"{name}: largest t of {len(pairs)} pairs: " + ", ".join(f"{value:.1f}" for value in values))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 6)
