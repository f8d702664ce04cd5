"""What the atlas reports about itself, against new simulations of training mills; writes tables of config/atlas.

    python tools/check_atlas.py seeds       # do rows repeat with another seed within their errors? seeds.tsv
    python tools/check_atlas.py exponents   # do intervals of exponents hold finite differences? exponents.tsv

It takes some minutes of a processor. The held-out mills are not asked.
"""

import math
import sys

import numpy as np
import pandas as pd

from millprint.atlas.design import TRAINING, design, simulate_row
from millprint.atlas.estimate_mill import check, estimate, exponents
from millprint.atlas.fit_atlas import MARKS
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
}
NUMBERS = ("wall_power_W", "weighted_normal_energy_J", "weighted_tangential_energy_J")
NORMAL = 1.645


def error_of(name: str) -> str:
    """The column of the relative standard error of a number."""
    return f"{name.rpartition('_')[0]}_relative_se"


def seeds() -> pd.DataFrame:
    """By kind and number: scatter of the logarithm between seeds, and the error by turns, medians and their ratio."""
    table, found = read_table(f"{FOLDER}/simulations.tsv"), []
    for name in CHANGED:
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
    return pd.DataFrame(found)


def differences(name: str) -> list[dict]:
    """Exponents of MILLS new mills of a kind: by the atlas, by two simulations, and whether the interval holds."""
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
            ends = [simulate_row(kind, each, int(row["row"]) + place) for place, each in enumerate(moved)]
            for number in NUMBERS if all(isinstance(end.get(NUMBERS[1]), float) for end in ends) else ():
                first, last = (float(end[number]) for end in ends)
                noise = math.hypot(*(float(end[error_of(number)]) for end in ends)) / (2 * STEP)
                value, said = math.log(last / first) / (2 * STEP), told[number][own]
                found.append({
                    "kind": name, "number": number, "changed": own, "row": row["row"], "atlas": said.value,
                    "half": said.value - said.ends("scatter")[0], "simulated": value, "noise": noise,
                    "held": abs(value - said.value) <= math.hypot(said.value - said.ends("scatter")[0], NORMAL * noise),
                })  # fmt: skip
        mills += 1
        if mills == MILLS:
            break
    return found


if __name__ == "__main__":
    if sys.argv[1] == "seeds":
        write_table(seeds(), f"{FOLDER}/seeds.tsv", digits=3)
    else:
        rows = [row for name in CHANGED for row in differences(name)]
        write_table(pd.DataFrame(rows), f"{FOLDER}/exponents.tsv", digits=3)
