"""Predicts the descriptors of any speed, ball, amplitude and fill ratio from smooth master curves."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.config.sweep import ball_count
from millprint.errors import ConfigError
from millprint.files import read_json, read_table
from millprint.fingerprint.curves import QUANTITIES
from millprint.fingerprint.scaling import energy_scale, power_scale


@dataclass(frozen=True)
class Band:
    """A value with the ends of its interval."""

    value: float
    lower: float
    upper: float

    def times(self, factor: float) -> "Band":
        return Band(self.value * factor, self.lower * factor, self.upper * factor)


@dataclass(frozen=True)
class Prediction:
    """Descriptors of one condition; `outside` names what lies beyond the simulated range, where only scaling holds."""

    balls: int
    normal_energy_J: Band
    tangential_energy_J: Band
    frequency_per_ball_hz: Band
    normal_power_W: Band
    tangential_power_W: Band
    power_W: Band
    outside: tuple[str, ...]


def describe_curves(descriptors: pd.DataFrame, volume_m3: float) -> dict:
    """What a smooth curve was made of: mill, material and the ranges that were simulated."""
    first = descriptors.iloc[0]
    shared = ("density_kg_m3", "amplitude_m", "restitution", "static_friction", "collision_gap_s")
    ranged = ("fill_ratio", "speed_hz", "ball_diameter_m")
    return {
        "mill": first["mill"],
        "contact": first["contact"],
        "counting_rule": first["counting_rule"],
        "volume_m3": volume_m3,
        **{name: float(first[name]) for name in shared},
        "ranges": {name: [float(descriptors[name].min()), float(descriptors[name].max())] for name in ranged},
    }


class MasterCurves:
    """The smooth master curves of one mill and contact set (thesis Sec. 3.3.3).

    `table` is what `smooth_curves` returns, `about` what `describe_curves` returns.
    """

    def __init__(self, table: pd.DataFrame, about: dict):
        self.table = table
        self.about = about
        self._log_fill = np.log(table["fill_ratio"].to_numpy())

    @classmethod
    def read(cls, table_path: str | Path, about_path: str | Path) -> "MasterCurves":
        """Read the files of the rule fit_master_curves; raises ConfigError for a column that is missing."""
        columns = [f"{quantity}{end}" for quantity in QUANTITIES for end in ("", "_lower", "_upper")]
        return cls(read_table(table_path, numeric=["fill_ratio", *columns]), read_json(about_path))

    def _log_interpolate(self, column: str, log_fill: float) -> float:
        return float(np.exp(np.interp(log_fill, self._log_fill, np.log(self.table[column].to_numpy()))))

    def at(self, fill_ratio: float) -> dict[str, Band]:
        """Every scaled quantity at a fill ratio; raises ConfigError outside the simulated fill ratios.

        Pn, Pt and f are interpolated; ratio, P, En and Et follow from them.
        """
        low, high = self.table["fill_ratio"].iloc[[0, -1]]
        if not low * (1 - 1e-9) <= fill_ratio <= high * (1 + 1e-9):
            raise ConfigError(
                f"fill_ratio = {fill_ratio:g}: the curves of {self.about['contact']} hold from {low:g} to {high:g}"
            )
        place = np.log(fill_ratio)
        value = {name: self._log_interpolate(name, place) for name in ("Pn", "Pt", "f")}
        value["ratio"] = value["Pt"] / value["Pn"]
        value["P"] = value["Pn"] + value["Pt"]
        value["En"] = value["Pn"] / value["f"]
        value["Et"] = value["Pt"] / value["f"]
        return {
            name: Band(
                value[name],
                self._log_interpolate(f"{name}_lower", place),
                self._log_interpolate(f"{name}_upper", place),
            )
            for name in QUANTITIES
        }

    def predict(
        self,
        speed_hz: float,
        ball_diameter_m: float,
        fill_ratio: float,
        density_kg_m3: float | None = None,
        amplitude_m: float | None = None,
        volume_m3: float | None = None,
    ) -> Prediction:
        """Descriptors of a condition by Eqs 3.28, 3.29 and 4.5, as `Prediction`.

        Density, amplitude and jar volume are those simulated if left out. Speed, ball size, density, amplitude and
        volume outside the simulations are carried by the scaling and named in `outside`. Raises ConfigError for a
        fill ratio outside the curves.
        """
        about = self.about
        density = about["density_kg_m3"] if density_kg_m3 is None else density_kg_m3
        amplitude = about["amplitude_m"] if amplitude_m is None else amplitude_m
        volume = about["volume_m3"] if volume_m3 is None else volume_m3
        scaled = self.at(fill_ratio)
        energy = energy_scale(density, speed_hz, amplitude, ball_diameter_m)
        balls = ball_count(fill_ratio, volume, ball_diameter_m)
        power = balls * power_scale(density, speed_hz, amplitude, ball_diameter_m)
        given = {"speed_hz": speed_hz, "ball_diameter_m": ball_diameter_m}
        outside = [
            name
            for name, value in given.items()
            if not about["ranges"][name][0] * (1 - 1e-9) <= value <= about["ranges"][name][1] * (1 + 1e-9)
        ]
        fixed = {"density_kg_m3": density, "amplitude_m": amplitude, "volume_m3": volume}
        outside += [name for name, value in fixed.items() if not np.isclose(value, about[name])]
        return Prediction(
            balls=balls,
            normal_energy_J=scaled["En"].times(energy),
            tangential_energy_J=scaled["Et"].times(energy),
            frequency_per_ball_hz=scaled["f"].times(speed_hz),
            normal_power_W=scaled["Pn"].times(power),
            tangential_power_W=scaled["Pt"].times(power),
            power_W=scaled["P"].times(power),
            outside=tuple(outside),
        )
