"""A mill enlarged by geometric similarity: how to run it for the same fingerprint, and what it costs to simulate.

All lengths of vessel and motion grow by L = (V / V_0)^(1/3). With energies per collision ~ rho omega^2 A^2 d^3, a
frequency ~ omega and a power ~ rho omega^3 A^2 d^3 of one ball (Eqs 3.28, 3.29), each row keeps one of them. Unchanged
balls keep the chemistry of a collision. Enlarged balls, at omega ~ L^(-1/2), keep every scaled number, including the
share of gravity A omega^2 / g. In a charge of several sizes, all sizes grow by the same factor.
"""

from dataclasses import replace

import pandas as pd

from millprint.cases.of_mill import RUN_WAY, WAYS
from millprint.config.mill_sweep import ScaleUpConfig
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.predicted_values import Prediction
from millprint.observables.definitions import POWER, SCALED_BY

SECONDS_PER_HOUR = 3600.0


def _ratio(large: Prediction, small: Prediction, name: str) -> float:
    return getattr(large, name).value / getattr(small, name).value


def tabulate_scale_up(
    fingerprint: Fingerprint, factor: float, settings: ScaleUpConfig, step_s: float, ns_per_ball_step: float
) -> pd.DataFrame:
    """Speed, balls, descriptors, their ratios to the small mill's, and the costs of each way to run the large mill.

    factor: L [-]; step_s: the step for the small mill's balls [s], which grows with them; ns_per_ball_step: measured.
    A charge of several sizes has its name and sizes in separate columns.
    `hours` is the time of one core for settings.revolutions. The fingerprint predicts the descriptors at the large
    amplitude: this is beyond what was simulated, so by the scaling of the thesis, and `outside` says so. `froude` is
    A omega^2 / g over the small mill's: where it is not 1, gravity matters more or less than in the small mill.
    """
    volume = fingerprint.about["volume_m3"]
    diameter, charge = fingerprint.balls(settings.ball_diameter_mm)
    small = fingerprint.condition(
        speed_hz=settings.speed_rpm / 60, ball_diameter_m=diameter, fill_ratio=settings.fill_ratio
    )
    small_found = fingerprint.predict(small, charge=charge)
    small_mass = small.fill_ratio * volume * small.density_kg_m3
    rows = []
    for way in WAYS:
        larger = factor if way.balls_grow else 1.0
        large = replace(
            small,
            speed_hz=small.speed_hz * factor**way.power,
            ball_diameter_m=small.ball_diameter_m * larger,
            amplitude_m=small.amplitude_m * factor,
        )
        found = fingerprint.predict(large, volume_m3=volume * factor**3, charge=charge)
        step = step_s * larger
        steps = settings.revolutions / large.speed_hz / step
        rows.append(
            {
                "way": way.name,
                "keeps": way.keeps,
                "length_factor": factor,
                "volume_L": 1e3 * volume * factor**3,
                "amplitude_mm": 1e3 * small.amplitude_m * factor,
                "ball_diameter_mm": 1e3 * large.ball_diameter_m,
                **(fingerprint.charges[charge].columns(larger) if charge else {}),
                "speed_rpm": 60 * large.speed_hz,
                "balls": found.balls,
                "froude": factor ** (1 + 2 * way.power),
                **{name: getattr(found, name).value for name in SCALED_BY},
                POWER: found.wall_power_W.value,
                "specific_power_W_kg": found.wall_power_W.value / (small_mass * factor**3),
                "weighted_normal_energy_ratio": _ratio(found, small_found, "weighted_normal_energy_J"),
                "weighted_normal_frequency_ratio": _ratio(found, small_found, "weighted_normal_frequency_hz"),
                "specific_power_ratio": found.wall_power_W.value / small_found.wall_power_W.value / factor**3,
                "outside": ", ".join(found.outside) or "nothing",
                "time_step_s": step,
                "steps": steps,
                "ns_per_ball_step": ns_per_ball_step,
                "hours": steps * found.balls * ns_per_ball_step * 1e-9 / SECONDS_PER_HOUR,
            }
        )
    return pd.DataFrame(rows)


def compare_run(sheet: pd.DataFrame, large: dict, rule: dict) -> pd.DataFrame:
    """The large run compared with its prediction in the sheet; for each quantity foreseen, simulated and their ratio.

    large: summary of the run; rule: its collisions by the fingerprint's counting rule.
    """
    foreseen = sheet.set_index("way").loc[RUN_WAY.name]
    simulated = {
        "balls": large["balls"],
        **{f"weighted_{name}_energy_J": large["weighted"][name]["energy_J"] for name in ("normal", "tangential")},
        "normal_energy_J": rule["mean_normal_J"],
        "tangential_energy_J": rule["mean_tangential_J"],
        "specific_frequency_hz": rule["specific_frequency_hz"],
        POWER: large["power_W"]["wall"],
        "ns_per_ball_step": large["ns_per_ball_step"],
    }
    return pd.DataFrame(
        [
            {"quantity": name, "foreseen": foreseen[name], "simulated": value, "ratio": value / foreseen[name]}
            for name, value in simulated.items()
        ]
    )
