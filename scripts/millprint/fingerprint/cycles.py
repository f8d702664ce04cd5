"""Dissipation of one revolution of the mill: its mean, spread and distribution (thesis Table 3.5, Fig. 3.5)."""

import itertools

import numpy as np
import pandas as pd

from millprint.fingerprint.descriptors import CONDITION, NOTHING, condition_of

CHANNELS = ("normal", "tangential")
PARTS = ("mean_J", "sd_J", "cv_percent")


def _pooled(summaries: list[dict]) -> dict[tuple, dict[str, np.ndarray]]:
    """Energies of every revolution [J], all seeds of a condition together."""
    pooled: dict[tuple, dict[str, list]] = {}
    for summary in summaries:
        key = tuple(condition_of(summary).values())
        cycles = pooled.setdefault(key, {channel: [] for channel in CHANNELS})
        for channel in CHANNELS:
            cycles[channel].extend(summary["per_revolution"][f"{channel}_J"])
    return {
        key: {channel: np.asarray(values, dtype=float) for channel, values in cycles.items()}
        for key, cycles in sorted(pooled.items())
    }


def tabulate_cycles(summaries: list[dict]) -> pd.DataFrame:
    """Mean [J], standard deviation [J] and coefficient of variation [%] of the dissipation per revolution.

    One row a condition with at least two revolutions; the columns are those of Table 3.5.
    """
    rows = []
    for key, cycles in _pooled(summaries).items():
        if cycles["normal"].size < 2:
            continue
        row = dict(zip(CONDITION, key, strict=True)) | {"revolutions": cycles["normal"].size}
        for channel in CHANNELS:
            mean, deviation = cycles[channel].mean(), cycles[channel].std(ddof=1)
            row |= {
                f"{channel}_mean_J": mean,
                f"{channel}_sd_J": deviation,
                f"{channel}_cv_percent": 100.0 * deviation / mean,
            }
        rows.append(row)
    columns = [*CONDITION, "revolutions", *(f"{c}_{s}" for c in CHANNELS for s in PARTS)]
    return pd.DataFrame(rows, columns=columns)


def tabulate_densities(summaries: list[dict], fill_ratio: float, points: int = 120) -> pd.DataFrame:
    """Probability density [1/J] of the dissipation per revolution at one fill ratio, by a Gaussian kernel.

    Of the mill as built; conditions with fewer than three revolutions have no density.
    """
    # Takes long to import, and Snakemake imports this module to check what a user asks for.
    from scipy.stats import gaussian_kde

    frames = []
    for key, cycles in _pooled(summaries).items():
        condition = dict(zip(CONDITION, key, strict=True))
        if not np.isclose(condition["fill_ratio"], fill_ratio) or condition["varied"] != NOTHING:
            continue
        for channel in CHANNELS:
            energies = cycles[channel]
            if energies.size < 3 or np.ptp(energies) == 0:
                continue  # no density can be told from so few revolutions
            margin = 3.0 * energies.std(ddof=1)
            grid = np.linspace(max(energies.min() - margin, 0.0), energies.max() + margin, points)
            frames.append(
                pd.DataFrame(
                    condition | {"channel": channel, "energy_J": grid, "density_per_J": gaussian_kde(energies)(grid)}
                )
            )
    if not frames:
        return pd.DataFrame(columns=[*CONDITION, "channel", "energy_J", "density_per_J"])
    return pd.concat(frames, ignore_index=True)


def tabulate_published(cycles: pd.DataFrame, published: pd.DataFrame, mill: str, fill_ratio: float) -> pd.DataFrame:
    """Table 3.5 side by side: ours, the published value, and our deviation from the published one [%].

    cycles: as from `tabulate_cycles`; published: as from `published_cycles`. One row a condition of `mill` at the fill
    ratio; conditions that the thesis does not print have empty published columns.
    """
    ours = cycles[(cycles["mill"] == mill) & np.isclose(cycles["fill_ratio"], fill_ratio)]
    ours = ours[ours["varied"] == NOTHING].drop(columns=["mill", "varied", "density_kg_m3", "amplitude_m"])
    key = ["contact", "fill_ratio", "ball_diameter_mm", "speed_rpm"]
    table = ours.merge(published, how="left", on=key, suffixes=("", "_published"))
    for channel, part in itertools.product(CHANNELS, PARTS):
        name = f"{channel}_{part}"
        if f"{name}_published" in table:
            table[f"{name}_deviation_percent"] = 100.0 * (table[name] / table[f"{name}_published"] - 1.0)
    return table
