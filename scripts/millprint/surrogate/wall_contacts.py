"""Where balls are when they touch the wall: what the wall threshold must cover (thesis Fig. 6.4)."""

import numpy as np
import pandas as pd

BIN_M = 1e-5


def wall_contact_table(distance: np.ndarray) -> pd.DataFrame:
    """Contacts in bins of signed distance: low_m, high_m, contacts."""
    # Bin edges are whole multiples of the bin, so that any threshold of the thesis is an edge.
    low = int(np.floor(min(distance.min(initial=-0.0053), -0.0056) / BIN_M))
    high = int(np.ceil(max(distance.max(initial=-0.0045), -0.0045) / BIN_M))
    edges = np.arange(low, high + 1) * BIN_M
    contacts, _ = np.histogram(distance, edges)
    return pd.DataFrame({"low_m": edges[:-1], "high_m": edges[1:], "contacts": contacts})


def covered_share(table: pd.DataFrame, threshold_m: float) -> float:
    """Share of wall contacts that a wall threshold covers, to the width of a bin."""
    beyond = table["low_m"] >= threshold_m - BIN_M / 2
    return float(table["contacts"][beyond].sum() / max(1, table["contacts"].sum()))
