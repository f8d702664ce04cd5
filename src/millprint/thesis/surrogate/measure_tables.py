"""Tables of the stage: a row for each measure, with the values of the thesis and the aims; wall contacts."""

import numpy as np
import pandas as pd

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
