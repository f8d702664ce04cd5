"""Claims of chapter 6 and appendix A: the surrogate."""

from pathlib import Path

import numpy as np
import pandas as pd

from millprint.claims.finding import Finding
from millprint.files import read_json, read_table
from millprint.surrogate.ablations import BASELINE, DISSIPATION, OPEN, PLATEAU
from millprint.surrogate.tables import covered_share

VARIANT = "thesis"
# Tables 6.1 and 6.3.
SURROGATE_STEP_S, DEM_STEP_S, WALL_THRESHOLD_M = 1e-4, 9.5e-7, -0.0052
BALL_THRESHOLD_M, SNAP_BACK_M = 0.0015, -0.0049

# Ablations whose claim is a word, and those whose claim is the error of the dissipation.
STATEMENTS = ("window3", "window9", "layers2", "layers4", "width64", "mlp2")
NUMBERS = {"A.phi.shallow": "phi_shallow", "A.phi.deep": "phi_deep", "A.global_loss": "no_global_loss"}


def findings(results: Path, data: Path) -> dict[str, Finding]:
    """What was computed for every claim of chapter 6 and appendix A."""
    folder = results / "surrogate"
    return {
        "6.timestep": Finding(
            100 * (SURROGATE_STEP_S / DEM_STEP_S - 1), "1e-4 s over 9.5e-7 s of Tables 6.3 and 6.1, less one"
        ),
        "6.contacts": _contacts(folder / "wall_contacts.tsv"),
        "6.duration": _duration(results),
        **_rollouts(folder / "metrics.tsv"),
        **_runtimes(folder / "runtime.tsv"),
        **_ablations(folder / "ablations.tsv"),
    }


def _not_run(path: Path, target: str) -> Finding:
    return Finding(None, f"not run: {path.name} is written by the target {target}")


def _contacts(path: Path) -> Finding:
    if not path.exists():
        return _not_run(path, "surrogate")
    table = read_table(path, numeric=["low_m", "high_m", "contacts"])
    share = 100 * covered_share(table, WALL_THRESHOLD_M)
    return Finding(
        share,
        f"of {int(table['contacts'].sum())} balls at the wall in the training snapshots; with an exact distance a "
        "10 mm ball touches at -5 mm or above, so any threshold below that covers all",
    )


def _duration(results: Path) -> Finding:
    summaries = sorted((results / "dem").glob("*/calibrated/d10_f0.10_n300_s*/summary.json"))
    chosen = [path for path in summaries if path.parts[-4] == "emax"]
    if not chosen:
        return Finding(None, "not run: no simulation of emax/calibrated/d10_f0.10_n300")
    durations = [read_json(path)["median_contact_duration_s"] for path in chosen]
    return Finding(float(np.median(durations)), f"contact lifetimes of 24 balls, median of {len(chosen)} seed(s)")


def _measure(table: pd.DataFrame, variant: str, test: str, measure: str) -> pd.Series | None:
    rows = table[(table["variant"] == variant) & (table["test"] == test) & (table["measure"] == measure)]
    return rows.iloc[0] if len(rows) else None


def _rollouts(path: Path) -> dict[str, Finding]:
    names = ("6.mse", "6.energy", "6.energy.motion1", "6.energy.motion2", "6.pearson", "6.geometry")
    if not path.exists():
        return dict.fromkeys(names, _not_run(path, "surrogate"))
    table = read_table(path, text=["variant", "test", "measure"])
    found = {"6.mse": _plateau(table), "6.pearson": _pearson(table), "6.geometry": _geometry(table)}
    budget = _budget(path.parent / VARIANT / "loss.tsv")
    for name, test in (("6.energy", "trained"), ("6.energy.motion1", "motion1"), ("6.energy.motion2", "motion2")):
        found[name] = _dissipation(table, test, budget)
    return found


def _missing(test: str) -> Finding:
    return Finding(None, f"not run: no roll-out of variant {VARIANT}, test {test}")


def _plateau(table: pd.DataFrame) -> Finding:
    row = _measure(table, VARIANT, "trained", PLATEAU)
    centroid = _measure(table, VARIANT, "trained", "position_mse_centroid_m2")
    if row is None or centroid is None:
        return _missing("trained")
    return Finding(
        float(row["value"]),
        f"on time after the training; two DEM seeds are {row['dem_reference']:.2g} m2 apart and every ball at the "
        f"centre of mass scores {centroid['value']:.2g} m2, so a plateau says nothing of trajectories",
    )


def _dissipation(table: pd.DataFrame, test: str, budget: str) -> Finding:
    row = _measure(table, VARIANT, test, DISSIPATION)
    if row is None:
        return _missing(test)
    own = table[(table["variant"] == VARIANT) & (table["test"] == test)].set_index("measure")["value"]
    return Finding(
        float(row["value"]),
        f"against our DEM; two DEM seeds differ by {row['dem_reference']:.2g} %; single steps from DEM states, with "
        f"the edges of the roll-out, are off by {own['one_step_dissipation_bias_percent']:+.3g} % and explain "
        f"{100 * own['one_step_acceleration_r2']:.3g} % of the accelerations; {_course(own)}"
        + budget
        + _others(table, test, DISSIPATION, "%"),
    )


def _course(own: pd.Series) -> str:
    """What became of a roll-out."""
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


def _budget(path: Path) -> str:
    """How long the variant was trained, beside the thesis."""
    if not path.exists():
        return ""
    history = read_table(path, numeric=["epoch", "elapsed_s"])
    last = history.iloc[-1]
    return f"; trained for {int(last['epoch'])} epochs in {last['elapsed_s']:.0f} s (the thesis: 2000)"


def _others(table: pd.DataFrame, test: str, measure: str, unit: str) -> str:
    """What the other variants score."""
    rows = table[(table["variant"] != VARIANT) & (table["test"] == test) & (table["measure"] == measure)]
    return "".join(f"; variant {row.variant}: {row.value:.3g} {unit}" for row in rows.itertuples())


def _pearson(table: pd.DataFrame) -> Finding:
    motions = ("motion1", "motion2")
    rows, increments = (
        [row for test in motions if (row := _measure(table, VARIANT, test, measure)) is not None]
        for measure in ("cumulative_pearson_r", "increments_5ms_r")
    )
    if min(len(rows), len(increments)) < len(motions):
        return _missing(" or ".join(motions))
    own = [row["value"] for row in rows]
    text = " and ".join(f"{row['value']:.2f} (DEM seeds {row['dem_reference']:.2f})" for row in increments)
    explanation = (
        f"the smaller of the two; two unrelated DEM runs score {min(row['dem_reference'] for row in rows):.4f}, so "
        f"this measure is empty; increments over 5 ms correlate at {text}"
    )
    if not np.isfinite(own).all():
        return Finding(0.0, f"a roll-out is not finite, so that nothing correlates; {explanation}")
    return Finding(float(min(own)), explanation)


def _geometry(table: pd.DataFrame) -> Finding:
    if _measure(table, VARIANT, "post", "stable") is None:
        return _missing("post")
    own = table[(table["variant"] == VARIANT) & (table["test"] == "post")].set_index("measure")["value"]
    return Finding(
        "yes" if own["stable"] == 1 else "no",
        f"{_course(own)}; dissipation is {own[DISSIPATION]:.3g} % off our DEM of the modified jar"
        + _others(table, "post", "balls_left", "ball(s) out"),
    )


def _runtimes(path: Path) -> dict[str, Finding]:
    names = ("6.runtime.ratio", "6.runtime.dem", "6.runtime.sgn")
    if not path.exists():
        return dict.fromkeys(names, _not_run(path, "surrogate"))
    numbers = ["balls", "batch", "seconds_for_15_s", "dem_seconds_for_15_s"]
    table = read_table(path, numeric=numbers, text=["variant", "basis"])
    # The Emax case of the thesis is the one with the fewest balls.
    alone = table[(table["batch"] == 1) & (table["balls"] == table["balls"].min())].set_index("variant")
    if VARIANT not in alone.index:
        return dict.fromkeys(names, _missing("timing, batch 1"))
    row = alone.loc[VARIANT]
    ratios = alone["dem_seconds_for_15_s"] / alone["seconds_for_15_s"]
    ours = f"{int(row['balls'])} balls, one trajectory, {row['basis']}"
    others = "".join(f"; variant {name}: {ratio:.3g}" for name, ratio in ratios.items() if name != VARIANT)
    return {
        "6.runtime.ratio": Finding(
            float(ratios[VARIANT]),
            f"our DEM over our surrogate in the same job: {ours}; our DEM takes {row['dem_seconds_for_15_s']:.3g} s "
            f"for what took the thesis's 22,734 s, so there is little left to gain{others}",
        ),
        "6.runtime.dem": Finding(float(row["dem_seconds_for_15_s"]), "our DEM, 15 s of motion on one core"),
        "6.runtime.sgn": Finding(float(row["seconds_for_15_s"]), ours),
    }


def _ablations(path: Path) -> dict[str, Finding]:
    claims = {f"A.{variant}": variant for variant in STATEMENTS} | NUMBERS
    if not path.exists():
        return dict.fromkeys(claims, _not_run(path, "ablations"))
    table = read_table(path, text=["variant", "thesis_statement"]).set_index("variant")
    found = {}
    for claim, variant in claims.items():
        if not {variant, BASELINE} <= set(table.index):
            found[claim] = Finding(None, f"not run: no ablation {variant} or {BASELINE}")
            continue
        row = table.loc[variant]
        value = float(row[DISSIPATION]) if claim in NUMBERS else row["holds"]
        found[claim] = Finding(value, _ablation(row, table.loc[BASELINE]))
    return found


def _ablation(row: pd.Series, baseline: pd.Series) -> str:
    """What was measured of an ablation, beside the baseline of the same budget."""
    nothing = "the baseline runs away too at this budget, so nothing follows; " if row["holds"] == OPEN else ""
    return nothing + (
        f"{'stable' if row['stable'] == 1 else 'unstable'}, {int(row['balls_left'])} ball(s) out, mean square speed "
        f"{row['mean_square_speed_ratio']:.2g} of the DEM's, dissipation error {row[DISSIPATION]:.3g} % against "
        f"{baseline[DISSIPATION]:.3g} % of the baseline; single steps from DEM states are off by "
        f"{row['one_step_dissipation_bias_percent']:+.3g} %; {int(row['epochs'])} epochs in "
        f"{row['training_s']:.0f} s (the thesis: 2000), roll-out of {row['rollout_s']:g} s"
    )
