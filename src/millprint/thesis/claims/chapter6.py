"""Claims of thesis chapter 6 and appendix A: the surrogate."""

import numpy as np
import pandas as pd

from millprint.estimate.judge import AGREES, DIFFERS, OPEN
from millprint.thesis.claims.chapter3 import CONTACT, MILL
from millprint.thesis.claims.evidence import Evidence, Finding, NotRun, Repeats, claim, in_words, yes_no
from millprint.thesis.surrogate.measures import (
    BASELINE,
    DISSIPATION,
    NOTHING,
    PLATEAU,
    SOMETHING,
    failed_tests,
)

VARIANT = "thesis"
METRICS = "surrogate/metrics.tsv"
# The motion of a test, in words. On the trained motion, the roll-out begins after the time of the training.
TRAINED_TEST, TRAINED, UNSEEN = "trained", "the motion of the training", "a motion that was not trained on"
# What an interval is over.
TRAININGS = "trainings"
CORRELATIONS = -1.0, 1.0
# Tables 6.1 and 6.3.
SURROGATE_STEP_S, DEM_STEP_S = 1e-4, 9.5e-7
# Secs 6.2.2 and 6.3.4: the length of a roll-out [s], and the time that the thesis's simulation of it took [s].
STATED_S, DEM_S = 15.0, 22_734


@claim("6.timestep")
def time_step(evidence: Evidence) -> Finding:
    """Sec. 6.2.2."""
    evidence.cite("src/millprint/thesis/claims/chapter6.py", "SURROGATE_STEP_S, DEM_STEP_S", time_step)
    return Finding(100 * (SURROGATE_STEP_S / DEM_STEP_S - 1), "1e-4 s over 9.5e-7 s of Tables 6.3 and 6.1, less one")


@claim("6.duration")
def contact_duration(evidence: Evidence) -> Finding:
    """Sec. 6.2.2: of the simulation that the surrogate is trained on.

    Other seeds of this condition are shorter runs for other purposes, such as a smoke run in the same folder.
    """
    run = f"{MILL}/{CONTACT}/d10_f0.10_n300_s0"
    row = evidence.row(f"dem/{run}/summary.json", "median_contact_duration_s", "", f"no simulation of {run}")
    return Finding(float(row["median_contact_duration_s"]), "median of the contact lifetimes of 24 balls in one run")


def _measure(evidence: Evidence, test: str, measure: str) -> pd.Series:
    """A measure of the variant of the thesis in a test, which decides a claim.

    A shorter roll-out than the stated one decides only if it runs away.
    """
    path, absent = f"surrogate/{VARIANT}/metrics.tsv", f"no roll-out of variant {VARIANT}, test {test}"
    row = evidence.row(path, "value", f"test == '{test}' and measure == '{measure}'", absent)
    # Draws of trainings have the sizes of what did not run away only.
    runs_away = (evidence.table(path, f"test == '{test}' and measure == 'stable'")["value"] != 1).any()
    if row["length_s"] < STATED_S and not runs_away:
        raise NotRun(
            f"{STATED_S:g} s are stated, and this roll-out ends after {row['length_s']:g} s; {_over(row, test)}: "
            f"{measure} {row['value']:.3g} ({row['dem_reference']:.3g} of another seed of the DEM)"
            f"{_trainings(evidence, test, measure)}; {_course(_all_measures(evidence, test))}"
        )
    if runs_away and measure != "stable":
        # What ran away has no size.
        row = pd.concat([row.drop("value"), pd.Series({"value": np.inf})])
    return row


def _over(row: pd.Series, test: str) -> str:
    """The length of the roll-out behind a measure, and whether its motion was trained on, as text."""
    return f"over {row['length_s']:g} s of {TRAINED if test == TRAINED_TEST else UNSEEN}"


def _all_measures(evidence: Evidence, test: str) -> pd.Series:
    """All measures of the variant of the thesis in a test, by name, for explanations."""
    return evidence.table(METRICS, f"variant == '{VARIANT}' and test == '{test}'").set_index("measure")["value"]


@claim("6.mse")
def plateau(evidence: Evidence) -> Finding:
    """Sec. 6.4."""
    row = _measure(evidence, "trained", PLATEAU)
    centroid = _all_measures(evidence, "trained")["position_mse_centroid_m2"]
    return Finding(
        float(row["value"]),
        f"{_over(row, 'trained')}, after the time of the training; two DEM seeds are {row['dem_reference']:.2g} m2 "
        f"apart and every ball at the centre of mass scores {centroid:.2g} m2, so a plateau says nothing of "
        f"trajectories{_trainings(evidence, 'trained', PLATEAU, 'm2')}",
    )


@claim("6.energy.{test}")
@claim("6.energy")
def dissipation(evidence: Evidence, test: str = "trained") -> Finding:
    """Secs 6.3.1 and 6.3.2: the error of the cumulative dissipation."""
    row, own = _measure(evidence, test, DISSIPATION), _all_measures(evidence, test)
    return Finding(
        float(row["value"]),
        f"{_over(row, test)}, against our DEM; two DEM seeds differ by {row['dem_reference']:.2g} %; single "
        f"steps from DEM states, with the edges of the roll-out, are off by "
        f"{own['one_step_dissipation_bias_percent']:+.3g} % and explain {100 * own['one_step_acceleration_r2']:.3g} % "
        f"of the accelerations; {_course(own)}{_budget(evidence)}"
        f"{_trainings(evidence, test, DISSIPATION, '%')}{_others(evidence, test, DISSIPATION, '%')}",
    )


def _course(own: pd.Series) -> str:
    """The course of a roll-out, as text."""
    if own["stable"] == 1:
        return (
            f"the roll-out's mean square speed is {own['mean_square_speed_ratio']:.2g} of the DEM's: a small error of "
            "the sum can be these cancelling"
        )
    when = f", the first after {own['first_left_s']:.3g} s" if own["balls_left"] else ""
    return (
        f"the roll-out runs away: {int(own['balls_left'])} ball(s) cross the wall{when}, and its mean square speed is "
        f"{own['mean_square_speed_ratio']:.2g} of the DEM's"
    )


def _budget(evidence: Evidence) -> str:
    """The training of the variant, compared with the thesis, as text."""
    history = evidence.table(f"surrogate/{VARIANT}/loss.tsv")
    if history.empty:
        return ""
    last = history.iloc[-1]
    return f"; trained for {int(last['epoch'])} epochs in {last['elapsed_s']:.0f} s (the thesis: 2000)"


def _trainings(evidence: Evidence, test: str, measure: str, unit: str = "") -> str:
    """The values of all trainings of the variant of the thesis, as text."""
    table = evidence.table("surrogate/trainings.tsv", f"variant == '{VARIANT}' and test == '{test}'")
    values = table[table["measure"] == measure] if len(table) else table
    if len(values) < 2:
        return ""
    failed = [number for number, own in table.groupby("training") if failed_tests(own)]
    held = values[~values["training"].isin(failed)]
    if not failed:
        return f"; {len(values)} trainings: {in_words(values, '{value:.3g}')} {unit}"
    others = f"; the others: {in_words(held, '{value:.3g}')} {unit}" if len(held) else ""
    return f"; {len(failed)} of {len(values)} trainings failed (lost balls and ran away){others}"


def _others(evidence: Evidence, test: str, measure: str, unit: str) -> str:
    """The measures of the other variants and of the baselines, as text."""
    rows = evidence.table(METRICS, f"variant != '{VARIANT}' and test == '{test}' and measure == '{measure}'")
    return in_words(rows, f"; variant {{variant}}: {{value:.3g}} {unit}", "")


@claim("6.pearson")
def correlation(evidence: Evidence) -> Finding:
    """Sec. 6.3.2: of the cumulative curves, and of what is dissipated in each 5 ms, which says more."""
    rows, increments = (
        [_measure(evidence, test, measure) for test in ("motion1", "motion2")]
        for measure in ("cumulative_pearson_r", "increments_5ms_r")
    )
    own = [row["value"] for row in rows]
    text = " and ".join(f"{row['value']:.2f} (DEM seeds {row['dem_reference']:.2f})" for row in increments)
    explanation = (
        f"{_over(rows[0], 'motion1')}, the smaller of two; two unrelated DEM runs score "
        f"{min(row['dem_reference'] for row in rows):.4f}, so this measure is empty; increments over 5 ms correlate "
        f"at {text}"
    )
    if not np.isfinite(own).all():
        explanation = f"a roll-out is not finite, so that nothing correlates; {explanation}"
        return Finding(0.0, explanation, limits=CORRELATIONS, failed=True)
    return Finding(float(min(own)), explanation, limits=CORRELATIONS)


@claim("6.geometry")
def modified_geometry(evidence: Evidence) -> Finding:
    """Sec. 6.3.3: a jar with a post."""
    stable, own = _measure(evidence, "post", "stable"), _all_measures(evidence, "post")
    return yes_no(
        stable["value"] == 1,
        f"{_over(stable, 'post')}: {_course(own)}; dissipation is {own[DISSIPATION]:.3g} % off our DEM of the "
        f"modified jar"
        f"{_others(evidence, 'post', 'balls_left', 'ball(s) out')}",
    )


@claim("6.geometry.own")
def dissipation_of_its_own_jar(evidence: Evidence) -> Finding:
    """Sec. 6.3.3: the roll-out in the jar with a post against our simulation of that jar, by the error stated there."""
    row, own = _measure(evidence, "post", DISSIPATION), _all_measures(evidence, "post")
    told = f"{_over(row, 'post')}; two DEM seeds differ by {row['dem_reference']:.2g} %; {_course(own)}"
    return Finding(float(row["value"]), f"{told}{_trainings(evidence, 'post', DISSIPATION, '%')}")


@claim("6.geometry.dissipation")
def dissipation_of_the_original(evidence: Evidence) -> Finding:
    """Sec. 6.3.3: the roll-out in the jar with a post against the simulation of the jar without one."""
    row = _measure(evidence, "post", "dissipation_error_original_percent")
    return Finding(
        float(row["value"]),
        f"{_over(row, 'post')}; the thesis says itself that this agreement has no physical validity; see 6.geometry",
    )


def _timing(evidence: Evidence, columns: str) -> pd.Series:
    """The times of one trajectory of the thesis's Emax case, the one with the fewest balls."""
    where = f"variant == '{VARIANT}' and batch == 1 and balls == balls.min()"
    return evidence.row("surrogate/runtime.tsv", columns, where, f"no timing of variant {VARIANT}, batch 1")


def _timed(row: pd.Series) -> str:
    return f"{int(row['balls'])} balls, one trajectory, {row['basis']}"


@claim("6.runtime.ratio")
def speed_up(evidence: Evidence) -> Finding:
    """Sec. 6.3.4."""
    row = _timing(evidence, "dem_seconds_for_15_s, seconds_for_15_s")
    rivals = evidence.table("surrogate/runtime.tsv", f"variant != '{VARIANT}' and batch == 1 and balls == balls.min()")
    rivals = rivals.assign(ratio=rivals["dem_seconds_for_15_s"] / rivals["seconds_for_15_s"])
    return Finding(
        float(row["dem_seconds_for_15_s"] / row["seconds_for_15_s"]),
        f"our DEM over our surrogate in the same job: {_timed(row)}; our DEM takes {row['dem_seconds_for_15_s']:.3g} s "
        f"for what took the thesis's {DEM_S:,} s, so there is little left to "
        f"gain{in_words(rivals, '; variant {variant}: {ratio:.3g}', '')}",
    )


@claim("6.runtime.distance")
def time_of_the_distances(evidence: Evidence) -> Finding:
    """Secs 6.3.4 and 6.4: that the signed distance to the wall takes most of a roll-out's time."""
    evidence.cite("src/millprint/thesis/claims/chapter6.py", "no table", time_of_the_distances)
    raise NotRun("runtime.tsv has whole roll-outs only; no table has the parts of their time")


# What a verdict on a statement is as the value of a claim.
SAID = {AGREES: "yes", DIFFERS: "no"}


def _ablation(evidence: Evidence, variant: str, column: str) -> Finding:
    """A column of an ablation, compared with the baseline of the same budget."""
    path, absent = "surrogate/ablations.tsv", f"no ablation {variant} or {BASELINE}"
    row = evidence.row(path, column, f"variant == '{variant}'", absent)
    baseline = evidence.table(path, f"variant == '{BASELINE}'")
    if baseline.empty:
        raise NotRun(absent)
    nothing = "the baseline runs away too at this budget, so nothing follows; " if row["verdict"] == OPEN else ""
    told = (
        f"{'stable' if row['stable'] == 1 else 'unstable'}, {int(row['balls_left'])} ball(s) out, mean square speed "
        f"{row['mean_square_speed_ratio']:.2g} of the DEM's, dissipation error {row[DISSIPATION]:.3g} % against "
        f"{baseline[DISSIPATION].iloc[0]:.3g} % of the baseline; single steps from DEM states are off by "
        f"{row['one_step_dissipation_bias_percent']:+.3g} %; {int(row['epochs'])} epochs in "
        f"{row['training_s']:.0f} s (the thesis: 2000), roll-out of {row['rollout_s']:g} s"
    )
    value = SAID.get(row[column], row[column])
    interval = _interval(row, column, int(baseline["trainings"].iloc[0])) if _says(row) else None
    return Finding(value, nothing + told + _scatter(row), repeats=interval)


def _says(row: pd.Series) -> bool:
    """Whether the baseline was trained more than once, so that its scatter is known."""
    return row.get("says") in (SOMETHING, NOTHING)


def _scatter(row: pd.Series) -> str:
    """What the scatter between trainings leaves of an ablation, as text."""
    if not _says(row):
        return ""
    told = (
        f"its error is {row['from_baseline_percent']:.3g} points from the baseline's, and two trainings of the "
        f"baseline are up to {row['baseline_apart_percent']:.3g} points apart"
    )
    return f"; {told}{', so this row says nothing' if row['says'] == NOTHING else ''}"


def _interval(row: pd.Series, column: str, of_baseline: int) -> Repeats:
    """The interval of a column of an ablation, by its own trainings or by how those of the baseline scatter."""
    own = int(row["trainings"])
    if column == DISSIPATION:
        origin, repeats = (TRAININGS, own) if own > 1 else (f"{TRAININGS} of the baseline", of_baseline)
        return Repeats(float(row["lower_percent"]), float(row["upper_percent"]), origin, repeats)
    open_to_chance = row["says"] == NOTHING or row["verdict"] == OPEN
    lower, upper = ("no", "yes") if open_to_chance else (SAID[row[column]], SAID[row[column]])
    return Repeats(lower, upper, f"{TRAININGS} of the baseline", of_baseline)


@claim("A.{variant}")
def statement_on_an_ablation(evidence: Evidence, variant: str) -> Finding:
    """Whether the statement of appendix A on an ablation holds here."""
    return _ablation(evidence, variant, "verdict")


@claim("A.phi.shallow")
@claim("A.phi.deep")
@claim("A.global_loss")
def error_of_an_ablation(evidence: Evidence) -> Finding:
    """Figs A.7 to A.9: the error of the dissipation, where the thesis prints one."""
    variants = {"A.phi.shallow": "phi_shallow", "A.phi.deep": "phi_deep", "A.global_loss": "no_global_loss"}
    return _ablation(evidence, variants[evidence.id], DISSIPATION)
