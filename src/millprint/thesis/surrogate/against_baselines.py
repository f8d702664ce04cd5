"""Whether the networks are nearer to the simulation than what a clever person would take in their place."""

import math
from dataclasses import replace

import pandas as pd

from millprint.estimate.estimates import Estimate, mean_of
from millprint.estimate.judge import AGREES, Allowed, judge
from millprint.thesis.surrogate.measures import DISSIPATION, UNLEARNED

SPEED = "mean_square_speed_ratio"
AGAINST_COLUMNS = [
    "test", "motion", "length_s", "trainings", "ran_away", "lower_percent", "mean_percent", "upper_percent",
    *(f"{name}_percent" for name in UNLEARNED), "nearer", "nearer_in_speed_too", "verdict", "reason",
]  # fmt: skip


def against_baselines(baselines: pd.DataFrame, variant: str) -> pd.DataFrame:
    """Whether a variant is nearer to the simulation than what needs no network, a row for each test.

    baselines: as `baseline_table`. mean_percent, with Student's interval: error of the dissipated energy over the
    trainings that did not run away; UNLEARNED: those of the baselines; nearer: in how many trainings the error is
    smaller than that of every baseline, and nearer_in_speed_too that of the mean square speed as well; verdict: of
    `judge` on whether the mean is smaller than every baseline's. A roll-out that ran away is a miss.
    """
    rows = []
    for test, part in baselines.groupby("test", sort=False):
        own, known = part[part["model"] == variant], part[part["model"].isin(UNLEARNED)].set_index("model")
        held = own[own["ran_away"] != "yes"]
        least = float(known[DISSIPATION].min())
        speed = float((known[SPEED] - 1).abs().min())
        near = held[held[DISSIPATION] < least]
        both = near[(near[SPEED] - 1).abs() < speed]
        mean = mean_of(held[DISSIPATION].tolist(), "%", least=0.0) if len(held) else Estimate(math.inf, "%")
        mean = replace(mean, of=len(own), failed=len(own) - len(held))
        verdict = judge(mean, Allowed(upper=least, open_upper=True))
        rows.append(
            (
                *(test, part["motion"].iloc[0], own["length_s"].max(), len(own), len(own) - len(held)),
                *(mean.ends("repeats")[0], mean.value, mean.ends("repeats")[1]),
                *known[DISSIPATION].reindex(list(UNLEARNED)),
                *(len(near), len(both), *verdict),
            )
        )
    return pd.DataFrame(rows, columns=AGAINST_COLUMNS)


def told_against(table: pd.DataFrame) -> str:
    """The first sentence on the networks: whether they beat what needs none; table: as `against_baselines`."""
    beaten, singles = table[table["verdict"] == AGREES], int(table["trainings"].sum())
    trainings, tests = int(table["trainings"].max()), len(table)
    several = f"{trainings} trainings" if trainings > 1 else "one training"
    found = f"in {len(beaten)} of {tests} tests ({', '.join(beaten['test'])})" if len(beaten) else "in no test"
    begin = "" if len(beaten) else "No network beats what needs none: "
    near, both, away = (int(table[name].sum()) for name in ("nearer", "nearer_in_speed_too", "ran_away"))
    told = (
        f"{begin}the mean error of the dissipated energy over {several} is below that of every baseline {found}; of "
        f"{singles} single roll-outs {near} are, {both} of them in the speed of the balls too, and {away} ran away."
    )
    return told[0].upper() + told[1:]
