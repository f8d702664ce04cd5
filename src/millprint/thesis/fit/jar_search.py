"""The search for the shape of a jar: published values, shapes, their trials, the steps from the best, and its files."""

import itertools
import logging
from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
import pandas as pd

from millprint.cases.simulate import simulate_each
from millprint.config.calibration import JarSearch, Stage
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError, SimulationError
from millprint.config.mill import MillConfig, StadiumGeometry
from millprint.config.sweep import Case, DemConfig
from millprint.dem.run import simulate
from millprint.fingerprint.descriptors import as_built, tabulate_descriptors
from millprint.mill.outlines import enclosed_volume
from millprint.mill.shapes import stadium_facets
from millprint.observables.counted_collisions import CHANNELS
from millprint.thesis.regimes import published_curves, published_cycles, read_published, tabulate_cycles
from millprint.thesis.scaling import average_curves

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


class Range(NamedTuple):
    """The values of a parameter of the jar: low, low + step, ... up to high."""

    low: float
    high: float
    step: float


# The parameters of the search; the end radius follows from them and the volume.
SHAPE = {
    "straight_ratio": Range(0.5, 1.6, 0.05),  # straight sides over the end radius [-]
    "height_mm": Range(31, 40, 0.5),  # inner height [mm]
    "facets_per_half_circle": Range(15, 41, 2),  # odd, so that the pattern is its own mirror image [-]
    "facet_unevenness": Range(0, 0.7, 0.05),  # as in the stadium [-]
    "fillet_radius_mm": Range(5.5, 12, 0.5),  # of the bottom edge's fillet [mm]
}
JAR_PARAMETERS = tuple(SHAPE)

# Range of the end radius in the search, over the cube root of the volume; tolerance of the radius [mm].
NARROWEST, WIDEST, CLOSE_MM = 0.1, 3.0, 1e-4


def parameters_of(geometry: StadiumGeometry) -> dict[str, float]:
    """The parameters of a jar, by name."""
    own = {name: float(getattr(geometry, name)) for name in JAR_PARAMETERS if name != "straight_ratio"}
    return {"straight_ratio": geometry.straight_mm / geometry.end_radius_mm, **own}


def places_of(jars: pd.DataFrame) -> np.ndarray:
    """Jars (n, 5) as places in the ranges of SHAPE, from 0 to 1."""
    ranges = list(SHAPE.values())
    low, high = (np.array([getattr(allowed, end) for allowed in ranges]) for end in ("low", "high"))
    return (jars[list(JAR_PARAMETERS)].to_numpy(dtype=float) - low) / (high - low)


def on_grid(value: float, allowed: Range) -> float:
    """The nearest value on the grid of a parameter."""
    last = int((allowed.high - allowed.low) / allowed.step + 1e-9)
    steps = np.clip(round((value - allowed.low) / allowed.step), 0, last)
    return float(np.round(allowed.low + allowed.step * steps, 9))


def volume_ml(geometry: StadiumGeometry) -> float:
    """Inner volume of the facetted jar [mL]."""
    return enclosed_volume(stadium_facets(geometry)) * 1e6


def shaped(mill: MillConfig, parameters: dict[str, float]) -> MillConfig:
    """The mill with a jar of these parameters, its end radius such that the facetted jar holds the mill's volume.

    Raises ConfigError where no end radius does.
    """
    # Slow to import, and the tables of a fit import this module.
    from scipy.optimize import brentq

    whole = {name: value for name, value in parameters.items() if name != "straight_ratio"}
    whole["facets_per_half_circle"] = int(whole["facets_per_half_circle"])
    size = mill.volume_ml ** (1 / 3) * 10

    def jar(radius: float) -> StadiumGeometry:
        sizes = {"end_radius_mm": radius, "straight_mm": radius * parameters["straight_ratio"]}
        return StadiumGeometry.model_validate({**mill.geometry.model_dump(), **whole, **sizes})

    def excess(radius: float) -> float:
        return volume_ml(jar(radius)) - mill.volume_ml

    narrowest = max(NARROWEST * size, 1.01 * parameters["fillet_radius_mm"])
    if excess(narrowest) > 0 or excess(WIDEST * size) < 0:
        described = ", ".join(f"{name} {value:g}" for name, value in parameters.items())
        raise ConfigError(f"fit: no jar of {mill.volume_ml:g} mL has {described}")
    radius = brentq(excess, narrowest, WIDEST * size, xtol=CLOSE_MM)
    return mill.model_copy(update={"geometry": jar(round(radius, 3))})


def trial_cases(mill: str, values: pd.DataFrame, settings: JarSearch, stage: Stage) -> list[Case]:
    """The cases that give every fitted value: fill ratios, ball sizes and speeds as the value or the settings have."""
    places: set[tuple[float, float, float]] = set()
    for row in values[values["role"] == FITTED].to_dict("records"):
        single = np.isfinite(row["ball_diameter_mm"])
        diameters = [row["ball_diameter_mm"]] if single else settings.ball_diameters_mm
        speeds = [row["speed_rpm"]] if single else settings.speeds_rpm
        places |= set(itertools.product(diameters, [row["fill_ratio"]], speeds))
    return [
        case_of(mill, settings, *place, stage.revolutions, seed)
        for place, seed in itertools.product(sorted(places), range(stage.seeds))
    ]


def case_of(
    mill: str, settings: JarSearch, diameter_mm: float, fill_ratio: float, speed_rpm: float, turns: float, seed: int = 0
) -> Case:
    """A case of a jar; its first window and what is discarded before it are counted in turns."""
    place = {"ball_diameter_m": diameter_mm / 1e3, "fill_ratio": fill_ratio, "speed_hz": speed_rpm / 60, "seed": seed}
    counts = {"discard_s": settings.discard_revolutions, "window_s": turns}
    times = {name: count * 60.0 / speed_rpm for name, count in counts.items()}
    if settings.power_error_max:
        times["window_max_s"] = settings.longest * times["window_s"]
    common = settings.model_dump(include={"contact", "time_step_s", "power_error_max", "closure_max", "settle_s"})
    return Case(mill=mill, **common, **place, **times)


def trial_of(
    mill: MillConfig, contact: ContactConfig, dem: DemConfig, settings: JarSearch, published_paths: list[str]
) -> Callable[[dict[str, float], Stage], pd.DataFrame]:
    """What simulates a jar of given parameters, in a stage of the search, in place of the mill's.

    It returns the published values with those of the jar, once under each counting rule of the settings, whose name is
    in the column counting_rule. Raises ConfigError for a jar that cannot be built.
    """
    values = with_roles(published_values(read_published(*published_paths), settings.contact), settings.fitted)

    def trial(parameters: dict[str, float], stage: Stage) -> pd.DataFrame:
        jar = shaped(mill, parameters)
        cases = trial_cases(mill.name, values, settings, stage)
        runs = {case.path: case.model_dump() for case in cases}
        summaries = simulate_each(runs, lambda own: simulate(Case(**own), jar, contact, dem), (), "jar")
        return under_rules(list(summaries.values()), values, settings.counting_rules, mill.name, settings.contact)

    return trial


def under_rules(summaries: list[dict], values: pd.DataFrame, rules: list[str], mill: str, contact: str) -> pd.DataFrame:
    """The values of summaries under each rule, one below the other; powers do not depend on it."""
    cycles = tabulate_cycles(summaries)
    tables = [
        computed_values(values, tabulate_descriptors(summaries, rule), cycles, mill, contact).assign(counting_rule=rule)
        for rule in rules
    ]
    return pd.concat(tables, ignore_index=True)


def best_rule(trial: pd.DataFrame) -> pd.DataFrame:
    """The rows of a trial under the counting rule with the smallest misfit."""
    return min((own for _, own in trial.groupby("counting_rule", sort=False)), key=misfit)


logger = logging.getLogger("millprint")

# A function that simulates a jar in a stage of the search: the published values with ours.
Trial = Callable[[dict[str, float], Stage], pd.DataFrame]
Jar = tuple[float, ...]


class Search:
    """The jars that were simulated, with their misfits. A jar is a tuple of JAR_PARAMETERS."""

    def __init__(self, settings: JarSearch, trial: Trial) -> None:
        self.settings, self.trial = settings, trial
        self.rows: list[dict] = []

    @cache  # noqa: B019 (a search lives as long as its job)
    def misfit(self, jar: Jar, stage: str) -> float:
        """The misfit of a jar in a stage [-]; inf for one that cannot be built or run. Each is simulated once."""
        parameters = dict(zip(JAR_PARAMETERS, jar, strict=True))
        try:
            table = self.trial(parameters, getattr(self.settings, stage))
        except (ConfigError, SimulationError) as error:
            logger.info("%s: %s", parameters, error)
            return float("inf")
        found = []
        for rule, own in table.groupby("counting_rule", sort=False):
            found.append(misfit(own))
            errors = own.dropna(subset="ours").set_index("name")["error_percent"]
            row = {"stage": stage, **parameters, "counting_rule": rule, "misfit": found[-1]}
            row |= {"held_back_misfit": misfit(own[own["ours"].notna()], HELD_BACK)}
            self.rows.append(row | {f"{name}_percent": value for name, value in errors.items()})
        logger.info("%s %s: misfit %.3f", stage, parameters, min(found))
        return min(found)

    def table(self) -> pd.DataFrame:
        """A row for every trial and counting rule: stage, parameters, misfit [-], and the error of each value [%]."""
        return pd.DataFrame(self.rows)

    def run(self, present: dict[str, float]) -> dict[str, float]:
        """The best jar of the search, which includes the present one."""
        screened = sorted(candidates(self.settings, present), key=lambda jar: self.misfit(jar, "screening"))
        best = min(screened[: self.settings.refining.jars], key=lambda jar: self.misfit(jar, "refining"))
        for _ in range(self.settings.rounds):
            around = [best, *neighbours(best)]
            better = min(around, key=lambda jar: self.misfit(jar, "refining"))
            if better == best:
                break
            best = better
        return dict(zip(JAR_PARAMETERS, best, strict=True))


def candidates(settings: JarSearch, present: dict[str, float]) -> list[Jar]:
    """The present jar, then a Sobol sequence over the ranges, every parameter on its grid."""
    # Slow to import, and the tables of a fit import this module.
    from scipy.stats import qmc

    ranges = list(SHAPE.values())
    # A power of two keeps the sequence balanced; what is too much is not simulated.
    places = qmc.Sobol(len(ranges), seed=settings.seed).random_base2((settings.screening.jars - 1).bit_length())
    scaled = qmc.scale(places, [allowed.low for allowed in ranges], [allowed.high for allowed in ranges])
    drawn = [tuple(map(on_grid, place, ranges)) for place in scaled[: settings.screening.jars - 1]]
    return list(dict.fromkeys([tuple(present[name] for name in JAR_PARAMETERS), *drawn]))


def neighbours(jar: Jar) -> list[Jar]:
    """The jars one step down and one up in each parameter that stay in the ranges."""
    found = []
    for index, name in enumerate(JAR_PARAMETERS):
        allowed = SHAPE[name]
        for step in (-allowed.step, allowed.step):
            value = round(jar[index] + step, 9)
            if allowed.low - 1e-9 <= value <= allowed.high + 1e-9:
                found.append((*jar[:index], value, *jar[index + 1 :]))
    return found


FIT_COLUMNS = [
    "record", "parameter", "parameter_value", "step", *NAMING, "role", "counting_rule", "published", "ours",
    "error_percent", "standard_error_percent", "change_percent",
]  # fmt: skip


def parameter_rows(parameters: dict[str, float], end_radius_mm: float, rule: str) -> pd.DataFrame:
    """Records `parameter`: what was fitted; the end radius follows from the volume."""
    jar = {**parameters, "end_radius_mm": end_radius_mm}
    rows = [{"record": "parameter", "parameter": name, "parameter_value": value} for name, value in jar.items()]
    return pd.DataFrame([*rows, {"record": "parameter", "parameter": "counting_rule", "counting_rule": rule}])


def sensitivity_rows(jar: dict[str, float], settings: JarSearch, trial: Trial) -> pd.DataFrame:
    """Records `sensitivity`: every value that the search simulates, for a step down and up in each parameter.

    change_percent is against the unchanged jar under the same short windows, those of refining; its standard error is
    standard_error_percent. A jar that cannot be built is left out.
    """
    present = tuple(jar[name] for name in JAR_PARAMETERS)
    unchanged = best_rule(trial(jar, settings.refining))
    tables = []
    for other in neighbours(present):
        index = next(k for k, value in enumerate(other) if value != present[k])
        name = JAR_PARAMETERS[index]
        try:
            changed = best_rule(trial(dict(zip(JAR_PARAMETERS, other, strict=True)), settings.refining))
        except ConfigError:
            continue
        error = np.hypot(changed["standard_error_percent"], unchanged["standard_error_percent"])
        tables.append(
            changed.assign(
                record="sensitivity",
                parameter=name,
                parameter_value=other[index],
                step=other[index] - present[index],
                change_percent=100.0 * (changed["ours"] / unchanged["ours"] - 1.0),
                standard_error_percent=error,
            )
        )
    return pd.concat(tables).dropna(subset="ours") if tables else pd.DataFrame(columns=FIT_COLUMNS)


def fit_table(parameters: pd.DataFrame, values: pd.DataFrame, sensitivity: pd.DataFrame) -> pd.DataFrame:
    """The kinds of records one below the other, with FIT_COLUMNS; `misfit`: of fitted and of held-back values."""
    misfits = [
        {"record": "misfit", "parameter_value": misfit(values[values["ours"].notna()], role), "role": role}
        for role in (FITTED, HELD_BACK)
    ]
    frames = [parameters, pd.DataFrame(misfits), values.assign(record="value"), sensitivity]
    return pd.concat([frame for frame in frames if len(frame)], ignore_index=True).reindex(columns=FIT_COLUMNS)
