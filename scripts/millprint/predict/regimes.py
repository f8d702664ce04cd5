"""A change of the mechanical regime: what a model trained at one fill ratio says of another (thesis Sec. 5.3.3)."""

from collections.abc import Callable
from itertools import combinations

import numpy as np
import pandas as pd

from millprint.config.mill import MillConfig
from millprint.doe.runs import YIELD
from millprint.fingerprint.condition import Condition
from millprint.fingerprint.regimes import design_cases, reference_condition
from millprint.mill.bodies import CHECK_RPM, build_bodies, travel_m
from millprint.predict.features import CONDITIONS
from millprint.predict.learners import Learner

SCREENING, REFERENCE = "screening", "reference"


def reference_of_mill(
    cases: pd.DataFrame, mill: MillConfig, reference_speed: float, density: float, diameter: float
) -> Condition[float]:
    """How the reference case is run in a mill: at a speed [Hz], with balls of a density [kg/m3] and diameter [m].

    The amplitude is half the longest way of a wall, as in every run's summary. Raises ConfigError for a mill whose
    shape does not hold.
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

    cases: as read_regimes gives them; reference: the condition of the reference case. That case is left out: it is a
    run of the screening (case 14).
    """
    designed = design_cases(cases, reference)
    rows = cases[["case", "mode", "bpr", "molar_ratio", "time_h", YIELD]].assign(
        regime=[f"fill {fill:.2f}" for fill in cases["fill_ratio"]],
        normal_energy_uJ=1e6 * designed["normal_energy_J"],
        tangential_energy_uJ=1e6 * designed["tangential_energy_J"],
        specific_frequency_hz=designed["frequency_per_ball_hz"],
    )
    kept = rows[rows["mode"] != REFERENCE]
    return kept[["case", "regime", *CONDITIONS, YIELD]].reset_index(drop=True)


def without_regime(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows as if every run had the tangential share of the first, at the energy that it had.

    A model then knows how hard the powder was stressed and not how: what is left of its answers for another regime
    is what it can say without the share.
    """
    energy = rows["normal_energy_uJ"] + rows["tangential_energy_uJ"]
    first = rows.iloc[0]
    share = first["tangential_energy_uJ"] / (first["normal_energy_uJ"] + first["tangential_energy_uJ"])
    return rows.assign(normal_energy_uJ=(1 - share) * energy, tangential_energy_uJ=share * energy)


def _training_sets(others: list[str], own: list[str]) -> list[tuple[str, list[str], list[str]]]:
    """(what was added, cases added, cases asked): nothing, each own case, the other regime, and both."""
    sets = [("nothing", [], own), ("other regime", others, own)]
    for count in range(1, len(own)):
        for added in combinations(own, count):
            asked = [case for case in own if case not in added]
            sets.append((f"{count} of the regime", list(added), asked))
            sets.append((f"other regime, {count} of the regime", [*others, *added], asked))
    return sets


def leave_regimes_out(
    screening: pd.DataFrame,
    regimes: pd.DataFrame,
    learners: dict[tuple[str, str], tuple[Learner, bool]],
    level: float,
    tick: Callable[[], None] = lambda: None,
) -> pd.DataFrame:
    """Predictions for every regime by models that were trained on the screening and on more and more beside it.

    screening, regimes: case, (regime,) the six conditions, yield_percent. learners: by model and descriptors, with
    whether the tangential share is hidden from it. Columns: model, descriptors, regime, added, added_cases, case,
    yield_percent, predicted_percent, error_pp, method, lower_percent, upper_percent.
    """
    everything = pd.concat([screening.assign(regime=SCREENING), regimes], ignore_index=True).set_index("case")
    tables = []
    for (model, descriptors), (learn, hidden) in learners.items():
        seen = without_regime(everything) if hidden else everything
        for regime, group in regimes.groupby("regime", sort=False):
            own = group["case"].tolist()
            others = regimes.loc[regimes["regime"] != regime, "case"].tolist()
            for added, cases, asked in _training_sets(others, own):
                train = seen.loc[[*screening["case"], *cases]].reset_index()
                truth = everything.loc[asked, YIELD].to_numpy(float)
                answer = learn(train, train[YIELD].to_numpy(float), seen.loc[asked].reset_index(), [level])
                method, ends = next(iter(answer.intervals.items()))
                tables.append(
                    pd.DataFrame(
                        {
                            "model": model,
                            "descriptors": descriptors,
                            "regime": regime,
                            "added": added,
                            "added_cases": ", ".join(cases),
                            "case": asked,
                            "yield_percent": truth,
                            "predicted_percent": answer.predicted,
                            "error_pp": answer.predicted - truth,
                            "method": method,
                            "lower_percent": ends[:, 0, 0],
                            "upper_percent": ends[:, 0, 1],
                        }
                    )
                )
                tick()
    return pd.concat(tables, ignore_index=True)


def summarise_regimes(table: pd.DataFrame) -> pd.DataFrame:
    """RMSE and mean error [pp] and the share of runs within their intervals, by model, descriptors and what was added.

    The mean is over the runs of both regimes, each asked once for every set of cases that could have been added.
    """
    found = []
    for keys, rows in table.groupby(["model", "descriptors", "added"], sort=False):
        error = rows["error_pp"].to_numpy(float)
        inside = rows["yield_percent"].between(rows["lower_percent"], rows["upper_percent"])
        found.append(
            dict(zip(("model", "descriptors", "added"), keys, strict=True))
            | {
                "rmse_pp": float(np.sqrt(np.mean(error**2))),
                "mean_error_pp": float(error.mean()),
                "covered": float(inside.mean()),
                "predictions": len(rows),
            }
        )
    return pd.DataFrame(found)
