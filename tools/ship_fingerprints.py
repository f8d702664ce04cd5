"""Makes the fingerprints that come with millprint: python tools/ship_fingerprints.py FOLDER [--cores 2].

Simulates the sweeps of the included mills of `mills.box` at precision `fine`, and the samples of contact parameters
of each, in FOLDER, which may already hold a part of them, and writes config/fingerprints; with --mills those of some,
and the others stay as they are. A mill that this version has sampled before keeps the intervals of its contact
parameters.
"""

import argparse
import hashlib
import math
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from millprint.config.included import load_contact, load_mill
from millprint.dem import PHYSICS
from millprint.fingerprint.bands import Factors
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.readers import FOLDER, TABLE, digest_of
from millprint.run.files import read_table, write_table

ROOT = Path(__file__).parents[1]
MILLS = ("emax", "planetary", "mixer", "spex", "vibratory", "attritor", "drum")
PRECISION = "fine"
# Short simulations of a mill, each with its own contact parameters, for the interval `contact`.
SAMPLES = 64
# Fill ratios of a setting at which powers and bands are looked at.
FILLS = 9


def identity_of(mill: str, contact: str) -> dict[str, object]:
    """What the numbers of a mill's fingerprint depend on."""
    return {
        "digest": digest_of(load_mill(mill), load_contact(contact)),
        "physics": PHYSICS,
        "version": version("millprint"),
    }


def sampled_before(mills: list[str]) -> dict[str, dict[str, Factors]]:
    """Mills whose stored fingerprints have samples of this identity, and the factors of these."""
    stored = {row["mill"]: row for row in read_table(str(ROOT / TABLE)).to_dict("records") if row["mill"] in mills}
    same = (mill for mill, row in stored.items() if identity_of(mill, row["contact"]).items() <= row.items())
    return {mill: Fingerprint.read(ROOT / FOLDER / f"{mill}.json").further for mill in same}


def made_in(folder: Path, mill: str, sampled: bool) -> Path:
    """Where the workflow writes the fingerprint of a mill, with samples of its contact parameters or without."""
    return folder / f"results/{'uncertainty' if sampled else 'mills'}/{mill}/fingerprint.json"


def simulate(folder: Path, targets: list[Path], cores: int) -> None:
    """The fingerprints in `folder`, by the workflow."""
    (folder / "config").mkdir(parents=True, exist_ok=True)
    config = {
        "name": "fingerprints",
        "mill": MILLS[0],
        "contacts": ["calibrated"],
        "mills": {"box": list(MILLS), "precision": PRECISION},
        "uncertainty": {"samples": SAMPLES},
    }
    (folder / "config/config.yaml").write_text(yaml.safe_dump(config, sort_keys=False))
    wanted = [str(target.relative_to(folder)) for target in targets]
    place = ["--snakefile", str(ROOT / "workflow/Snakefile"), "--directory", str(folder)]
    subprocess.run([sys.executable, "-m", "snakemake", *place, "--cores", str(cores), *wanted], check=True)


def powers_of(fingerprint: Fingerprint) -> dict[str, float]:
    """Smallest and largest power of a kilogram of balls [W/kg], and the widest bands, where simulated and between.

    wall_half_percent, part_half_percent: the largest half of a 95 % band of a new simulation over its value, of the
    power of the walls and of its parts [%].
    """
    powers: list[float] = []
    halves: dict[bool, list[float]] = {True: [], False: []}
    for speed_hz, diameter_m, charge in fingerprint.settings:
        for fill in np.geomspace(*fingerprint.fill_range, FILLS):
            condition = fingerprint.condition(speed_hz=speed_hz, ball_diameter_m=diameter_m, fill_ratio=float(fill))
            prediction = fingerprint.predict(condition, charge=charge)
            ball_kg = condition.density_kg_m3 * math.pi / 6 * diameter_m**3
            powers.append(prediction.wall_power_W.value / (prediction.balls * ball_kg))
            for name, own in prediction.known.items():
                if name.endswith("power_W") and own.scatter:
                    width = own.scatter.upper - own.scatter.lower
                    halves[name == "wall_power_W"].append(50 * width / own.value)
    return {
        "lowest_W_kg": min(powers),
        "highest_W_kg": max(powers),
        "wall_half_percent": max(halves[True]),
        "part_half_percent": max(halves[False]),
    }


def store(mills: dict[str, Path], kept: dict[str, dict[str, Factors]]) -> pd.DataFrame:
    """Write the fingerprints of some mills into config/fingerprints, with a table of what each was made with."""
    (ROOT / FOLDER).mkdir(exist_ok=True)
    rows = [row for row in read_table(str(ROOT / TABLE)).to_dict("records") if row["mill"] not in mills]
    for mill, made in mills.items():
        place = ROOT / FOLDER / f"{mill}.json"
        fingerprint = Fingerprint.read(made).with_further(kept.get(mill, {}))
        fingerprint.write(place)
        contact = fingerprint.about["contact"]
        rows.append({
            "mill": mill,
            "contact": contact,
            "precision": PRECISION,
            **identity_of(mill, contact),
            "sha256": hashlib.sha256(place.read_bytes()).hexdigest(),
            **powers_of(fingerprint),
        })  # fmt: skip
    table = pd.DataFrame(sorted(rows, key=lambda row: MILLS.index(row["mill"])))
    write_table(table, str(ROOT / TABLE))
    return table


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="where to simulate")
    parser.add_argument("--mills", nargs="+", choices=MILLS, default=MILLS, help="which (default: all)")
    parser.add_argument("--cores", type=int, default=2, help="processors (default: %(default)s)")
    given = parser.parse_args()
    kept = sampled_before(given.mills)
    made = {mill: made_in(given.folder, mill, mill not in kept) for mill in given.mills}
    simulate(given.folder, list(made.values()), given.cores)
    print(store(made, kept).to_string(index=False))
