"""The energy ledger: work of walls and gravity against stored and dissipated energy."""

import numpy as np
import pandas as pd

from millprint.config.errors import SimulationError
from millprint.dem.recording import SAMPLE_NAMES


def ledger_series(samples: np.ndarray) -> pd.DataFrame:
    """The ledger as a time series of energies [J], with works counted from the first sample.

    samples: (m, width) rows of layout.SampleColumns, at least one. Returns m rows with those columns and with
    sliding_J, kinetic_J, elastic_J, gravity_work_J and imbalance_J.

    sliding_J is the tangential work that is neither damping nor held by the tangential springs. It includes what a
    spring gives up when its stiffness falls with the overlap, so that nothing of the tangential work is lost.
    """
    series = pd.DataFrame(samples, columns=SAMPLE_NAMES)
    works = ["wall_work_J", "normal_damping_J", "tangential_damping_J", "tangential_work_J", "rolling_J"]
    series[works] -= series[works].iloc[0]
    stored = series["elastic_tangential_J"] - series["elastic_tangential_J"].iloc[0]
    series["sliding_J"] = series["tangential_work_J"] - series["tangential_damping_J"] - stored
    series["kinetic_J"] = series["kinetic_translation_J"] + series["kinetic_spin_J"]
    series["elastic_J"] = series["elastic_normal_J"] + series["elastic_tangential_J"]
    series["gravity_work_J"] = series["potential_J"].iloc[0] - series["potential_J"]
    series["imbalance_J"] = (
        series["wall_work_J"]
        + series["gravity_work_J"]
        - (series["kinetic_J"] - series["kinetic_J"].iloc[0])
        - (series["elastic_J"] - series["elastic_J"].iloc[0])
        - series[["normal_damping_J", "tangential_damping_J", "sliding_J", "rolling_J"]].sum(axis=1)
    )
    return series


# Ledger in a summary [J]: work of walls and gravity, dissipated and stored energies, and the imbalance.
LEDGER_CHANNELS = (
    "wall_work",
    "gravity_work",
    "normal_damping",
    "tangential_damping",
    "sliding",
    "rolling",
    "kinetic_change",
    "elastic_change",
    "imbalance",
)


def ledger_summary(series: pd.DataFrame) -> dict[str, float]:
    """Totals of each channel over the series [J]; imbalance is work less what is dissipated and stored."""
    last, first = series.iloc[-1], series.iloc[0]
    totals = {
        "kinetic_change": float(last["kinetic_J"] - first["kinetic_J"]),
        "elastic_change": float(last["elastic_J"] - first["elastic_J"]),
    }
    return {name: totals[name] if name in totals else float(last[f"{name}_J"]) for name in LEDGER_CHANNELS}


def work_scale(series: pd.DataFrame) -> float:
    """What an error of the energy balance is a fraction of [J]: the wall work.

    If the walls do next to no work (a mill at rest, or one that only lifts and lowers its balls), a tenth of the energy
    dissipated, or of what gravity takes and gives.
    """
    last = series.iloc[-1]
    to_and_fro = series["potential_J"].diff().abs().sum()
    dissipated = last[["normal_damping_J", "tangential_damping_J", "sliding_J", "rolling_J"]].sum()
    return float(max(abs(last["wall_work_J"]), 0.1 * dissipated, 0.1 * to_and_fro))


def closure(series: pd.DataFrame) -> float:
    """Error of the energy balance over the series, as a fraction of `work_scale` [-]."""
    scale = work_scale(series)
    return float(abs(series["imbalance_J"].iloc[-1]) / scale) if scale > 0 else 0.0


class OpenBalanceError(SimulationError):
    """An energy balance that does not close, and why.

    found, its error, is over `largest`, fractions of the wall work [-]; step_factor: what the step is multiplied by so
    that it may close, 0 where a shorter one does not help.
    """

    def __init__(self, found: float, largest: float, cause: str = "", step_factor: float = 0.0) -> None:
        balance = (
            f"the energy balance is open by {100 * found:.3g} % of the wall work (closure_max {100 * largest:g} %)"
        )
        super().__init__(f"{balance}: {cause}" if cause else balance)
        self.step_factor = step_factor


def check_closure(series: pd.DataFrame, largest: float) -> float:
    """The closure; raises OpenBalanceError, without a cause, where it exceeds `largest`."""
    error = closure(series)
    if not error <= largest:
        raise OpenBalanceError(error, largest)
    return error
