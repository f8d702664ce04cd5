"""Measures of the difference between a roll-out and a simulation, and the tables of them.

Whether the networks are nearer to the simulation than what a clever person would take in their place.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from millprint.estimate.estimates import Estimate, largest_difference, mean_of, range_of_single, spread_of
from millprint.estimate.judge import AGREES, DIFFERS, OPEN, Allowed, judge

# A mean square speed over that of the simulation, above which a roll-out runs away.
RUNAWAY = 2.0
# What sums of equal numbers differ by, over these numbers.
ROUNDING = 1e-9


def position_error(position: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Mean over balls of the squared distance, Eq. 6.33: (frames, batch, balls, 3) twice to (frames, batch) [m2].

    The thesis prints a mean of squared norms, so axes are summed and not averaged.
    """
    return ((position - truth) ** 2).sum(axis=-1).mean(axis=-1)


def centroid_error(truth: np.ndarray) -> np.ndarray:
    """Error of a roll-out that puts every ball at the centre of mass, (frames, batch) [m2]: a mark for blurring."""
    return position_error(truth.mean(axis=2, keepdims=True), truth)


def plateau(error: np.ndarray) -> float:
    """Mean of the second half of the frames, over the batch; infinite where the roll-out is not finite."""
    value = error[len(error) // 2 :].mean()
    return float(value) if np.isfinite(value) else np.inf


def horizon(time_s: np.ndarray, error: np.ndarray, bound: float) -> float:
    """First time at which the error, averaged over the batch, exceeds `bound` [s]; the last time if it never does."""
    over = ~(error.mean(axis=1) <= bound)
    return float(time_s[np.argmax(over)] if over.any() else time_s[-1])


def growth_time(time_s: np.ndarray, error: np.ndarray, low: float, high: float) -> float:
    """Time in which the error, averaged over the batch, grows from `low` to `high` [s]; nan where it never does."""
    mean = error.mean(axis=1)
    if not (mean > high).any():
        return np.nan
    return horizon(time_s, error, high) - horizon(time_s, error, low)


def relative_error_percent(cumulative: np.ndarray, truth: np.ndarray) -> float:
    """Relative error of the cumulative dissipation at the end, summed over the batch, (frames, batch) twice [%]."""
    value = 100 * abs(cumulative[-1].sum() / truth[-1].sum() - 1)
    return float(value) if np.isfinite(value) else np.inf


def correlation(first: np.ndarray, second: np.ndarray) -> float:
    """Pearson's r of two arrays of one shape; not a number where either is constant to rounding or not finite."""
    first, second = first.ravel(), second.ravel()
    if len(first) < 3 or not (np.isfinite(first).all() and np.isfinite(second).all()):
        return np.nan
    if any(np.ptp(values) <= ROUNDING * np.abs(values).max() for values in (first, second)):
        return np.nan
    return float(np.corrcoef(first, second)[0, 1])


def increments(cumulative: np.ndarray, frames: int) -> np.ndarray:
    """Differences of a cumulative curve over every `frames` frames, (n, batch)."""
    return np.diff(cumulative[::frames], axis=0)


def distribution_distance(first: np.ndarray, second: np.ndarray) -> float:
    """Wasserstein distance of two samples, in their unit; infinite if the first holds anything not finite."""
    if not np.isfinite(first).all():
        return np.inf
    # Slow to import, and claims and figures import this module.
    from scipy.stats import wasserstein_distance

    return float(wasserstein_distance(first.ravel(), second.ravel()))


def highest_lift(position_m: np.ndarray) -> float:
    """How far any ball rises over where it started, (frames, batch, balls, 3) to [m]; infinite if not finite."""
    rise = (position_m[..., 2] - position_m[0, ..., 2]).max()
    return float(rise) if np.isfinite(rise) else np.inf


def explained_share(predicted: np.ndarray, truth: np.ndarray) -> float:
    """1 - residual over total sum of squares (R2) of all components together."""
    spread = ((truth - truth.mean()) ** 2).sum()
    return float(1 - ((predicted - truth) ** 2).sum() / spread) if spread > 0 else np.nan


MEASURE = ["test", "measure"]
TRAINING_COLUMNS = ["variant", "training", "test", "length_s", "measure", "value"]


def tabulate_trainings(metrics: pd.DataFrame, trainings: dict[str, list[str]]) -> pd.DataFrame:
    """A row for each variant, training (1 is the first), test and measure, with TRAINING_COLUMNS.

    metrics: rows of metrics.tsv of all trainings; trainings: by variant, the names of its trainings, its own first.
    """
    place = {name: (base, number) for base, names in trainings.items() for number, name in enumerate(names, start=1)}
    own = metrics[metrics["variant"].isin(place)]
    where = pd.DataFrame(own["variant"].map(place).tolist(), columns=["variant", "training"], index=own.index)
    return own.assign(**{name: where[name] for name in where})[TRAINING_COLUMNS].reset_index(drop=True)


def with_spread(metrics: pd.DataFrame, trainings: dict[str, list[str]]) -> pd.DataFrame:
    """The rows of the first trainings, with how many trainings there are, and the lowest and highest of their value."""
    table = tabulate_trainings(metrics, trainings)
    groups = table.groupby(["variant", *MEASURE], sort=False)["value"]
    spread = groups.agg(trainings="size", lowest="min", highest="max").reset_index()
    return metrics[metrics["variant"].isin(trainings)].merge(spread, how="left", on=["variant", *MEASURE])


def failed_tests(metrics: pd.DataFrame) -> set[str]:
    """The tests in which the roll-out of one training lost balls and ran away. metrics: its rows of metrics.tsv."""
    measures = metrics.pivot(index="test", columns="measure", values="value")
    measures = measures.reindex(columns=["balls_left", "mean_square_speed_ratio"])
    lost, calm = measures["balls_left"] > 0, measures["mean_square_speed_ratio"] < RUNAWAY
    return set(measures.index[lost & ~calm])


# Claims of the thesis on its surrogate (Secs 6.3 and 6.4) by test and measure, and what it prints besides.
CLAIMS = {
    ("trained", "position_mse_plateau_m2"): "6.mse",
    ("trained", "dissipation_error_percent"): "6.energy",
    ("motion1", "dissipation_error_percent"): "6.energy.motion1",
    ("motion2", "dissipation_error_percent"): "6.energy.motion2",
    ("motion1", "cumulative_pearson_r"): "6.pearson",
    ("motion2", "cumulative_pearson_r"): "6.pearson",
}
PRINTED_BESIDES = {("post", "dissipation_error_original_percent"): 5.97, ("post", "balls_left"): 0.0}
# Values that ours should not exceed.
AIMS = {
    ("trained", "dissipation_error_percent"): 2.0,
    ("motion1", "dissipation_error_percent"): 5.0,
    ("motion2", "dissipation_error_percent"): 5.0,
    ("post", "dissipation_error_percent"): 7.0,
}
EVERY_TEST = {
    "balls_left": 0.0,
    "rest_dissipation_share_percent": 1.0,
    # A hundredth of a 10 mm ball: it may creep, but not lift off.
    "rest_highest_lift_m": 1e-4,
}
# Aims relative to a second simulation: distances should not be larger, the horizon not shorter.
OF_REFERENCE = {
    "horizon_s": 0.5,
    "speed_wasserstein_m_s": 2.0,
    "wall_distance_wasserstein_m": 2.0,
    "contacts_wasserstein": 2.0,
    "increments_5ms_wasserstein_J": 2.0,
}
AT_LEAST = {"horizon_s"}
# Width of the bins of wall distances.
WALL_BIN_M = 1e-5


def aim_for(test: str, measure: str, reference: float | None) -> float | None:
    """What a measure should not exceed, or for those of AT_LEAST not fall short of; None for one without an aim."""
    if measure in OF_REFERENCE:
        return None if reference is None else OF_REFERENCE[measure] * reference
    return AIMS.get((test, measure), EVERY_TEST.get(measure))


def is_met(measure: str, value: float, aim: float) -> bool:
    """Whether a value reaches its aim; one that is not a number does not."""
    return value >= aim if measure in AT_LEAST else value <= aim


def printed_measures(printed: pd.Series) -> dict[tuple[str, str], float]:
    """What the thesis prints by test and measure; `printed` as `millprint.run.tables.read_printed`."""
    return PRINTED_BESIDES | {place: float(printed[claim]) for place, claim in CLAIMS.items()}


def tabulate(
    values: dict[str, float],
    references: dict[str, float],
    test: str,
    variant: str,
    printed: dict[tuple[str, str], float] | None = None,
    length_s: float | None = None,
) -> pd.DataFrame:
    """Rows of metrics.tsv: variant, test, length_s, measure, value, dem_reference, thesis, aim.

    printed: what the thesis prints, by test and measure, for the column `thesis`; length_s: of the roll-out, None of
    single steps.
    """
    rows = [
        {
            "variant": variant,
            "test": test,
            "length_s": length_s,
            "measure": measure,
            "value": value,
            "dem_reference": references.get(measure),
            "thesis": (printed or {}).get((test, measure)),
            "aim": aim_for(test, measure, references.get(measure)),
        }
        for measure, value in values.items()
    ]
    return pd.DataFrame(rows)


def join_tables(tables: list[pd.DataFrame]) -> pd.DataFrame:
    """One table of several; a column that some of them lack is empty there."""
    columns = dict.fromkeys(column for table in tables for column in table.columns)
    records = [record for table in tables for record in table.to_dict("records")]
    return pd.DataFrame(records, columns=list(columns))


def wall_contact_table(distance: np.ndarray) -> pd.DataFrame:
    """Where balls are when they touch the wall, which the wall threshold must cover (thesis Fig. 6.4).

    distance (contacts,): signed distances of the centres [m]. Columns: low_m, high_m, contacts, a row a bin.
    """
    # Bin edges are whole multiples of the bin, so that any threshold of the thesis is an edge.
    low = int(np.floor(min(distance.min(initial=-0.0053), -0.0056) / WALL_BIN_M))
    high = int(np.ceil(max(distance.max(initial=-0.0045), -0.0045) / WALL_BIN_M))
    edges = np.arange(low, high + 1) * WALL_BIN_M
    contacts, _ = np.histogram(distance, edges)
    return pd.DataFrame({"low_m": edges[:-1], "high_m": edges[1:], "contacts": contacts})


def covered_share(table: pd.DataFrame, threshold_m: float) -> float:
    """Share of wall contacts that a wall threshold covers, to the width of a bin."""
    beyond = table["low_m"] >= threshold_m - WALL_BIN_M / 2
    return float(table["contacts"][beyond].sum() / max(1, table["contacts"].sum()))


BASELINE = "baseline"
DISSIPATION, PLATEAU = "dissipation_error_percent", "position_mse_plateau_m2"
# A dissipation that "grows without bound" must have an error larger than itself [%].
UNBOUNDED_PERCENT = 100.0
# Whether a row differs from the baseline by more than two trainings of the baseline do.
SOMETHING, NOTHING = "something", "nothing"
AGAINST = ("trainings", "lower_percent", "upper_percent", "from_baseline_percent", "baseline_apart_percent", "says")
MEASURES = (
    "stable",
    "balls_left",
    "mean_square_speed_ratio",
    PLATEAU,
    DISSIPATION,
    "dissipation_power_W",
    "one_step_dissipation_bias_percent",
)


@dataclass(frozen=True)
class Statement:
    """What the thesis says: its text, what of it can be checked (`meets_statement`), and the claim on the error [%]."""

    text: str
    checked: str = ""
    claim: str = ""


STATEMENTS = {
    BASELINE: Statement("the settings of Table 6.3", claim="6.energy"),
    "window3": Statement("stable motion, less accurate dissipation (Fig. A.1)", "stable_and_worse"),
    "window9": Statement("unstable motion (Fig. A.2)", "unstable"),
    "layers2": Statement("balls stay inside but chaotic, dissipation grows without bound (Fig. A.3)", "grows"),
    "layers4": Statement("unstable motion (Fig. A.4)", "unstable"),
    "width64": Statement("stable and precise motion, inaccurate dissipation (Fig. A.5)", "stable_and_worse"),
    "mlp2": Statement("highly unstable motion (Fig. A.6)", "unstable"),
    "phi_shallow": Statement("dissipation overshoots (Fig. A.7)", "overshoots", "A.phi.shallow"),
    "phi_deep": Statement("dissipation undershoots (Fig. A.8)", "undershoots", "A.phi.deep"),
    "no_global_loss": Statement("stable motion, dissipation overshoots (Fig. A.9)", "overshoots", "A.global_loss"),
}
OURS = Statement("not in the thesis: another reading of it")


def meets_statement(checked: str, row: pd.Series, baseline: pd.Series) -> bool:
    """Whether a row agrees with a statement of the thesis, at our budget.

    `worse` is against the baseline of the same budget; to overshoot is to dissipate more power than the simulation.
    """
    stable, error = row["stable"] == 1, row[DISSIPATION]
    return bool(
        {
            "stable_and_worse": stable and error > baseline[DISSIPATION],
            "unstable": not stable,
            "grows": error > UNBOUNDED_PERCENT,
            "overshoots": row["dissipation_power_W"] > row["dem_power_W"],
            "undershoots": row["dissipation_power_W"] < row["dem_power_W"],
        }[checked]
    )


def ablation_table(
    metrics: pd.DataFrame,
    histories: dict[str, pd.DataFrame],
    changes: dict[str, str],
    length_s: dict[str, float],
    printed: pd.Series,
    trainings: dict[str, list[str]],
) -> pd.DataFrame:
    """A row for each ablation: its change, its budget, its measures on the trained motion, and the thesis's statement.

    metrics: rows of metrics.tsv; histories: loss by the variant whose weights are used; changes: texts;
    length_s: of the roll-outs; printed: as `millprint.run.tables.read_printed`; trainings: by ablation, the names in
    metrics of all trainings of its weights, its own first. Column `verdict` is that on the
    statement, OPEN if the baseline itself is unstable, and empty without a statement or a baseline.

    One training is one draw. lower_percent and upper_percent: interval of the dissipation error, over the row's own
    trainings, or else as those of the baseline scatter; from_baseline_percent: how far the error is from that of the
    baseline, in points; baseline_apart_percent: how far two trainings of the baseline are apart at most; `says` is
    NOTHING where the first is not above the second and the motion is stable or not as that of some training of the
    baseline, or where the trainings of the baseline disagree in their verdicts. All empty if the
    baseline was trained once.
    """
    rows = []
    for variant, change in changes.items():
        part = metrics[metrics["variant"] == variant].set_index("measure")
        row = {"variant": variant, "changed": change, "rollout_s": length_s[variant]}
        row |= {"epochs": len(histories[variant]), "training_s": float(histories[variant]["elapsed_s"].iloc[-1])}
        row |= {name: part["value"].get(name) for name in MEASURES}
        error = part["value"][DISSIPATION]
        row["dem_power_W"] = part["value"]["dem_power_W"]
        said = STATEMENTS.get(variant, OURS)
        error_percent = float(printed[said.claim]) if said.claim else None
        row |= {"dem_seeds_percent": part["dem_reference"][DISSIPATION], "thesis_percent": error_percent}
        rows.append(row | {"thesis_statement": said.text, DISSIPATION: error})
    table = pd.DataFrame(rows)
    repeats = {variant: _repeats(metrics, trainings[variant]) for variant in changes}
    baselines = repeats.get(BASELINE, repeats[next(iter(repeats))].iloc[:0])
    table["verdict"] = [_verdict(row, baselines.iloc[0]) if len(baselines) else "" for _, row in table.iterrows()]
    against = [_against(row, repeats[row["variant"]], baselines) for _, row in table.iterrows()]
    return table.join(pd.DataFrame(against, index=table.index))


def scatter_in_words(table: pd.DataFrame) -> str:
    """What the trainings of the baseline leave of the ablations, as a sentence; empty if it was trained once."""
    compared = table[table["says"].isin([SOMETHING, NOTHING])]
    if compared.empty:
        return ""
    silent = compared[compared["says"] == NOTHING]["variant"]
    named = f" ({', '.join(silent)})" if len(silent) else ""
    return (
        f"{len(silent)} of {len(compared)} ablations say nothing{named}: two trainings of the baseline are up to "
        f"{compared['baseline_apart_percent'].iloc[0]:.3g} points of the dissipation error apart."
    )


def _repeats(metrics: pd.DataFrame, names: list[str]) -> pd.DataFrame:
    """A row for each training: its measures on the trained motion, as far as a statement is about them."""
    values = metrics[metrics["variant"].isin(names)].pivot_table("value", "variant", "measure", "first", dropna=False)
    return values.loc[names].reset_index(drop=True)


def _verdict(row: pd.Series, baseline: pd.Series) -> str:
    checked = STATEMENTS.get(row["variant"], OURS).checked
    if not checked:
        return ""
    if baseline["stable"] != 1:
        return OPEN
    return AGREES if meets_statement(checked, row, baseline) else DIFFERS


def _against(row: pd.Series, own: pd.DataFrame, baselines: pd.DataFrame) -> dict:
    """Columns AGAINST of a row: its interval, and whether it says anything against the scatter of the baseline."""
    found: dict[str, float | str | None] = {"trainings": len(own)} | dict.fromkeys(AGAINST[1:])
    if len(baselines) < 2:
        return found | {"says": ""}
    errors, error = baselines[DISSIPATION].tolist(), float(row[DISSIPATION])
    found["lower_percent"], found["upper_percent"] = (
        spread_of(own[DISSIPATION].tolist(), one_more=True) if len(own) > 1 else range_of_single(error, errors)
    )
    if row["variant"] == BASELINE:
        return found | {"baseline_apart_percent": largest_difference(errors), "says": ""}
    difference = largest_difference([error, errors[0]])
    alike = difference <= largest_difference(errors) and (baselines["stable"] == row["stable"]).any()
    disagreed = len({_verdict(row, baseline) for _, baseline in baselines.iterrows()}) > 1
    found |= {"from_baseline_percent": difference, "baseline_apart_percent": largest_difference(errors)}
    return found | {"says": NOTHING if alike or disagreed else SOMETHING}


# Roll-outs of controls.tsv in which nothing is learned, and that of another seed.
UNLEARNED, OTHER_SEED = ("no_network", "scaled_power", "scaled_motion", "long_step"), "other_seed"
BASELINES = (*UNLEARNED, OTHER_SEED)
# What is shown of each, next to the length of its roll-out.
SHOWN = (DISSIPATION, "mean_square_speed_ratio", "increments_5ms_r", "balls_left")
# Whether the motion of the jar in a test is that of the training.
OF_THE_TRAINING, UNSEEN = "of the training", "unseen"
BASELINE_COLUMNS = ["test", "motion", "model", "training", "length_s", *SHOWN, "ran_away", "thesis_percent"]


def with_motion(table: pd.DataFrame, trained_test: str) -> pd.DataFrame:
    """The same with a column `motion` after `test`; trained_test: the test on the motion of the training."""
    motion = [OF_THE_TRAINING if test == trained_test else UNSEEN for test in table["test"]]
    own = table.assign(motion=motion)
    own.insert(list(table.columns).index("test") + 1, "motion", own.pop("motion"))
    return own


def baseline_rows(controls: pd.DataFrame) -> pd.DataFrame:
    """The rows of controls.tsv in which nothing is learned, as rows of metrics.tsv."""
    own = controls[controls["rollout"].isin(UNLEARNED)]
    return own.rename(columns={"rollout": "variant"}).drop(columns="met").reset_index(drop=True)


def _seed_rows(controls: pd.DataFrame) -> pd.DataFrame:
    """Another seed as a variant: its mean against both runs that it shares nothing with, as in `dem_reference`."""
    own = controls[controls["rollout"] == OTHER_SEED]
    return own.assign(variant=OTHER_SEED, value=own["dem_reference"].fillna(own["value"]))


def baseline_table(
    trainings: pd.DataFrame, controls: pd.DataFrame, printed: dict[str, float], trained_test: str
) -> pd.DataFrame:
    """A row for each test and training of a variant or baseline, with BASELINE_COLUMNS.

    trainings: as `millprint.thesis.surrogate.measures.tabulate_trainings`; controls: rows of controls.tsv;
    printed: the error of the dissipation that the thesis states, by test [%]; trained_test: as in `with_motion`. The
    measures of a roll-out that ran away are left empty.
    """
    baselines = pd.concat([baseline_rows(controls), _seed_rows(controls)]).assign(training=1)
    rows = pd.concat([trainings, baselines], ignore_index=True)
    table = []
    for test in controls["test"].unique():
        own = rows[rows["test"] == test]
        for (model, training), part in own.groupby(["variant", "training"], sort=False):
            value = part.set_index("measure")["value"]
            # What no network predicts cannot run away, however fast its balls.
            away = model not in BASELINES and test in failed_tests(part)
            row = {"test": test, "model": model, "training": training, "length_s": part["length_s"].max()}
            row |= {name: None if away and name != "balls_left" else value.get(name) for name in SHOWN}
            table.append(row | {"ran_away": "yes" if away else "no", "thesis_percent": printed.get(test)})
    return with_motion(pd.DataFrame(table), trained_test)[BASELINE_COLUMNS]


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
