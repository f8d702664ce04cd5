"""The conditions of the atlas, spread over the groups of a kind, the held-out ones, and the simulation of each.

All are Sobol sequences over the ranges of the groups (scipy.stats.qmc), each with its own seed. The held-out ones are
drawn before they are simulated and kept in a file, so that a later change of the design cannot choose them. A model
is asked for them once; then they train the next model of their kind (part `asked_1` for the first draw), and others are
drawn in their place.
"""

import hashlib
import json
import math
import time
from collections.abc import Iterator, Mapping
from itertools import islice
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import qmc

from millprint.atlas.atlas_model import KindModel, inputs_of
from millprint.atlas.kind_groups import ATLAS, FEWEST_BALLS, MOST_BALLS, Kind, within_limits
from millprint.atlas.kinds import KINDS, kind_named
from millprint.cases.simulate import simulate_each
from millprint.config.contact_set import ContactConfig
from millprint.config.counting import DEFAULT_RULE, recorded_count
from millprint.config.errors import SimulationError
from millprint.config.sweep import Case, DemConfig
from millprint.config.workflow import DRAWS, HELD_OUT_MILLS
from millprint.dem import PHYSICS
from millprint.dem.laws.registry import step_scale
from millprint.dem.run import simulate
from millprint.dem.turns import relative_error
from millprint.fingerprint.descriptors import tabulate_descriptors
from millprint.mill.gravity import GRAVITY
from millprint.run.files import read_table, write_table

HELD_OUT, TRAINING, ASKED = "held_out", "training", "asked_"
# What the motion of a row without numbers begins with: its simulation failed, or it would teach little.
FAILED, SKIPPED = "failed", "not simulated"
TRAINING_SEED = 7


def seed_of(kind: Kind, part: str) -> int:
    """The seed of the sequence of a part."""
    if part == TRAINING:
        return TRAINING_SEED
    return DRAWS[kind.name][-1 if part == HELD_OUT else int(part.removeprefix(ASKED)) - 1]


def conditions(kind: Kind, part: str) -> Iterator[dict[str, float]]:
    """The conditions of a part of the design of a kind, without end: all of `Kind.condition_of`.

    A point with more than MOST_BALLS balls, or whose whole number of balls has a fill ratio out of the range, is left
    out.
    """
    sequence = qmc.Sobol(len(kind.groups), scramble=True, seed=seed_of(kind, part))
    fill = kind.groups[kind.names.index("fill")]
    while True:
        for shares in sequence.random(64):
            groups = {group.name: group.at(share) for group, share in zip(kind.groups, shares, strict=True)}
            condition = kind.condition_of(groups)
            own = kind.groups_of(condition)["fill"]
            if FEWEST_BALLS <= condition["number"] <= MOST_BALLS and fill.low <= own <= fill.high:
                yield condition


def design(kind: Kind, part: str, count: int) -> pd.DataFrame:
    """The first `count` conditions of a part, a row each, and the groups that they have; index: their number."""
    rows = list(islice(conditions(kind, part), count))
    groups = [kind.groups_of(row) for row in rows]
    table = pd.DataFrame({"kind": kind.name, "part": part, "row": np.arange(count)})
    return pd.concat(
        [table, pd.DataFrame(groups), pd.DataFrame({"number": [int(row["number"]) for row in rows]})], axis=1
    )


def rows_of(kind: str, part: str, first: int, count: int, held_out: str) -> pd.DataFrame:
    """Rows `first` to `first + count - 1` of a part of the design of a kind.

    held_out: the file of the held-out mills, which were drawn before any model was fitted. Raises ConfigError for an
    unknown kind.
    """
    own = kind_named(kind)
    if part == HELD_OUT:
        table = read_table(held_out)
        return table.loc[table["kind"] == kind, ["kind", "part", "row", *own.names, "number"]].iloc[
            first : first + count
        ]
    return design(own, part, first + count).iloc[first:]


def write_held_out(path: str) -> None:
    """Draw the held-out mills of every kind and write their table, before they are simulated."""
    write_table(pd.concat([design(kind, HELD_OUT, HELD_OUT_MILLS) for kind in KINDS.values()]), path, digits=17)


# Step over the Rayleigh time, as of a quick run; the largest error of the energy balance over the wall work.
RAYLEIGH, CLOSURE_MAX = 0.11, 0.01
# Ball-steps of a window, which take about a second, and turns that it has at most.
BALL_STEPS, MOST_TURNS = 1.2e7, 150
# The balls fall for this time before the mill starts, in times of a fall through the jar's radius [-].
SETTLED = 1.0
# What is read off a run, by the observables' names, and the relative standard errors by its turns.
READ = (
    "wall_power_W", "normal_power_W", "tangential_power_W", "rolling_power_W", "weighted_normal_energy_J",
    "weighted_normal_frequency_hz", "weighted_tangential_energy_J", "weighted_tangential_frequency_hz",
    "strong_frequency_hz",
)  # fmt: skip
ERRORS = (
    "wall_power_relative_se", "weighted_normal_energy_relative_se", "weighted_normal_frequency_relative_se",
    "weighted_tangential_energy_relative_se", "weighted_tangential_frequency_relative_se",
)  # fmt: skip
NO_COLLISION = "no impacts"
# A row teaches little where balls only roll, or beyond the limits of its kind: once there is an atlas, it is skipped
# where that gives balls a smaller probability of hitting anything.
LEAST_HITS = 0.1
RESULTS = (*READ, *ERRORS, "motion", "recorded_turns", "processor_s", "version")


def version_of(kind: Kind) -> str:
    """What decides the numbers of a row, besides its condition, its seed and the code of the kernels, in short."""
    settings = (RAYLEIGH, BALL_STEPS, kind.fewest_turns, MOST_TURNS, kind.discarded_turns, SETTLED)
    return f"{PHYSICS}." + hashlib.sha256(json.dumps(settings).encode()).hexdigest()[:6]


def case_of(kind: Kind, condition: dict[str, float], contact: ContactConfig, seed: int) -> Case:
    """The case of a condition, as long as BALL_STEPS allows."""
    ball_m, speed = condition["ball_diameter_mm"] / 1e3, condition["speed_hz"]
    balls = condition["number"]
    steps = 1 / speed / (RAYLEIGH * step_scale(contact, ball_m / 2))
    turns = min(MOST_TURNS, max(kind.fewest_turns, math.ceil(BALL_STEPS / (balls * steps))))
    fill = balls * math.pi / 6 * ball_m**3 / kind.volume_m3(condition)
    return Case(
        mill=ATLAS, contact=ATLAS, ball_diameter_m=ball_m, fill_ratio=fill, speed_hz=speed, seed=seed,
        rayleigh_fraction=RAYLEIGH, closure_max=CLOSURE_MAX,
        settle_s=SETTLED * math.sqrt(2 * condition["radius_mm"] / 1e3 / GRAVITY),
        discard_s=kind.discarded_turns / speed, window_s=turns / speed,
    )  # fmt: skip


def simulate_row(kind: Kind, condition: dict[str, float], seed: int) -> dict[str, float | str]:
    """What one simulation of a condition gives: READ over the scales of the kind, ERRORS, the words of its motion,
    recorded turns and seconds of a processor.

    A simulation that fails is a row whose `motion` says so, without numbers; one without a collision has only power.
    """
    begin = time.process_time()
    mill, contact = kind.mill_of(condition), kind.contact_of(condition)
    case = case_of(kind, condition, contact, seed)
    try:
        summary = simulate(case, mill, contact, DemConfig())
    except SimulationError as error:
        return {"motion": f"{FAILED}: {error}"}
    if recorded_count(summary, DEFAULT_RULE)["count"]:
        found = tabulate_descriptors([summary], DEFAULT_RULE).iloc[0]
        read = {**{name: float(found[name]) for name in (*READ, *ERRORS)}, "motion": found["motion"]}
    else:
        # Balls that roll and never part.
        spread = relative_error(summary["per_revolution"]["wall_J"])
        read = {READ[0]: summary["power_W"]["wall"], ERRORS[0]: spread, "motion": NO_COLLISION}
    return {**read, "recorded_turns": round(summary["revolutions"]), "processor_s": time.process_time() - begin}


def simulate_rows(
    rows: pd.DataFrame,
    done: str | Path,
    title: str,
    shipped: pd.DataFrame | None = None,
    atlas: Mapping[str, KindModel] | None = None,
) -> pd.DataFrame:
    """The rows of a design (`millprint.atlas.design`) with what `simulate_row` gives, in the same order.

    done: a file from which a stopped call continues; it is removed at the end. shipped: a table of such rows, which are
    not simulated again where they have the same groups and the present version. atlas: an earlier one by kind, for
    training rows that are skipped. The seed of a row is its number.
    """
    wanted = rows.to_dict("records")
    known = {} if shipped is None else {_place(row): row for row in shipped.to_dict("records")}
    kept = {place: own for row in wanted if (own := known.get(place := _place(row))) and _is_of(own, row)}
    for row in wanted:
        model = (atlas or {}).get(row["kind"])
        if model and row["part"] == TRAINING and _place(row) not in kept and not _teaches(row, model):
            kept[_place(row)] = {"motion": SKIPPED, "version": version_of(model.kind)}
    runs = {str(row["row"]): row for row in wanted if _place(row) not in kept}
    found = simulate_each(
        runs, _simulated, sorted({version_of(kind_named(row["kind"])) for row in wanted}), title, done
    )
    Path(done).unlink(missing_ok=True)
    results = [found.get(str(row["row"])) or kept[_place(row)] for row in wanted]
    return pd.DataFrame(
        [{**row, **{name: own.get(name) for name in RESULTS}} for row, own in zip(wanted, results, strict=True)]
    )


def _place(row: dict) -> tuple[str, str, int]:
    """The place of a row in the design."""
    return row["kind"], row["part"], int(row["row"])


def _teaches(row: dict, model: KindModel) -> bool:
    """Whether a row of the design is within the limits of its kind, and its balls may hit something."""
    table = pd.DataFrame([row])
    likely = model.probability(inputs_of(model.kind, table)) >= LEAST_HITS
    return bool(likely.all() and np.all(within_limits(model.kind, table)))


def _is_of(known: dict, row: dict) -> bool:
    """Whether a row of a table, which has six digits, is of the present version and of this row of the design."""
    kind = kind_named(row["kind"])
    alike = all(math.isclose(known[name], row[name], rel_tol=1e-5, abs_tol=1e-12) for name in kind.names)
    return bool(alike and known["version"] == version_of(kind))


def _simulated(row: dict) -> dict:
    kind = kind_named(row["kind"])
    return simulate_row(kind, kind.condition_of(row), int(row["row"])) | {"version": version_of(kind)}
