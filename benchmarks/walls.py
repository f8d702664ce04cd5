"""Round walls as they are drawn: what is simulated does not depend on the drawing of exact walls, and does on facets.

    python -m benchmarks.walls distances           # jars from their sizes and from STL files, all exact: their walls
    python -m benchmarks.walls same --seeds 6      # what is simulated in them
    python -m benchmarks.walls facets --seeds 8    # a jar of flat facets (`faceted: true`) and the exact one

`distances` prints how far the walls of each drawing are from those of the first one, at random places. The other two
print means and standard errors over the seeds, for docs/why/jar_and_motion.md. `same` ends with how far the drawings of
a jar are apart: by Welch's t, at the most; `--jars` takes some of them. `facets` has the jar of the planetary mill
without its fillet, straight and with a draft (its mantle is a cone), at a low and a high fill ratio.
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np
import trimesh

from millprint.config.contact_set import ContactConfig
from millprint.config.counting import DEFAULT_RULE
from millprint.config.load import CONTACT_FOLDER, MILL_FOLDER, load_named
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.run import simulate
from millprint.fingerprint.descriptors import tabulate_descriptors
from millprint.mill.distance import signed_distance
from millprint.mill.vessel import build_vessel
from millprint.mill.wall_words import round_facets

# Of `same`: of each mill speed [rpm], ball diameter [mm], fill ratio, window [s], facets.
JARS = {
    "planetary": (300, 10, 0.25, 1.0, 24),
    "emax_smooth": (600, 10, 0.10, 2.0, 12),
    "mixer": (1500, 10, 0.20, 2.0, 24),
    "spex": (1060, 12.7, 0.10, 2.0, 24),
}
# Of `distances`: how many places.
POINTS = 5000
TOLERANCES_MM = (0.1, 0.03, 0.01)
# Of `facets`: speed [rpm], ball diameter [mm], window [s], fill ratios, drafts [deg], facets a turn.
PLANETARY, FILLS, DRAFTS, FACETS = (300, 10, 1.0), (0.1, 0.25), (0.0, 2.0), (24, 48, 96, 192)
# Of a file whose mantle is recognised.
FINE = 96
# What is measured: columns of descriptors, as titles of the tables and factors on them.
COLUMNS = {
    "normal_power_W": ("$P_n$ (W)", 1.0),
    "tangential_power_W": ("$P_t$ (W)", 1.0),
    "specific_frequency_hz": ("$f$ (1/s)", 1.0),
    "weighted_normal_energy_J": ("$E^*_n$ (mJ)", 1e3),
    "weighted_tangential_energy_J": ("$E^*_t$ (mJ)", 1e3),
}

Found = dict[str, tuple[np.ndarray, np.ndarray]]


def drawn(mill: MillConfig, facets: int) -> MillConfig:
    """The mill with another number of facets, and as fine ones across its fillet."""
    key = str(mill.geometry.facets_key)
    fillet = max(5, round(mill.geometry.fillet_facets * facets / getattr(mill.geometry, key)))
    return mill.model_copy(update={"geometry": mill.geometry.model_copy(update={key: facets, "fillet_facets": fillet})})


def with_file(mill: MillConfig, mesh: trimesh.Trimesh, path: Path, faceted: bool = False) -> MillConfig:
    """The mill with a jar from a binary STL that is written here; mesh in mm."""
    mesh.export(path)
    content = mill.model_dump(exclude={"geometry"}, exclude_none=True)
    geometry = {"kind": "stl", "path": str(path.relative_to(Path.cwd())), "unit": "mm", "faceted": faceted}
    return MillConfig(**content, geometry=geometry)


def from_file(mill: MillConfig, tolerance_mm: float, folder: Path) -> MillConfig:
    """The mill from a file whose chords are off its round walls by up to a tolerance."""
    radius = getattr(mill.geometry, "radius_mm", None) or mill.geometry.end_radius_mm
    turn = 2 * np.arccos(1 - tolerance_mm / radius)
    around = np.pi if hasattr(mill.geometry, "end_radius_mm") else 2 * np.pi
    points, triangles = build_vessel(drawn(mill, int(np.ceil(around / turn)))).triangles()
    mesh = trimesh.Trimesh(points * 1e3, triangles[:, ::-1], process=False)
    return with_file(mill, mesh, folder / f"{mill.name}_{tolerance_mm}.stl")


def with_draft(mill: MillConfig, facets: int, draft_deg: float, folder: Path, faceted: bool) -> MillConfig:
    """The mill with its jar without the fillet, as a file of N facets a turn, wider at the top by a draft."""
    radius, height = mill.geometry.radius_mm, mill.geometry.height_mm
    floor = radius - height * np.tan(np.radians(draft_deg))
    mesh = trimesh.creation.revolve([(0, 0), (floor, 0), (radius, height), (0, height)], sections=facets)
    return with_file(mill, mesh, folder / f"{facets}_{draft_deg:g}_{faceted}.stl", faceted)


def measured(
    mill: MillConfig, speed_rpm: float, diameter_mm: float, fill: float, window_s: float, seeds: int
) -> tuple[np.ndarray, np.ndarray]:
    """Means and standard errors of COLUMNS over the seeds."""
    contact = load_named(CONTACT_FOLDER, "calibrated", ContactConfig, "contact set")
    runs = [
        simulate(
            Case(
                mill=mill.name, contact=contact.name, ball_diameter_m=diameter_mm / 1e3, fill_ratio=fill,
                speed_hz=speed_rpm / 60, seed=seed, settle_s=0.15, discard_s=0.3, window_s=window_s,
                rayleigh_fraction=0.08,
            ),
            mill, contact, DemConfig(),
        )
        for seed in range(seeds)
    ]  # fmt: skip
    table = np.array([tabulate_descriptors([run], DEFAULT_RULE)[list(COLUMNS)].iloc[0] for run in runs], dtype=float)
    table *= [factor for _, factor in COLUMNS.values()]
    return table.mean(axis=0), table.std(axis=0, ddof=1) / np.sqrt(seeds)


def print_head(*first: str) -> None:
    """The head of a table."""
    titles = [title for title, _ in COLUMNS.values()]
    print("| " + " | ".join([*first, *titles]) + " |\n" + "|---" * (len(first) + len(titles)) + "|")


def print_row(means: np.ndarray, errors: np.ndarray, *first: str) -> None:
    """A row of a table."""
    cells = [f"{mean:.3g} ± {error:.1g}" for mean, error in zip(means, errors, strict=True)]
    print("| " + " | ".join([*first, *cells]) + " |", flush=True)


def drawings_of(mill: MillConfig, facets: int, folder: Path) -> dict[str, MillConfig]:
    """The mill with its jar from its sizes and from files, and how each is drawn."""
    ways = {f"{n * facets} facets": drawn(mill, n * facets) for n in (1, 2, 4)}
    return ways | {f"STL, {off:g} mm": from_file(mill, off, folder) for off in TOLERANCES_MM}


def compare_distances(given: argparse.Namespace, folder: Path) -> None:
    """Print how many flat facets stand for a round wall, and how far walls are from those of the first drawing."""
    print("| jar | drawn with | round walls | flat for round | off (nm) |\n|---|---|---|---|---|")
    for name in given.jars:
        mill, facets = load_named(MILL_FOLDER, name, MillConfig, "mill"), JARS[name][-1]
        points = first = None
        for way, made in drawings_of(mill, facets, folder).items():
            vessel = build_vessel(made)
            if points is None:
                low, high = vessel.bounds
                points = np.random.default_rng(0).uniform(low, high, (POINTS, 3))
            # No ball is outside, where distances are those to the drawn facets.
            distances = np.minimum(signed_distance(vessel)(points)[0], 0.0)
            first = distances if first is None else first
            flat, off = (round_facets(vessel) > 0).sum(), np.abs(distances - first).max()
            print(f"| {name} | {way} | {len(vessel.curves)} | {flat} | {off * 1e9:.2g} |", flush=True)


def compare_drawings(given: argparse.Namespace, folder: Path) -> None:
    """Print the table of exact jars that are drawn in different ways."""
    print_head("jar", "drawn with")
    farthest = {}
    for name in given.jars:
        speed, diameter, fill, window, facets = JARS[name]
        mill = load_named(MILL_FOLDER, name, MillConfig, "mill")
        found: Found = {}
        for way, made in drawings_of(mill, facets, folder).items():
            found[way] = measured(made, speed, diameter, fill, window, given.seeds)
            print_row(*found[way], name, way)
        means, errors = (np.array(part) for part in zip(*found.values(), strict=True))
        pairs = [(i, j) for i in range(len(means)) for j in range(i)]
        apart = [np.abs(means[i] - means[j]) / np.hypot(errors[i], errors[j]) for i, j in pairs]
        farthest[name] = np.max(apart, axis=0)
    for name, values in farthest.items():
        print(f"{name}: largest t of {len(pairs)} pairs: " + ", ".join(f"{value:.1f}" for value in values))


def compare_facets(given: argparse.Namespace, folder: Path) -> None:
    """Print the table of jars with flat facets, and of the exact ones."""
    print_head("fill ratio", "draft (deg)", "facets a turn")
    mill, (speed, diameter, window) = load_named(MILL_FOLDER, "planetary", MillConfig, "mill"), PLANETARY
    for fill in FILLS:
        for draft in DRAFTS:
            for facets in (*FACETS, None):
                made = with_draft(mill, facets or FINE, draft, folder, faceted=facets is not None)
                row = measured(made, speed, diameter, fill, window, given.seeds)
                print_row(*row, f"{fill:g}", f"{draft:g}", str(facets or "exact"))


def main() -> None:
    """Print one of the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    tables = {"distances": compare_distances, "same": compare_drawings, "facets": compare_facets}
    parser.add_argument("table", choices=tables)
    parser.add_argument("--seeds", type=int, default=6)
    parser.add_argument("--jars", nargs="+", choices=JARS, default=list(JARS), help="of `distances` and `same`")
    given = parser.parse_args()
    # Paths of files are relative to the checkout; git leaves this folder out.
    place = Path.cwd() / "results/bench"
    place.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=place) as folder:
        tables[given.table](given, Path(folder))


if __name__ == "__main__":
    main()
