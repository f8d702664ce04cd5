"""Energy spectra: collisions per second, and power, over the energy of a collision.

A collision of a counting rule has a normal energy (damping along the line of centres) and a tangential energy (damping
and sliding along the surface). Each kind of energy has a separate spectrum, in which a collision counts at its energy
of that kind. The integral of a power spectrum is the power of the ledger:

    sum of the bins + what a threshold of the rule drops - what tangential springs stored = power of the ledger

The record of a run holds what a contact dissipated within the window, also for a contact that was open at the start or
the end. Such a contact has only this part of its energy in the spectrum, and counts as a collision if it begins in the
window, as in the descriptors. The tangential work of a contact that is still open includes the energy stored in its
spring, which is not dissipation: ledger and table give it separately.
"""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.config.counting import CountingRule, recorded_count
from millprint.config.errors import ConfigError, MillprintError
from millprint.dem.collisions import ROUNDING
from millprint.dem.turns import scale_of_hits
from millprint.fingerprint.descriptors import CHARGE, CONDITION, CONDITION_TEXT, ONE_SIZE, condition_of
from millprint.fingerprint.readers import Contacts, collisions_by, read_contacts
from millprint.observables.counted_collisions import BOTH, CHANNELS, PAIRS
from millprint.run.files import read_table
from millprint.run.job import progress

# Edges of the bins [J], five in a factor of ten, evenly spaced in the logarithm; the bins at the ends are open.
BIN_EDGES = np.geomspace(1e-12, 10.0, 13 * 5 + 1)
# Largest difference between a spectrum's integral and the ledger, over the power of the ledger.
CLOSURE_MAX = 1e-3

# The columns that identify a spectrum, then the columns of its bins, and of the numbers read off it.
OF_SPECTRUM = [*CONDITION, "seeds", "counting_rule", "channel", "pair"]
BIN_COLUMNS = [
    *("energy_low_J", "energy_high_J", "collisions_hz", "power_W"),
    *("collisions_above_share", "power_above_share"),
]
READ_OFF = [
    *("collisions_hz", "power_W", "power_share", "mean_J", "median_J", "half_power_J", "beyond_bins_share"),
    *("dropped_W", "stored_W", "open_W", "ledger_W", "error_percent", "note"),
]
TABLE_ONLY = "run.h5 has no table of its many contacts; record a shorter window"


def read_spectra(path: str | Path) -> pd.DataFrame:
    """Read a table of `tabulate_spectra`."""
    text, powers = [*CONDITION_TEXT, "counting_rule", "channel", "pair"], ["collisions_hz", "power_W"]
    table = read_table(path, numeric=["fill_ratio", *powers], text=text, may_be_blank=powers)
    return table.fillna({CHARGE: ONE_SIZE})


def spectrum(energy: np.ndarray, rate: np.ndarray, power: np.ndarray, edges: np.ndarray) -> tuple[np.ndarray, ...]:
    """Collisions per second and power [W] in each bin, both (bins + 2,); the first and last bins are beyond the edges.

    energy [J], rate [1/s] and power [W]: of each collision, (collisions,). Contacts without energy of this kind, and
    the few whose spring gave back more than they dissipated in the window, are in the first bin.
    """
    place = np.searchsorted(edges, energy, side="right")
    return tuple(np.bincount(place, weights=weight, minlength=len(edges) + 1) for weight in (rate, power))


def weighted_median(values: np.ndarray, weights: np.ndarray) -> float:
    """The smallest value at which the weights of all values up to it reach half of their sum; nan without weights."""
    if not weights.sum() > 0:
        return np.nan
    order = np.argsort(values)
    return float(values[order][np.searchsorted(np.cumsum(weights[order]), weights.sum() / 2)])


def _share_above(values: np.ndarray) -> np.ndarray:
    """Share of the sum of the values in each bin and the bins above it; 0 if the sum is 0."""
    total = values.sum()
    return np.cumsum(values[::-1])[::-1] / total if total else np.zeros_like(values)


def _bins_of(energy: np.ndarray, rate: np.ndarray, power: np.ndarray, edges: np.ndarray) -> pd.DataFrame:
    """BIN_COLUMNS of a spectrum, from its first bin with a collision to its last. An open bin has an empty edge."""
    rates, powers = spectrum(energy, rate, power, edges)
    table = pd.DataFrame(
        {
            "energy_low_J": [np.nan, *edges],
            "energy_high_J": [*edges, np.nan],
            "collisions_hz": rates,
            "power_W": powers,
            "collisions_above_share": _share_above(rates),
            "power_above_share": _share_above(powers),
        }
    )
    filled = np.flatnonzero((rates != 0) | (powers != 0))
    return table.iloc[filled[0] : filled[-1] + 1] if len(filled) else table.iloc[:0]


def _read_off(energy: np.ndarray, rate: np.ndarray, power: np.ndarray, edges: np.ndarray) -> dict[str, float]:
    """What people compare: rates, mean, median, and the energy above which half of the power falls [J]."""
    collisions, total = rate.sum(), power.sum()
    beyond = (energy < edges[0]) | (energy >= edges[-1])
    return {
        "collisions_hz": collisions,
        "power_W": total,
        "mean_J": total / collisions if collisions else np.nan,
        "median_J": weighted_median(energy, rate),
        "half_power_J": weighted_median(energy, np.maximum(power, 0.0)),
        "beyond_bins_share": power[beyond].sum() / total if total else 0.0,
    }


def _condition_tables(
    key: dict, runs: list[tuple[str, dict, Contacts]], rule_name: str, edges: np.ndarray
) -> tuple[list[pd.DataFrame], list[dict]]:
    """Bins and rows of one condition by one rule; its seeds have equal weights, as in the descriptors."""
    parts = []
    for _, summary, contacts in runs:
        rule = CountingRule.of_count(recorded_count(summary, rule_name))
        parts.append(collisions_by(contacts, rule, summary["frequency_hz"]))
    bins: list[pd.DataFrame] = []
    rows: list[dict] = []
    seeds = len(runs)
    for channel in CHANNELS:
        dropped = sum(part.dropped_W[channel] for part in parts) / seeds
        stored = sum(contacts.stored_J / contacts.window_s for _, _, contacts in runs) / seeds
        ledger = sum(summary["power_W"][channel] for _, summary, _ in runs) / seeds
        of_channel: dict[str, dict] = {}
        for pair in (*PAIRS, BOTH):
            chosen = [part.chosen(pair) for part in parts]
            energy = np.concatenate([part.energy[channel][mask] for part, mask in zip(parts, chosen, strict=True)])
            rate = np.concatenate([part.rate[mask] for part, mask in zip(parts, chosen, strict=True)]) / seeds
            window = np.repeat([part.window_s for part in parts], [mask.sum() for mask in chosen])
            power = energy / window / seeds
            name = {**key, "seeds": seeds, "counting_rule": rule_name, "channel": channel, "pair": pair}
            of_channel[pair] = name | _read_off(energy, rate, power, edges)
            if pair != BOTH:
                bins.append(_bins_of(energy, rate, power, edges).assign(**name))
        whole = of_channel[BOTH]
        for row in of_channel.values():
            row["power_share"] = row["power_W"] / whole["power_W"] if whole["power_W"] else 0.0
        stored = stored if channel == "tangential" else 0.0
        difference = whole["power_W"] + dropped - stored - ledger
        # Also of hits by the speed of the wall: next to their power, balls that rest have none.
        powers = [
            scale_of_hits(summary) * summary["frequency_hz"] + sum(abs(summary["power_W"][name]) for name in CHANNELS)
            for _, summary, _ in runs
        ]
        rounding = ROUNDING * sum(powers) / seeds
        whole |= {
            "dropped_W": dropped,
            "stored_W": stored,
            "open_W": sum(contacts.open_J[channel] / contacts.window_s for _, _, contacts in runs) / seeds,
            "ledger_W": ledger,
            "error_percent": 100.0 * difference / ledger if abs(ledger) > rounding else 0.0,
        }
        if abs(difference) > CLOSURE_MAX * abs(ledger) + rounding:
            raise MillprintError(
                f"{runs[0][0]}: its contacts dissipate {whole['power_W'] + dropped - stored:.6g} W ({channel}), its "
                f"ledger has {ledger:.6g} W; delete the folder and run the simulation again"
            )
        rows += of_channel.values()
    return bins, rows


def tabulate_spectra(
    runs: Iterable[tuple[str, dict]], rule_names: list[str], edges: np.ndarray = BIN_EDGES
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Spectra of every condition, and the numbers read off each: OF_SPECTRUM with BIN_COLUMNS, and with READ_OFF.

    runs: path of each run.h5 with its summary; the seeds of a condition are averaged with equal weights. If a
    run has no contacts, its condition has one row without numbers, which says so. Raises ConfigError for a rule that a
    run lacks, and MillprintError if the contacts do not add up to the power of the ledger.
    """
    conditions: dict[tuple, list[tuple[str, dict]]] = {}
    for path, summary in runs:
        conditions.setdefault(tuple(condition_of(summary).values()), []).append((path, summary))
    bins: list[pd.DataFrame] = []
    rows: list[dict] = []
    bar = progress(len(conditions), None, unit="condition")
    for values in sorted(conditions):
        bar.update()
        key = dict(zip(CONDITION, values, strict=True))
        read = [(path, summary, read_contacts(path)) for path, summary in conditions[values]]
        whole = [(path, summary, contacts) for path, summary, contacts in read if contacts is not None]
        for rule_name in rule_names:
            if len(whole) < len(read):
                rows.append(key | {"seeds": len(read), "counting_rule": rule_name, "note": TABLE_ONLY})
                continue
            new_bins, new_rows = _condition_tables(key, whole, rule_name, edges)
            bins += new_bins
            rows += new_rows
    bar.close()
    if not rows:
        raise ConfigError("dose.spectra: no simulation to read; sweeps must hold a case without snapshots")
    columns = [*OF_SPECTRUM, *BIN_COLUMNS]
    table = pd.concat(bins, ignore_index=True)[columns] if bins else pd.DataFrame(columns=columns)
    return table, pd.DataFrame(rows, columns=[*OF_SPECTRUM, *READ_OFF])
