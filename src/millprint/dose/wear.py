"""Wear of the balls by Archard's law on the sliding work of a simulation.

Archard (J. Appl. Phys. 24 (1953) 981): a body that slides a distance s under the normal load F loses the volume
V = K F s / H, with its hardness H [Pa] and a wear coefficient K [-]. Where a contact slides, its friction is mu F
(Coulomb), so the friction work of the ledger is W = mu F s, and

    F s = W / mu,    V = K W / (mu H).

Load and distance need not be recorded. Both bodies of a contact lose volume. The balls therefore lose

    m = rho K / H (2 W_bb / mu_bb + W_bw / mu_bw)

with the work of contacts between balls (bb) and with walls (bw). A jar of the same material loses the term of W_bw as
well. Hardness is the Vickers number times 9.807 MPa. K is fitted to weighings of the balls, so it includes what
Archard's law leaves out: impacts, abrasion by the powder, and powder that coats balls and jar
(`fit_wear` of the thesis). The sum of the sliding work over all contacts of run.h5, between balls and with
walls, is the ledger's channel `sliding`.
"""

import json
from collections.abc import Mapping
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
from scipy.constants import g as KGF
from scipy.constants import gram as GRAM
from scipy.constants import hour as HOUR

from millprint.config.dose import ChargeConfig
from millprint.config.errors import ConfigError
from millprint.config.sweep import as_tabulated
from millprint.estimate.quantiles import normal_quantile, student_quantile
from millprint.fingerprint.bands import Factors
from millprint.run.files import read_json
from millprint.run.hdf5 import open_hdf5
from millprint.run.tables import Number, Text, read_measured, refuse_rows

BALL_BALL, BALL_WALL = "ball_ball", "ball_wall"
KINDS = (BALL_BALL, BALL_WALL)
LOADS = {kind: f"load_{kind}_N_m_s" for kind in KINDS}
# The key of the friction of each kind of contact in a summary.
FRICTIONS = {BALL_BALL: "static_friction", BALL_WALL: "wall_static_friction"}
CONTACTS, SHARES = "every contact", "shares of the tangential energy"
# The columns that distinguish conditions; runs that are equal in them are seeds of one condition.
CONDITION = ["mill", "contact", "ball_diameter_mm", "fill_ratio", "speed_rpm"]
# More than contacts open at the ends of the window and the single precision of the table can cause.
LARGEST_GAP = 1e-3


def sliding_of_contacts(second: np.ndarray, sliding_J: np.ndarray) -> dict[str, float]:
    """Sliding work [J] between balls and with walls; second (n,): ball, or under 0 a wall; sliding_J (n,)."""
    of_balls = second >= 0
    return {
        BALL_BALL: float(sliding_J[of_balls].sum(dtype=float)),
        BALL_WALL: float(sliding_J[~of_balls].sum(dtype=float)),
    }


def load_distance(work_J: float, friction: float) -> float:
    """Normal load times sliding distance of contacts that slide [N m], from their friction work [J].

    Where a contact slides, its friction is mu F_n (Coulomb), so that the work mu F_n ds over mu is F_n ds; friction:
    mu [-]. NaN without friction.
    """
    return work_J / friction if friction > 0 else float("nan")


def sliding_of_run(run_path: str | Path, summary_path: str | Path) -> dict:
    """One row of the table of sliding: condition, balls, and powers by kind of contact.

    sliding_KIND_W: friction power; load_KIND_N_m_s: normal load times sliding distance a second; relative_error: of
    the tangential power, from whole revolutions, NaN for fewer than two; split: whether every contact was counted or,
    in a run with too many contacts to keep, the ledger's sliding work was divided by shares of the tangential energy.
    Raises ConfigError, in one line, for another file, and where contacts and ledger differ by more than LARGEST_GAP.
    """
    if not Path(summary_path).is_file():
        raise ConfigError(f"{summary_path}: no such file; a run has run.h5 and summary.json")
    summary = read_json(summary_path)
    with open_hdf5(run_path) as file:
        works, split = _works(file, summary)
        config = json.loads(file.attrs["config"])
    total = summary["ledger_J"]["sliding"]
    if abs(sum(works.values()) - total) > LARGEST_GAP * max(abs(total), 1e-12):
        raise ConfigError(
            f"{run_path}: sliding work of all contacts {sum(works.values()):.6g} J, of the ledger {total:.6g} J: "
            "run and summary are not of one simulation"
        )
    window, case = summary["window_s"], config["case"]
    error, power = summary["power_standard_error_W"]["tangential"], summary["power_W"]["tangential"]
    row = (
        {name: case[name] for name in CONDITION[:2]}
        | as_tabulated(case)
        | {"seed": case["seed"], "balls": summary["balls"]}
    )
    row |= {
        "balls_mass_kg": summary["balls"] * summary["ball_mass_kg"],
        "density_kg_m3": summary["density_kg_m3"],
        "volume_m3": summary["nominal_volume_m3"],
        "window_s": window,
        "relative_error": np.nan if error is None or power == 0 else error / power,
        "split": split,
    }
    for kind in KINDS:
        row[f"sliding_{kind}_W"] = works[kind] / window
        row[f"load_{kind}_N_m_s"] = (
            load_distance(works[kind], summary.get(FRICTIONS[kind], summary["static_friction"])) / window
        )
    return row


def _works(file: h5py.File, summary: dict) -> tuple[dict[str, float], str]:
    """Sliding work by kind in the window [J], and how it was split."""
    contacts = file["collisions"]
    if "second" in contacts:
        return sliding_of_contacts(contacts["second"][:], contacts["sliding_J"][:]), CONTACTS
    shares = summary["collisions"][0]["shares"]
    return {kind: summary["ledger_J"]["sliding"] * shares[kind]["tangential"] for kind in KINDS}, SHARES


def tabulate_sliding(runs: list[tuple[str, str]]) -> pd.DataFrame:
    """A row of `sliding_of_run` for each pair of run.h5 and summary.json."""
    return pd.DataFrame([sliding_of_run(*paths) for paths in runs])


def mean_conditions(table: pd.DataFrame) -> pd.DataFrame:
    """One row for each condition: means over its seeds, and the relative error of the mean.

    relative_error: the larger of the scatter between seeds and the scatter within windows, over the square root of the
    number of seeds.
    """
    loads = list(LOADS.values())
    rows = []
    for keys, runs in table.groupby(CONDITION, sort=False):
        total = runs[loads].sum(axis=1)
        spread = total.std(ddof=1) / total.mean() if len(runs) > 1 and total.mean() else np.nan
        errors = [error for error in (spread, runs["relative_error"].mean()) if np.isfinite(error)]
        about = runs[["balls", "balls_mass_kg", "density_kg_m3", "volume_m3"]].iloc[0].to_dict()
        rows.append(
            dict(zip(CONDITION, keys, strict=True))
            | about
            | {"seeds": len(runs), **runs[loads].mean().to_dict()}
            | {"relative_error": max(errors) / np.sqrt(len(runs)) if errors else np.nan}
        )
    return pd.DataFrame(rows)


# Pa in one Vickers unit, kgf/mm2.
VICKERS = KGF * 1e6
# With fewer weighings held back, Student's t dominates the interval.
FEWEST_HELD = 3
ORIGINS = ("coefficient", "scatter", "hardness", "contact")
ENDS = ("", "seen_lower_", "seen_upper_", "lower_", "upper_")
# Largest difference in fill ratio between a run and a weighing, as a fraction; probability of every interval [-].
FILL_TOLERANCE, PROBABILITY = 0.05, 0.95
WEAR_COLUMNS = [
    *(*CONDITION, "material", "bpr", "time_h", "powder_g"),
    *(f"{end}{name}" for name in ("wear_g", "powder_percent", "iron_percent") for end in ENDS),
    *("jar_g", *(f"factor_{origin}" for origin in ORIGINS), "note"),
]


def archard_mass(load_distance: float, coefficient: float, hardness_pa: float, density: float) -> float:
    """Mass lost by a body [kg]: rho K F s / H; load_distance: F s [N m], density [kg/m3]."""
    return density * coefficient * load_distance / hardness_pa


def worn_load(loads: Mapping[str, float]) -> float:
    """F s of all balls, 2 L_bb + L_bw, from F s of the contacts (a rate for rates); loads: by kind of contact."""
    return 2 * loads[BALL_BALL] + loads[BALL_WALL]


def read_materials(path: str | Path, needed: str = "") -> pd.DataFrame:
    """The table of materials, by name.

    Raises ConfigError, in one line, as `read_measured`, for a hardness outside its range, and if `needed` is missing.
    """
    names = ["density_kg_m3", "hardness_hv", "hardness_low_hv", "hardness_high_hv"]
    table = read_measured(
        path,
        [
            Text("material", unique=True),
            Number("density_kg_m3", 500, 25_000),
            *(Number(name, 5, 10_000) for name in names[1:]),
            Number("iron_share", 0, 1),
            Number("coefficient_factor", 1),
            Text("source"),
        ],
    )
    outside = ~table["hardness_hv"].between(table["hardness_low_hv"], table["hardness_high_hv"])
    why = "must lie between hardness_low_hv and hardness_high_hv"
    refuse_rows(table.rename(columns={"material": "case"}), path, "hardness_hv", outside, why)
    if needed and needed not in set(table["material"]):
        known = ", ".join(table["material"])
        raise ConfigError(f"{path}: dose.wear.material = {needed!r}: not in the column material; it has {known}")
    return table.set_index("material")


def read_coefficient(path: str | Path) -> dict:
    """Read the result of `fit_wear`. Raises ConfigError, in one line, for another file or a missing coefficient."""
    try:
        result = read_json(path)
    except FileNotFoundError:
        raise ConfigError(f"{path}: no such file; `snakemake --cores 2 dose` fits the coefficient") from None
    missing = [key for key in ("coefficient", "miss_log", "weighings_held_back", "material") if key not in result]
    if missing:
        raise ConfigError(f"{path}: {missing[0]}: this key is missing; must be a wear_coefficient.json")
    if result["coefficient"] is None:
        raise ConfigError(f"{path}: coefficient = null: {result.get('said', 'nothing was fitted')}")
    return result


def _factors(row: Mapping, material: pd.Series, result: Mapping, contact: Factors | None) -> dict[str, float]:
    """Half width of the interval of ln(wear) by each of ORIGINS; NaN where it is not known."""
    half = 0.5 + PROBABILITY / 2
    held = result["weighings_held_back"]
    own = material.name == result["material"]
    widths = dict.fromkeys(ORIGINS, np.nan) | {"hardness": 0.0}
    if held:
        widths["coefficient"] = float(student_quantile(half, held)) * result["miss_log"]
    if not own:
        # The hardness of the weighed material is part of its coefficient: only another material adds its uncertainty.
        widths["coefficient"] = float(np.hypot(widths["coefficient"], np.log(material["coefficient_factor"])))
    spans = (
        np.log(material["hardness_high_hv"] / material["hardness_hv"]),
        np.log(material["hardness_hv"] / material["hardness_low_hv"]),
    )
    widths["hardness"] = 0.0 if own else float(max(spans))
    widths["scatter"] = float(normal_quantile(half)) * row["relative_error"]
    if contact is not None and (contact.mill, contact.contact) == (row["mill"], row["contact"]):
        ends = np.log(contact.at(np.array([row["fill_ratio"], result["fill_ratio"]]))["Pt"])
        # In the mill and with the balls of the fit, contact parameters affect fit and prediction alike.
        same = (row["mill"], row["contact"]) == (result["mill"], result["contact"])
        widths["contact"] = float(np.abs(ends[:, 0] - ends[:, 1] if same else ends[:, 0]).max())
    return widths


def predict_wear(
    conditions: pd.DataFrame,
    materials: pd.DataFrame,
    charges: list[ChargeConfig],
    result: Mapping,
    contact: Factors | None,
) -> pd.DataFrame:
    """Wear and iron in the powder at every condition, for every material of balls and jar and every charge.

    result: of `fit_wear`; contact: factors by contact parameters of a mill, None where they were not analysed. Powers
    are proportional to the density of the balls (thesis Eq. 3.28). wear_g: of all balls; jar_g: of a jar of the same
    material, if no layer of powder protects it; powder_percent: wear over powder charged, as in Table 2.6;
    iron_percent: its iron. seen_: the range between the coefficients of single weighings. lower, upper: an interval of
    PROBABILITY by all ORIGINS, each with its own factor; unknown origins are left out and named in `note`. Nothing
    loses more than its mass.
    """
    rows = []
    if result["coefficient"] is None:
        return pd.DataFrame(columns=WEAR_COLUMNS)
    for condition in conditions.to_dict("records"):
        for name, material in materials.iterrows():
            denser = material["density_kg_m3"] / condition["density_kg_m3"]
            loads = {kind: denser * condition[column] for kind, column in LOADS.items()}
            mass = denser * condition["balls_mass_kg"]
            widths = _factors(condition, material, result, contact)
            known = [width for width in widths.values() if np.isfinite(width)]
            factor = float(np.exp(np.sqrt(np.square(known).sum())))
            for charge in charges:
                unit = (VICKERS * material["hardness_hv"], material["density_kg_m3"])
                time = charge.time_h * HOUR
                wear = archard_mass(worn_load(loads) * time, result["coefficient"], *unit)
                powder = mass / charge.bpr
                ends = {
                    "": wear,
                    "seen_lower_": wear * result["coefficient_lowest"] / result["coefficient"],
                    "seen_upper_": wear * result["coefficient_highest"] / result["coefficient"],
                    "lower_": wear / factor,
                    "upper_": wear * factor,
                }
                ends = {end: min(value, mass) for end, value in ends.items()}
                rows.append(
                    {column: condition[column] for column in CONDITION}
                    | {"material": name, "bpr": charge.bpr, "time_h": charge.time_h, "powder_g": powder / GRAM}
                    | {f"{end}wear_g": value / GRAM for end, value in ends.items()}
                    | {f"{end}powder_percent": 100 * value / powder for end, value in ends.items()}
                    | {
                        f"{end}iron_percent": 100 * material["iron_share"] * value / powder
                        for end, value in ends.items()
                    }
                    | {"jar_g": archard_mass(loads[BALL_WALL] * time, result["coefficient"], *unit) / GRAM}
                    | {f"factor_{origin}": float(np.exp(width)) for origin, width in widths.items()}
                    | {"note": _note(widths, material, result)}
                )
    return pd.DataFrame(rows)[WEAR_COLUMNS]


def _note(widths: Mapping[str, float], material: pd.Series, result: Mapping) -> str:
    notes = []
    if result["weighings_held_back"] < FEWEST_HELD:
        notes.append(f"weighings held back: {result['weighings_held_back']}, too few for a useful interval")
    if material.name != result["material"]:
        notes.append("coefficient of another material: an order of magnitude")
    unknown = [origin for origin, width in widths.items() if not np.isfinite(width)]
    if unknown:
        notes.append(f"not in the interval: {', '.join(unknown)}")
    return "; ".join(notes)
