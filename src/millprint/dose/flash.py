"""Flash temperatures of contacts: an estimate of how much warmer a contact is than the balls, while it lasts.

The balls are dry, clean and of one material. Heat is released evenly over the contact circle, half into each body
(radius a, heat flux q into each half [W/m2]). The estimate is the smaller of two closed forms:

- a half space heated for the time t of the contact (Carslaw and Jaeger, Conduction of Heat in Solids, 1959,
  Sec. 2.9): 2 q sqrt(chi t / pi) / k;
- the warmest point of a circle that slides at v for long (Jaeger 1942, Archard, Wear 2 (1959) 438, in the form of Tian
  and Kennedy, J. Tribol. 116 (1994) 167): 2 q a / (k sqrt(pi (1.273 + Pe))), Pe = v a / (2 chi).

k: conductivity [W/mK]; chi = k / (rho c): diffusivity [m2/s]. Powder between the surfaces, which takes a share of the
heat and makes the contact larger, oxides and roughness are left out: the result is an order of magnitude.
"""

import logging
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.config.dose import FlashSection
from millprint.dem.collisions import SLIDING, by_surface, read_rows
from millprint.run.files import read_json
from millprint.run.hdf5 import open_hdf5

logger = logging.getLogger("millprint")

# A contact up to this many times as long as Hertz's at the same approach is an impact; in longer ones balls rest or
# roll.
LONGEST_IMPACT = 2.0
# Hertz: duration over (m^2 / (E^2 R v))^(1/5) (Johnson, Contact Mechanics, 1985, Eq. 11.24).
HERTZ_TIME = 2.868
# The steady value of a circle at rest, in Tian and Kennedy's form.
STANDING = 1.273
# Columns of the table, by how the impacts are weighted.
QUANTILES = {"median": 0.5, "p99": 0.99, "largest": 1.0}


@dataclass(frozen=True)
class Impacts:
    """Impacts of a run, scaled to the real Young's modulus: (n,) each."""

    radius_m: np.ndarray
    """radius of the contact at the largest force"""
    duration_s: np.ndarray
    """time of the contact"""
    normal_J: np.ndarray
    """normal dissipation"""
    sliding_J: np.ndarray
    """tangential dissipation"""
    slip_speed_m_s: np.ndarray
    """mean speed of sliding, from the work of sliding, the friction and the mean force"""
    at_wall: np.ndarray
    """whether the partner is the wall"""

    def __len__(self) -> int:
        """The number of impacts."""
        return len(self.radius_m)


def contact_radius(force_N: np.ndarray, curvature_m: np.ndarray, modulus_Pa: float, hardness_Pa: float) -> np.ndarray:
    """Hertz's contact radius [m], a^3 = 3 F R / (4 E), or the radius with the hardness as mean pressure, if larger.

    curvature_m: R, 1/R = 1/R1 + 1/R2 (n,); modulus_Pa: E, 1/E = 2 (1 - nu^2) / E_material.
    """
    elastic = np.cbrt(0.75 * force_N * curvature_m / modulus_Pa)
    return np.maximum(elastic, np.sqrt(force_N / (np.pi * hardness_Pa)))


def half_space_K(flux_W_m2: np.ndarray, time_s: np.ndarray, conductivity: float, diffusivity: float) -> np.ndarray:
    """Temperature rise of the surface of a half space [K] after a time under an even flux."""
    return 2 * flux_W_m2 * np.sqrt(diffusivity * time_s / np.pi) / conductivity


def sliding_circle_K(
    flux_W_m2: np.ndarray, radius_m: np.ndarray, speed_m_s: np.ndarray, conductivity: float, diffusivity: float
) -> np.ndarray:
    """Largest temperature rise of a half space [K] below a circle of even flux that slides over it for long."""
    peclet = speed_m_s * radius_m / (2 * diffusivity)
    return 2 * flux_W_m2 * radius_m / (conductivity * np.sqrt(np.pi * (STANDING + peclet)))


def flash_K(impacts: Impacts, energy_J: np.ndarray, settings: FlashSection, conductivity: float) -> np.ndarray:
    """The estimate of each impact [K] (n,) from one of its energies, half of which enters each side."""
    diffusivity = conductivity / (settings.density_kg_m3 * settings.heat_capacity_J_kgK)
    flux = energy_J / 2 / impacts.duration_s / (np.pi * impacts.radius_m**2)
    return np.minimum(
        half_space_K(flux, impacts.duration_s, conductivity, diffusivity),
        sliding_circle_K(flux, impacts.radius_m, impacts.slip_speed_m_s, conductivity, diffusivity),
    )


def read_impacts(run_path: str | Path, summary: dict, settings: FlashSection) -> Impacts | None:
    """The impacts of a run that begin and end within its window; None if it has no table of collisions.

    None also, with a line in the log, for a contact law without a Young's modulus, which cannot be scaled.

    The DEM is softer than the material by s = E_material / E_DEM. In Hertz's impact of a given speed, the force grows
    as s^(2/5) and the duration falls as s^(-2/5) (Johnson 1985, Eqs 11.23, 11.24), while the dissipated energies stay.
    """
    if summary["young_modulus_pa"] is None:
        logger.warning("no flash temperatures of %s: they follow from Hertz's law, kind: hertz", summary["contact"])
        return None
    with open_hdf5(run_path) as file:
        begin_s = file["collisions"].attrs["begin_s"]
        names = ("start_s", "duration_s", "approach_speed_m_s", "peak_force_N", "normal_J", "damping_J", SLIDING)
        rows = read_rows(file["collisions"], names)
        radii = file["balls/radius_m"][:]
    if rows is None:
        return None
    contacts = by_surface(rows)
    column = {name: contacts[name].to_numpy() for name in contacts}
    whole = (column["complete"] > 0) & (column["start_s"] >= begin_s)
    first, second = column["first"], column["second"]
    at_wall = second < 0
    one, other = radii[first], np.where(at_wall, np.inf, radii[np.maximum(second, 0)])
    curvature = 1 / (1 / one + 1 / other)
    mass = _reduced(summary["density_kg_m3"], one, other)
    # Poisson's ratio of steel; its differences between steels change a by 1 %.
    soft, real = (
        modulus / (2 * (1 - 0.3**2)) for modulus in (summary["young_modulus_pa"], settings.young_modulus_gpa * 1e9)
    )
    speed = np.maximum(column["approach_speed_m_s"], 1e-12)
    hertz_s = HERTZ_TIME * (mass**2 / (soft**2 * curvature * speed)) ** 0.2
    chosen = whole & (column["duration_s"] <= LONGEST_IMPACT * hertz_s) & (column["peak_force_N"] > 0)
    stiffer = (real / soft) ** 0.4
    force = column["peak_force_N"][chosen] * stiffer
    duration = column["duration_s"][chosen] / stiffer
    sliding = np.maximum(column["damping_J"] + column["sliding_J"], 0.0)[chosen]
    friction = np.where(at_wall, summary["wall_static_friction"], summary["static_friction"])[chosen]
    # The mean of a half sine is 2 / pi of its largest value.
    drag = np.maximum(friction * force * 2 / np.pi, 1e-300)
    return Impacts(
        radius_m=contact_radius(force, curvature[chosen], real, settings.hardness_gpa * 1e9),
        duration_s=duration,
        normal_J=np.maximum(column["normal_J"][chosen], 0.0),
        sliding_J=sliding,
        slip_speed_m_s=sliding / duration / drag,
        at_wall=at_wall[chosen],
    )


def _reduced(density: float, one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Reduced mass [kg] of two balls, or of a ball and a wall (an infinite radius)."""
    masses = density * 4 / 3 * np.pi * one**3
    return 1 / (1 / masses + 1 / (density * 4 / 3 * np.pi * other**3))


def flash_rows(condition: str, impacts: Impacts, settings: FlashSection) -> list[dict[str, object]]:
    """The estimate of a condition [K], a row for each place and kind of heat.

    kind: `sliding` (only tangential energy) or `all` (normal energy too). `_low` and `_high` are from the largest and
    the smallest conductivity. mean_by_energy weights each impact with its energy: how hot is it where the energy goes?
    """
    rows = []
    ends = {"low": settings.conductivity_W_mK.high, "high": settings.conductivity_W_mK.low}
    for place, chosen in (("ball_ball", ~impacts.at_wall), ("ball_wall", impacts.at_wall)):
        for kind, energy in (("sliding", impacts.sliding_J), ("all", impacts.sliding_J + impacts.normal_J)):
            row: dict[str, object] = {
                "condition": condition,
                "place": place,
                "kind": kind,
                "impacts": int(chosen.sum()),
            }
            for end, conductivity in ends.items():
                rise, weight = flash_K(impacts, energy, settings, conductivity)[chosen], energy[chosen]
                numbers = np.quantile(rise, list(QUANTILES.values())) if len(rise) else [np.nan] * len(QUANTILES)
                row |= {f"{name}_{end}_K": value for name, value in zip(QUANTILES, numbers, strict=True)}
                row[f"mean_by_energy_{end}_K"] = np.average(rise, weights=weight) if weight.sum() > 0 else np.nan
            rows.append(row)
    return rows


def flash_table(paths: list[tuple[str, str]], settings: FlashSection) -> pd.DataFrame:
    """Estimates for runs (pairs of summary and run.h5), for each condition from its first seed."""
    rows: list[dict[str, object]] = []
    done: set[str] = set()
    for summary_path, run_path in paths:
        summary = read_json(summary_path)
        condition = Path(summary_path).parent.name.removesuffix(f"_s{summary['case']['seed']}")
        if condition not in done and (impacts := read_impacts(run_path, summary, settings)) is not None:
            rows += flash_rows(condition, impacts, settings)
            done.add(condition)
    columns = ["condition", "place", "kind", "impacts"]
    for end in ("low", "high"):
        columns += [*(f"{name}_{end}_K" for name in QUANTILES), f"mean_by_energy_{end}_K"]
    return pd.DataFrame(rows, columns=columns)
