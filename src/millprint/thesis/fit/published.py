"""The published values that a jar is compared with, with names and roles: fitted or held back."""

import numpy as np
import pandas as pd

from millprint.config.errors import ConfigError
from millprint.fingerprint.descriptors import CHANNELS, as_built
from millprint.thesis.curves.regimes import published_curves, published_cycles
from millprint.thesis.curves.scaling import average_curves

FITTED, HELD_BACK = "fitted", "held back"
POWERS, FREQUENCY = ("Pn", "Pt"), "f"
NAMING = ["name", "quantity", "fill_ratio", "ball_diameter_mm", "speed_rpm"]


def published_values(published: pd.DataFrame, contact: str) -> pd.DataFrame:
    """Every published power and frequency of a contact set: NAMING and `published`.

    Pn, Pt, f: points of the master curves (Table 4.2), means over ball sizes and speeds. normal, tangential: means of
    the dissipation per revolution [J] that Table 3.5 implies.
    """
    rows = []
    for point in published_curves(published, contact).to_dict("records"):
        for quantity in (*POWERS, FREQUENCY):
            name = f"{quantity}_f{point['fill_ratio']:.2f}"
            rows.append((name, quantity, point["fill_ratio"], np.nan, np.nan, point[quantity]))
    cycles = published_cycles(published)
    for cycle in cycles[cycles["contact"] == contact].to_dict("records"):
        for channel in CHANNELS:
            name = f"{channel}_d{cycle['ball_diameter_mm']:g}_n{cycle['speed_rpm']:g}"
            place = (cycle["fill_ratio"], cycle["ball_diameter_mm"], cycle["speed_rpm"])
            rows.append((name, channel, *place, cycle[f"{channel}_mean_J"]))
    return pd.DataFrame(rows, columns=[*NAMING, "published"])


def with_roles(values: pd.DataFrame, fitted: list[str]) -> pd.DataFrame:
    """The values with a column `role`, fitted or held back.

    Raises ConfigError for an unknown name, and where more than half of the powers or of the frequencies are fitted.
    """
    known = values["name"].tolist()
    for name in fitted:
        if name not in known:
            raise ConfigError(f"fit.fitted = {name}: must be one of {', '.join(known)}")
    values = values.assign(role=np.where(values["name"].isin(fitted), FITTED, HELD_BACK))
    for kind, part in values.groupby(values["quantity"] == FREQUENCY):
        share = (part["role"] == FITTED).mean()
        if share > 0.5:
            word = "frequencies" if kind else "powers"
            raise ConfigError(
                f"fit.fitted: {100 * share:.0f} % of the published {word} are fitted; at most half may be"
            )
    return values


def computed_values(
    values: pd.DataFrame, descriptors: pd.DataFrame, cycles: pd.DataFrame, mill: str, contact: str
) -> pd.DataFrame:
    """The published values with ours: columns ours, standard_error_percent, error_percent; NaN where not simulated.

    descriptors: of one counting rule; cycles: dissipation of revolutions; both as the fingerprint stage writes them.
    Points of the curves are means over the simulated ball sizes and speeds.
    """

    def own(table: pd.DataFrame) -> pd.DataFrame:
        return as_built(table[(table["mill"] == mill) & (table["contact"] == contact)])

    descriptors, cycles = own(descriptors), own(cycles)
    curves = average_curves(descriptors) if len(descriptors) else pd.DataFrame(columns=["fill_ratio"])
    found = [
        _of_curves(row, curves, descriptors) if row["quantity"] in (*POWERS, FREQUENCY) else _of_cycles(row, cycles)
        for row in values.to_dict("records")
    ]
    table = values.assign(ours=[value for value, _ in found], standard_error_percent=[error for _, error in found])
    return table.assign(error_percent=100.0 * (table["ours"] / table["published"] - 1.0))


def _of_curves(row: dict, curves: pd.DataFrame, descriptors: pd.DataFrame) -> tuple[float, float]:
    point = curves[np.isclose(curves["fill_ratio"].astype(float), row["fill_ratio"])]
    if point.empty:
        return np.nan, np.nan
    value = float(point[row["quantity"]].iloc[0])
    conditions = descriptors[np.isclose(descriptors["fill_ratio"], row["fill_ratio"])]
    error = float(np.sqrt((conditions[f"{row['quantity']}_se"] ** 2).sum()) / len(conditions))
    return value, 100.0 * error / value


def _of_cycles(row: dict, cycles: pd.DataFrame) -> tuple[float, float]:
    place = [np.isclose(cycles[key], row[key]) for key in ("fill_ratio", "ball_diameter_mm", "speed_rpm")]
    found = cycles[np.logical_and.reduce(place)] if len(cycles) else cycles
    if found.empty:
        return np.nan, np.nan
    cycle = found.iloc[0]
    error = cycle[f"{row['quantity']}_cv_percent"] / np.sqrt(cycle["revolutions"])
    return float(cycle[f"{row['quantity']}_mean_J"]), float(error)


def misfit(table: pd.DataFrame, role: str = FITTED) -> float:
    """Root mean square of log(ours / published) over the values of a role [-]; NaN if one was not simulated."""
    chosen = table[table["role"] == role]
    return float(np.sqrt((np.log(chosen["ours"] / chosen["published"]) ** 2).mean(skipna=False)))
