"""What the atlas reports about itself, against new simulations of training mills; writes tables of config/atlas.

    python tools/check_atlas.py seeds drum        # do rows repeat with another seed within their errors? seeds.tsv
    python tools/check_atlas.py exponents drum    # do intervals of exponents hold finite differences? exponents.tsv
    python tools/check_atlas.py held_out          # draws the held-out mills of all kinds; held_out.tsv

Of the first two, a kind or several are named, or all are taken; rows of others stay. They take some minutes of a
processor. Differences of an earlier table are not simulated again. The held-out mills are not asked.
exponents_held.tsv counts the differences: all, those in the atlas's own 90 % interval, and those in one that has the
90 % of their noise added in squares.
"""

import math
import sys

import numpy as np
import pandas as pd

from millprint.atlas.atlas_model import MARKS, NORMAL
from millprint.atlas.design import HELD_OUT, TRAINING, design, simulate_row, write_held_out
from millprint.atlas.estimate_mill import check, estimate, exponents
from millprint.atlas.kind_groups import Kind
from millprint.atlas.kinds import KINDS
from millprint.config.errors import ConfigError
from millprint.config.load import shipped
from millprint.run.files import read_table, write_table

FOLDER = shipped("config/atlas")
# Rows of a kind, further seeds of each, the longest simulation that is repeated [s].
ROWS, SEEDS, LONGEST_S = 24, 2, 3.0
# Mills of a kind, from a place of the design that no model has; what is changed, and how far to each side.
MILLS, FIRST, STEP = 3, 5000, 0.1
CHANGED = {
    "mixer": ("speed_hz", "ball_diameter_mm", "stroke_mm", "restitution"),
    "planetary": ("speed_hz", "ball_diameter_mm", "sun_radius_mm", "wall_static_friction"),
    "drum": ("speed_hz", "ball_diameter_mm", "radius_mm", "wall_static_friction"),
    "spex": ("speed_hz", "ball_diameter_mm", "stroke_mm", "restitution"),
}
NUMBERS = ("wall_power_W", "weighted_normal_energy_J", "weighted_tangential_energy_J")


def error_of(name: str) -> str:
    """The column of the relative standard error of a number."""
    return f"{name.rpartition('_')[0]}_relative_se"


def seeds(names: list[str]) -> list[dict]:
    """By kind and number: scatter of the logarithm between seeds, and the error by turns, medians and their ratio."""
    table, found = read_table(f"{FOLDER}/simulations.tsv"), []
    for name in names:
        own = table[(table["kind"] == name) & (table["part"] == TRAINING) & table["motion"].isna()]
        own = own[own["processor_s"] < LONGEST_S].sample(ROWS, random_state=3).to_dict("records")
        kind = KINDS[name]
        runs = [[row, *(simulate_row(kind, kind.condition_of(row), int(row["row"]) + 100_000 * seed)
                        for seed in range(1, SEEDS + 1))] for row in own]  # fmt: skip
        for number in MARKS:
            values = np.log([[float(run.get(number) or math.nan) for run in each] for each in runs])
            errors = np.array([[float(run.get(error_of(number)) or math.nan) for run in each] for each in runs])
            scatter, stated = values.std(axis=1, ddof=1), np.sqrt((errors**2).mean(axis=1))
            found.append({
                "kind": name, "number": number, "rows": len(runs), "scatter": np.nanmedian(scatter),
                "stated": np.nanmedian(stated), "ratio": math.sqrt(np.nanmean((scatter / stated) ** 2)),
                "beyond_three": int((scatter > 3 * stated).sum()),
            })  # fmt: skip
    return found


def simulated(kind: Kind, own: str, row: int, moved: list[dict]) -> dict[str, tuple[float, float]]:
    """The exponent of each of NUMBERS with a setting by two simulations, and its error; nothing where nothing hits."""
    ends = [simulate_row(kind, each, row + place) for place, each in enumerate(moved)]
    if not all(isinstance(end.get(NUMBERS[1]), float) for end in ends):
        return {}
    logs = {number: math.log(float(ends[1][number]) / float(ends[0][number])) for number in NUMBERS}
    noises = {number: math.hypot(*(float(end[error_of(number)]) for end in ends)) for number in NUMBERS}
    return {number: (logs[number] / (2 * STEP), noises[number] / (2 * STEP)) for number in NUMBERS}


def differences(name: str, known: pd.DataFrame) -> list[dict]:
    """Exponents of MILLS new mills of a kind: by the atlas, by two simulations, and whether the interval holds.

    known: an earlier table, whose simulations are not made again.
    """
    kind, found, mills = KINDS[name], [], 0
    for row in design(kind, TRAINING, FIRST + 40).iloc[FIRST:].to_dict("records"):
        condition = kind.condition_of(row)
        try:
            if estimate(kind, condition).hits < 0.8 or not 6 <= condition["number"] <= 60:
                continue
        except ConfigError:
            continue
        told = exponents(kind, condition)
        for own in CHANGED[name]:
            moved = [condition | {own: condition[own] * math.exp(side)} for side in (-STEP, STEP)]
            try:
                for each in moved:
                    check(kind, each)
            except ConfigError:
                continue
            before = known[(known[["kind", "changed", "row"]] == [name, own, row["row"]]).all(axis=1)]
            values = {each["number"]: (each["simulated"], each["noise"]) for each in before.to_dict("records")}
            for number, (value, noise) in (values or simulated(kind, own, int(row["row"]), moved)).items():
                said = told[number][own]
                half = said.value - said.ends("scatter")[0]
                found.append({
                    "kind": name, "number": number, "changed": own, "row": row["row"], "atlas": said.value,
                    "half": half, "simulated": value, "noise": noise,
                    "held": abs(value - said.value) <= half,
                    "held_with_noise": abs(value - said.value) <= math.hypot(half, NORMAL * noise),
                })  # fmt: skip
        mills += 1
        if mills == MILLS:
            break
    return found


def counted(table: pd.DataFrame) -> pd.DataFrame:
    """How many differences each kind has and how many were held, and the same of all kinds."""
    counts = table.groupby("kind", sort=False)[["held", "held_with_noise"]].sum()
    counts.insert(0, "differences", table["kind"].value_counts())
    return pd.concat([counts, counts.sum().to_frame("all").T]).astype(int).rename_axis("kind").reset_index()


if __name__ == "__main__":
    names, path = sys.argv[2:] or list(CHANGED), f"{FOLDER}/{sys.argv[1]}.tsv"
    if sys.argv[1] == HELD_OUT:
        write_held_out(path)
        sys.exit()
    before = read_table(path)
    made = seeds(names) if sys.argv[1] == "seeds" else [row for name in names for row in differences(name, before)]
    table = pd.concat([before[~before["kind"].isin(names)], pd.DataFrame(made)])
    write_table(table, path, digits=3)
    if sys.argv[1] == "exponents":
        write_table(counted(table), f"{FOLDER}/exponents_held.tsv")
