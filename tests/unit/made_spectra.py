"""Energy spectra of made-up conditions: three bins each, small energies between balls and large ones at walls."""

import numpy as np
import pandas as pd

from millprint.dose.spectra import BIN_COLUMNS, BOTH, CHANNELS, OF_SPECTRUM, PAIRS, READ_OFF, TABLE_ONLY
from millprint.fingerprint.descriptors import CONDITION


def made_spectra(
    descriptors: pd.DataFrame, rules: tuple[str, ...] = ("gap_0_03",)
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Both tables of `tabulate_spectra` for the conditions of a table of descriptors; a later rule counts half."""
    bins, read = [], []
    for row in descriptors[CONDITION].drop_duplicates().to_dict("records"):
        for number, rule in enumerate(rules):
            for channel in CHANNELS:
                name = row | {"seeds": 1, "counting_rule": rule, "channel": channel}
                for start, pair in enumerate(PAIRS):
                    low = 10.0 ** (np.arange(3) - 6 + 2 * start)
                    values = {"energy_low_J": low, "energy_high_J": 10 * low, "collisions_hz": 100.0 / 2**number}
                    values |= {"power_W": 300 * low, "collisions_above_share": 1.0, "power_above_share": 1.0}
                    bins.append(pd.DataFrame(values).assign(**name, pair=pair))
                own = {"collisions_hz": 600.0 / 2**number, "power_W": 3.5, "mean_J": 6e-3, "median_J": 1e-4}
                read.append(name | {"pair": BOTH, "half_power_J": 2e-3 * (1 + number), "note": ""} | own)
    return (
        pd.concat(bins, ignore_index=True)[[*OF_SPECTRUM, *BIN_COLUMNS]],
        pd.DataFrame(read).reindex(columns=[*OF_SPECTRUM, *READ_OFF]),
    )


def without_contacts(summary: pd.DataFrame) -> pd.DataFrame:
    """What is read off runs that hold histograms only."""
    table = summary.drop_duplicates([*CONDITION, "counting_rule"]).assign(note=TABLE_ONLY)
    return table.assign(**dict.fromkeys(["channel", "pair", *READ_OFF[:-1]], np.nan))
