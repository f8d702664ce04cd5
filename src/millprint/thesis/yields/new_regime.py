"""A change of the mechanical regime: predictions for fill ratios that are not in the training (thesis Sec. 5.3.3)."""

from collections.abc import Callable
from itertools import combinations

import numpy as np
import pandas as pd

from millprint.config.mill import MillConfig
from millprint.fingerprint.condition import Condition
from millprint.mill.bodies import CHECK_RPM, build_bodies, travel_m
from millprint.thesis.curves.regimes import design_cases, reference_condition
from millprint.thesis.doe.runs import YIELD
from millprint.thesis.yields.features import CONDITIONS
from millprint.thesis.yields.procedures import Procedure

SCREENING, REFERENCE = "screening", "reference"


def reference_of_mill(
    cases: pd.DataFrame, mill: MillConfig, reference_speed: float, density: float, diameter: float
) -> Condition[float]:
    """The condition of the reference case in a mill, at a speed [Hz], for a ball density [kg/m3] and diameter [m].

    The amplitude is half the longest travel of a wall, as in every run's summary. Raises ConfigError for a mill with an
    impossible shape.
    """
    return reference_condition(
        cases,
        speed_hz=reference_speed,
        ball_diameter_m=diameter,
        density_kg_m3=density,
        amplitude_m=travel_m(build_bodies(mill, CHECK_RPM), CHECK_RPM),
    )


def regime_rows(cases: pd.DataFrame, reference: Condition[float]) -> pd.DataFrame:
    """The cases of chapter 4 as rows of a yield model: case, regime (the fill ratio), the six conditions, yield.

    cases: as read_regimes gives them; reference: the condition of the reference case. That case is left out, since it
    is a run of the screening (case 14).
    """
    designed = design_cases(cases, reference)
    rows = cases[["case", "mode", "bpr", "molar_ratio", "time_h", YIELD]].assign(
        regime=[f"fill {fill:.2f}" for fill in cases["fill_ratio"]],
        normal_energy_uJ=1e6 * designed["normal_energy_J"],
        tangential_energy_uJ=1e6 * designed["tangential_energy_J"],
        specific_frequency_hz=designed["specific_frequency_hz"],
    )
    kept = rows[rows["mode"] != REFERENCE]
    return kept[["case", "regime", *CONDITIONS, YIELD]].reset_index(drop=True)


def without_regime(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows with the tangential share of the first row in all of them; the sum of both energies is not changed.

    A model then knows how strongly the powder was stressed, but not in which way. Its predictions for another regime
    show how well it does without the share.
    """
    energy = rows["normal_energy_uJ"] + rows["tangential_energy_uJ"]
    first = rows.iloc[0]
    share = first["tangential_energy_uJ"] / (first["normal_energy_uJ"] + first["tangential_energy_uJ"])
    return rows.assign(normal_energy_uJ=(1 - share) * energy, tangential_energy_uJ=share * energy)


def _training_sets(others: list[str], own: list[str]) -> list[tuple[str, list[str], list[str]]]:
    """Name of what is added, cases added, cases to predict: with and without the other regime and cases of the same."""
    sets = [("nothing", [], own), ("other regime", others, own)]
    for count in range(1, len(own)):
        for added in combinations(own, count):
            left = [case for case in own if case not in added]
            sets.append((f"{count} of the regime", list(added), left))
            sets.append((f"other regime, {count} of the regime", [*others, *added], left))
    return sets


def leave_regimes_out(
    screening: pd.DataFrame,
    regimes: pd.DataFrame,
    procedures: dict[tuple[str, str], tuple[Procedure, bool]],
    level: float,
    tick: Callable[[], None] = lambda: None,
) -> pd.DataFrame:
    """Predictions for every regime by models trained on the screening runs and on different added cases.

    screening, regimes: case, (regime,) the six conditions, yield_percent. procedures: by model and descriptors, with
    whether the tangential share is hidden from it; tick: called after each fit. Columns: model, descriptors, regime,
    added, added_cases, case, yield_percent, predicted_percent, error_pp, method, lower_percent, upper_percent.
    """
    everything = pd.concat([screening.assign(regime=SCREENING), regimes], ignore_index=True).set_index("case")
    tables = []
    for (model, descriptors), (procedure, hidden) in procedures.items():
        seen = without_regime(everything) if hidden else everything
        for regime, group in regimes.groupby("regime", sort=False):
            others = regimes.loc[regimes["regime"] != regime, "case"].tolist()
            for added, cases, unseen in _training_sets(others, group["case"].tolist()):
                train = seen.loc[[*screening["case"], *cases]].reset_index()
                truth = everything.loc[unseen, YIELD].to_numpy(float)
                answer = procedure(train, train[YIELD].to_numpy(float), seen.loc[unseen].reset_index(), [level])
                method, ends = next(iter(answer.intervals.items()))
                columns = {
                    "model": model,
                    "descriptors": descriptors,
                    "regime": regime,
                    "added": added,
                    "added_cases": ", ".join(cases),
                    "case": unseen,
                    "yield_percent": truth,
                    "predicted_percent": answer.predicted,
                    "error_pp": answer.predicted - truth,
                    "method": method,
                    "lower_percent": ends[:, 0, 0],
                    "upper_percent": ends[:, 0, 1],
                }
                tables.append(pd.DataFrame(columns))
                tick()
    return pd.concat(tables, ignore_index=True)


def summarise_regimes(table: pd.DataFrame) -> pd.DataFrame:
    """RMSE and mean error [pp] and the share of runs within their intervals, by model, descriptors and what was added.

    The mean is over the runs of both regimes, each predicted once for every set of cases that could have been added.
    """
    inside = table["yield_percent"].between(table["lower_percent"], table["upper_percent"])
    scored = table.assign(square=table["error_pp"] ** 2, inside=inside.astype(float))
    groups = scored.groupby(["model", "descriptors", "added"], sort=False)
    summary = groups.agg(
        rmse_pp=("square", "mean"),
        mean_error_pp=("error_pp", "mean"),
        covered=("inside", "mean"),
        predictions=("case", "size"),
    )
    return summary.assign(rmse_pp=np.sqrt(summary["rmse_pp"])).reset_index()
