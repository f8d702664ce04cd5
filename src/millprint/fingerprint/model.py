"""The fingerprint of one mill and contact set: its description, and a model that predicts descriptors."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import overload

import numpy as np
import pandas as pd

from millprint.config.charge import ONE_SIZE, BallMixture, balls_in_words, fill_from
from millprint.config.errors import ConfigError
from millprint.config.load import check_model
from millprint.config.mill_sweep import FEWEST_FILLS
from millprint.config.sweep import ball_count
from millprint.estimate.estimates import ENDS, WIDEST, Estimate, Interval, columns_of, share_of
from millprint.fingerprint.bands import FURTHER, Factors, checked_factors, read_factors
from millprint.fingerprint.descriptors import (
    CHARGE,
    FEWEST_TURNS,
    MOTIONS,
    OF_RULE,
    as_built,
    said_of,
    with_impacts,
)
from millprint.fingerprint.layers import are_near_layers
from millprint.fingerprint.predicted_values import (
    COLUMNS,
    OF_COLLISIONS,
    Prediction,
    banded,
    bands,
    conditions_of,
    from_curves,
    with_parts,
)
from millprint.fingerprint.processes import (
    SAME,
    Predictor,
    Process,
    Told,
    band_width,
    kinds_of,
    log_rows,
    logarithms,
    varied_components,
)
from millprint.fingerprint.readers import FORMAT, WALL, read_content
from millprint.fingerprint.stored import StoredFingerprint
from millprint.observables.condition import VARIABLES, Condition
from millprint.observables.definitions import CURVES, LATER_CURVES, PREDICTED, SCALED_BY, SHARE, descriptors_of
from millprint.run.files import write_json

# Properties of the runs that a fingerprint stores, those that its contact law has.
SHARED = ("restitution", "static_friction", "collision_gap_turns", "density_kg_m3", "amplitude_m")
NO_CHARGES: Mapping[str, BallMixture] = {}
SETTING = ["ball_diameter_m", "speed_hz"]
# The conditions without impacts, in a fingerprint's file and as a reason, also in words; the powers that are known
# without impacts, and what their curves are of.
LAYERS, WHOLE = "no_impacts", ("P", "Pw")
NO_IMPACTS = "nothing hits there, or in a simulated condition next to it, so that nothing is known of hits"
OF_WHOLE = (*WHOLE, "rolling_ratio")


def describe(
    descriptors: pd.DataFrame, volume_m3: float, probability: float, charges: Mapping[str, BallMixture] = NO_CHARGES
) -> dict:
    """The data of a fingerprint: mill, balls, counting rule, settings of the mill as built, simulated ranges.

    charges: charges of several sizes by name. If there are any, each setting names its charge, and `charges` lists the
    sizes. `kinds` are the kinds of balls (ONE_SIZE and charges) if there are several.
    """
    built, kinds = as_built(descriptors), kinds_of(descriptors[CHARGE])
    first = built.iloc[0]
    columns = ["speed_hz", "ball_diameter_m", *([CHARGE] if charges else [])]
    settings = built[columns].drop_duplicates().sort_values([*SETTING, *columns[2:]])
    mixed = {
        name: {
            "ball_diameter_m": charge.mean_diameter_mm / 1e3,
            "sizes_m": [size / 1e3 for size in charge.sizes_mm],
            "fractions": charge.fractions,
        }
        for name, charge in charges.items()
    }
    return {
        **{name: first[name] for name in ("mill", "contact", *OF_RULE)},
        **{name: float(first[name]) for name in SHARED if pd.notna(first[name])},
        "volume_m3": float(volume_m3),
        "probability": float(probability),
        "settings": settings.to_dict("list"),
        **({"charges": mixed} if mixed else {}),
        **({"kinds": kinds} if kinds else {}),
        **{name: float(first[name]) for name, of_balls in WALL.items() if abs(first[name] - first[of_balls]) > 0},
        "ranges": {name: [float(descriptors[name].min()), float(descriptors[name].max())] for name in VARIABLES},
    }


LATER = "not measured when the fingerprint was made: run the command again that made it"


class Fingerprint:
    """Scaled powers, frequency and energies of one mill and contact set over everything that was varied.

    about: as from `describe`; processes: a Process for each of CURVES; further: the factors of each origin of intervals
    that was analysed in addition to the scatter of the simulation; layers: inputs (m, 5 or 6) of the conditions without
    impacts, which the curves leave out, and around which nothing is known; in them, the power is.
    """

    def __init__(
        self,
        about: dict,
        processes: dict[str, Process],
        further: Mapping[str, Factors] | None = None,
        layers: np.ndarray | None = None,
    ) -> None:
        self.about = about
        self.processes = processes
        self.further = dict(further or {})
        self.layers = self.inputs[:0] if layers is None else layers
        self.width = band_width(about["probability"], len(next(iter(processes.values())).logs))

    @classmethod
    def fit(
        cls,
        descriptors: pd.DataFrame,
        volume_m3: float,
        probability: float,
        charges: Mapping[str, BallMixture] = NO_CHARGES,
    ) -> "Fingerprint":
        """The fingerprint of the conditions of one mill and contact set, all counted by one rule, that have impacts.

        charges: every charge of several sizes among the conditions, by its name.
        A quantity that is not over 0 in every condition has no logarithm, so no curve, and where nothing hits in any
        condition only powers have one; `about` says so, by the quantity's name in `no_curve`. Raises ConfigError for
        fewer than three fill ratios of the mill as built, or without any power.
        """
        contact, fills = descriptors["contact"].iloc[0], as_built(descriptors)["fill_ratio"].nunique()
        if fills < FEWEST_FILLS:
            raise ConfigError(
                f"sweeps: contact set {contact} is simulated at {fills} fill ratios; a curve needs {FEWEST_FILLS}"
            )
        still = descriptors[said_of(descriptors, "no_impacts")]
        descriptors = with_impacts(descriptors)
        nothing_hits = said_of(descriptors, "no_impacts").any()
        # A charge without any impacts is unknown as a whole.
        still = still[still[CHARGE].isin(descriptors[CHARGE])]
        about = describe(descriptors, volume_m3, probability, charges)
        kinds = about.get("kinds", ())
        inputs, components = logarithms(descriptors, kinds), varied_components(descriptors)
        processes, without = {}, {}
        for quantity in CURVES:
            if nothing_hits and quantity not in WHOLE:
                without[quantity] = "of hits, and nothing hits in any condition"
                continue
            known = descriptors[quantity].to_numpy(dtype=float)
            has_none = ~(np.isfinite(known) & (known > 0))
            if has_none.any():
                fills = ", ".join(f"{fill:g}" for fill in np.unique(descriptors["fill_ratio"][has_none]))
                value = "0" if (known == 0).any() else "without a limit"
                without[quantity] = f"{value} at {has_none.sum()} of {known.size} conditions, at fill {fills}"
                continue
            stated = (descriptors[f"{quantity}_se"] / known).to_numpy(dtype=float)
            seeds = descriptors["seeds"].to_numpy()
            differ = said_of(descriptors, "seeds_differ").to_numpy()
            processes[quantity] = Process.fit(inputs, np.log(known), stated, components, seeds, differ)
        if "P" not in processes:
            raise ConfigError(f"descriptors: the power is {without['P']} with {contact}: nothing is dissipated there")
        few = int(said_of(descriptors, "few_turns").sum())
        told = {"no_curve": without, "few_turns": few}
        layers = np.empty((0, inputs.shape[1])) if nothing_hits else logarithms(still, kinds)
        for quantity in OF_WHOLE if len(layers) else ():
            known = still[quantity].to_numpy(dtype=float)
            if quantity in processes and (np.isfinite(known) & (known > 0)).all():
                stated, seeds = (still[f"{quantity}_se"] / known).to_numpy(dtype=float), still["seeds"].to_numpy()
                processes[quantity] = processes[quantity].with_apart(layers, np.log(known), stated, seeds)
        return cls({**about, **{name: own for name, own in told.items() if own}}, processes, layers=layers)

    def with_further(self, further: Mapping[str, Factors]) -> "Fingerprint":
        """The same fingerprint with the factors of further origins of intervals, checked by `checked_factors`."""
        return Fingerprint(self.about, self.processes, {**self.further, **further}, self.layers)

    def with_factors(self, files: Mapping[str, str]) -> "Fingerprint":
        """The same fingerprint with the factors in `files` (origin -> path), scaled onto its own values."""
        read = {origin: read_factors(path, origin, self.about) for origin, path in files.items()}
        return self.with_further({origin: own.onto(self._sampled(own)) for origin, own in read.items()})

    def _sampled(self, factors: Factors) -> dict[str, np.ndarray]:
        """Scaled quantities of the condition that factors were sampled at, one for each fill ratio."""
        if factors.sampled is None:
            return {}
        settings = factors.sampled.model_dump(include=set(VARIABLES))
        sampled = Condition(fill_ratio=np.array(factors.fill_ratios), **settings)
        inputs = self._inputs(sampled, factors.sampled.charge)
        return from_curves({name: np.exp(own.predict(inputs).logs) for name, own in self.predictors.items()})

    def write(self, path: str | Path) -> None:
        """Write the fingerprint as JSON: description, data, parameters of its processes, and further factors."""
        content = {
            "format": FORMAT,
            "about": self.about,
            "inputs": self._stored(self.inputs),
            **({LAYERS: self._stored(self.layers)} if len(self.layers) else {}),
            "processes": {name: process.to_dict() for name, process in self.processes.items()},
            **{origin: factors.model_dump(mode="json") for origin, factors in self.further.items()},
        }
        write_json(content, path)

    def _stored(self, inputs: np.ndarray) -> dict[str, list]:
        values = np.exp(inputs[:, : len(VARIABLES)])
        charges = {CHARGE: [self.kinds[int(place)] for place in inputs[:, -1]]} if self.kinds else {}
        return dict(zip(VARIABLES, values.T.tolist(), strict=True)) | charges

    @classmethod
    def read(cls, path: str | Path) -> "Fingerprint":
        """Read a file of `write`, with or without further factors; raises ConfigError, in one line, for others."""
        content = read_content(path)
        try:
            check_model(content, StoredFingerprint, str(path))
            about = content["about"]
            kinds = about.get("kinds", ())
            columns = [*VARIABLES, *([CHARGE] if kinds else [])]
            inputs, layers = (
                logarithms(pd.DataFrame(content.get(name, {}), columns=columns), kinds) for name in ("inputs", LAYERS)
            )
            stored, without = content["processes"], dict(about.get("no_curve", {}))
            # An observable that came after the fingerprint.
            later = {name: LATER for name in LATER_CURVES if name not in stored and name not in without}
            about = {**about, "no_curve": {**without, **later}} if later else about
            known = [name for name in CURVES if name not in {**without, **later}]
            processes = {name: Process.from_dict(stored[name], inputs, layers) for name in known}
            further = {
                origin: checked_factors(content[origin], origin, about, f"{path}: {origin}")
                for origin in FURTHER
                if origin in content
            }
            return cls(about, processes, further, layers)
        except ConfigError as error:
            first = str(error).splitlines()[0]
            raise ConfigError(first.replace(": ", ": not a whole fingerprint: ", 1)) from None

    @cached_property
    def predictors(self) -> dict[str, Predictor]:
        """The predictor of each quantity, made once."""
        return {name: process.predictor() for name, process in self.processes.items()}

    @property
    def inputs(self) -> np.ndarray:
        """The inputs (n, 5 or 6) of the processes, of the conditions that were simulated."""
        return next(iter(self.processes.values())).inputs

    @property
    def fill_range(self) -> tuple[float, float]:
        """The smallest and the largest fill ratio that was simulated."""
        return tuple(self.about["ranges"]["fill_ratio"])

    def few_turns_in_words(self) -> str:
        """What stands with numbers of this mill where conditions were recorded for few turns; empty for none."""
        few, word = self.about.get("few_turns", 0), MOTIONS["few_turns"].word
        many = f"{word}: {few} of its conditions were recorded for fewer than {FEWEST_TURNS} independent turns"
        return f"{self.about['mill']}: {many}" if few else ""

    @property
    def kinds(self) -> list[str]:
        """The kinds of balls, ONE_SIZE and charges of several sizes, if several were simulated."""
        return self.about.get("kinds", [])

    @property
    def charges(self) -> dict[str, BallMixture]:
        """The simulated charges of several ball sizes, by name."""
        return {
            name: BallMixture(name=name, sizes_mm=[1e3 * size for size in own["sizes_m"]], numbers=own["fractions"])
            for name, own in self.about.get("charges", {}).items()
        }

    @property
    def settings(self) -> list[tuple[float, float, str]]:
        """The simulated speeds [Hz], ball diameters [m] and charges (ONE_SIZE for balls of one size)."""
        stored = self.about["settings"]
        charges = stored.get(CHARGE, [ONE_SIZE] * len(stored["speed_hz"]))
        return list(zip(stored["speed_hz"], stored["ball_diameter_m"], charges, strict=True))

    def charge_diameter_m(self, charge: str) -> float:
        """Diameter of the ball of mean volume of a simulated charge [m]; raises ConfigError for another name."""
        known = self.about.get("charges", {})
        if charge not in known:
            has = f"has {', '.join(known)}" if known else "is of balls of one size"
            raise ConfigError(f"charge = {charge}: the fingerprint of {self.about['mill']} {has}")
        return known[charge]["ball_diameter_m"]

    def choices(self) -> list[float | str]:
        """The simulated balls, as `balls` takes them: diameters of one size [mm], rising, and names of charges."""
        sizes = sorted({1e3 * diameter for _, diameter, charge in self.settings if charge == ONE_SIZE})
        return [*sizes, *self.about.get("charges", {})]

    def balls(self, choice: float | str) -> tuple[float, str]:
        """Diameter [m] and charge of balls that are given by a diameter [mm] or by the name of a charge.

        A charge must be one that was simulated: nothing is known between two charges, or between a charge and balls
        of one size. Raises ConfigError for a charge that was not simulated, and for balls of one size where only
        charges were.
        """
        if isinstance(choice, str):
            return self.charge_diameter_m(choice), choice
        if not any(charge == ONE_SIZE for _, _, charge in self.settings):
            raise ConfigError(
                f"balls of {balls_in_words(choice)}: {self.about['mill']} was only simulated with charges of several "
                f"sizes, which do not apply to other balls; name one of {', '.join(self.charges)}"
            )
        return choice * 1e-3, ONE_SIZE

    def condition(self, **given: float) -> Condition[float]:
        """A condition of this mill, by the columns of `predict_table`: the condition of a table with one row.

        Raises ConfigError, in one line, for what is missing, said twice, unknown or impossible.
        """
        for name in given.keys() - set(COLUMNS):
            raise ConfigError(f"condition: {name} = {given[name]}: unknown key; known: {', '.join(COLUMNS)}")
        found = conditions_of(pd.DataFrame([given]), self.about, one=True)
        return Condition(**{name: float(values[0]) for name, values in vars(found).items()})

    def _of_balls(self, condition: Condition, volume_m3: float, charge: str = ONE_SIZE) -> Condition:
        """The condition with a simulated fill ratio of as many whole balls, if it is beyond the ends or near LAYERS."""
        one = fill_from("number", 1.0, 1e6 * volume_m3, 1e3 * condition.ball_diameter_m, condition.density_kg_m3)
        nearest = np.clip(condition.fill_ratio, *self.fill_range)
        if (near := self.near_layers(condition, charge)).any():
            fills = np.exp(self.layers[:, 0])
            closest = fills[np.abs(np.log(fills / np.atleast_1d(condition.fill_ratio)[:, None])).argmin(axis=1)]
            nearest = np.where(near, closest, nearest).reshape(np.shape(nearest))
        is_same = np.rint(nearest / one) == np.rint(condition.fill_ratio / one)
        fills = np.where(is_same, nearest, condition.fill_ratio)
        return replace(condition, fill_ratio=fills if fills.ndim else float(fills))

    def _inputs(self, condition: Condition, charge: str) -> np.ndarray:
        rows = condition.rows()
        return log_rows(rows, [charge] * len(rows), self.kinds)

    def descriptors(self, condition: Condition, charge: str = ONE_SIZE) -> dict[str, np.ndarray]:
        """Energies [J], frequencies over the balls [1/s] and share of shear (m,) of the conditions, without bands.

        NaN around conditions without impacts.
        """
        inputs = self._inputs(condition, charge)
        unknown = np.where(self._near_layers(inputs), np.nan, 1.0)
        read = (name for name in OF_COLLISIONS if name in self.predictors)
        scaled = from_curves({name: unknown * np.exp(self.predictors[name].mean(inputs)) for name in read})
        return {**descriptors_of(condition, scaled), SHARE.name: scaled["ratio"] / (1 + scaled["ratio"])}

    def scaled(self, condition: Condition, charge: str = ONE_SIZE) -> pd.DataFrame:
        """Every scaled quantity Q of the conditions with its two bands, as `banded`."""
        return self.told(self._inputs(condition, charge))

    def told(self, inputs: np.ndarray) -> pd.DataFrame:
        """`scaled` at inputs (m, 5 or 6) of the processes."""
        near, told = self._near_layers(inputs), {}
        for name, predictor in self.predictors.items():
            # In a condition without impacts, powers are known.
            unknown, own = near & ~predictor.nearest(inputs)[1], predictor.predict(inputs)
            told[name] = own._replace(logs=np.where(unknown, np.nan, own.logs))
        return banded(told, self.width)

    def near_layers(self, condition: Condition, charge: str = ONE_SIZE) -> np.ndarray:
        """Whether nothing is known of hits in each of the conditions (m,): one without impacts is next to it."""
        return self._near_layers(self._inputs(condition, charge))

    def _near_layers(self, inputs: np.ndarray) -> np.ndarray:
        return are_near_layers(inputs, self.inputs, self.layers)

    def nearest_with_impacts(self, condition: Condition[float], charge: str = ONE_SIZE) -> Condition[float]:
        """The simulated condition with impacts that is nearest, of the same kind of balls."""
        apart = np.abs(self.inputs - self._inputs(condition, charge))
        apart[:, len(VARIABLES) :] *= 1e6
        return Condition(*np.exp(self.inputs[apart.sum(axis=1).argmin(), : len(VARIABLES)]).tolist())

    def as_simulated(self, condition: Condition[float], charge: str = ONE_SIZE) -> Condition[float] | None:
        """The simulated condition, with impacts or without, of these settings and as many balls; None without one."""
        known, asked = np.vstack([self.inputs, self.layers]), self._inputs(condition, charge)[0]
        volume_m3, diameter_m = self.about["volume_m3"], condition.ball_diameter_m
        balls = ball_count(condition.fill_ratio, volume_m3, diameter_m)
        fills = np.exp(known[np.abs(known[:, 1:] - asked[1:]).max(axis=1) < SAME, 0])
        found = [fill for fill in fills.tolist() if ball_count(fill, volume_m3, diameter_m) == balls]
        return replace(condition, fill_ratio=found[0]) if found else None

    def check_known(self, descriptors: Iterable[str]) -> None:
        """Raise ConfigError, in one line, for a descriptor without a curve."""
        without = self.about.get("no_curve", {})
        for name in descriptors:
            if reason := without.get("ratio" if name == SHARE.name else SCALED_BY[name]):
                raise ConfigError(
                    f"{self.about['mill']}: {name} has no curve: it is {reason}; nothing can be matched to it"
                )

    def at_settings(self, fill_ratios: np.ndarray) -> np.ndarray:
        """Inputs (m, 5 or 6) of each fill ratio with each speed and balls of the mill as built, fill by fill."""
        built = {name: self.about[name] for name in ("density_kg_m3", "amplitude_m")}
        columns = [*reversed(SETTING), *([CHARGE] if self.kinds else [])]
        settings = pd.DataFrame({name: self.about["settings"][name] for name in columns}).assign(**built)
        fills = pd.DataFrame({"fill_ratio": np.asarray(fill_ratios, dtype=float)})
        return logarithms(fills.merge(settings, how="cross"), self.kinds)

    def curve(self, fill_ratios: np.ndarray) -> pd.DataFrame:
        """The master curves: fill_ratio, then every quantity with its two bands, as `banded`.

        The mean over the simulated speeds and ball sizes, and the bands of a condition drawn from these. The variance
        is the mean variance of the conditions plus the variance between them. Raises ConfigError outside the simulated
        fills.
        """
        fill_ratios = np.atleast_1d(np.asarray(fill_ratios, dtype=float))
        low, high = self.fill_range
        for fill in fill_ratios:
            if not low * (1 - 1e-9) <= fill <= high * (1 + 1e-9):
                raise ConfigError(
                    f"fill_ratio = {fill:g}: the curves of {self.about['contact']} hold from {low:g} to {high:g}"
                )
        inputs = self.at_settings(fill_ratios)
        curves = {name: predictor.curve(inputs) for name, predictor in self.predictors.items()}
        told, least = {}, np.where(self._near_layers(inputs), np.log(WIDEST), 0.0)
        for name, own in curves.items():
            widened = Told(own.logs, np.maximum(own.of_mean, least), np.maximum(own.of_new, least))
            each = Told(*(part.reshape(fill_ratios.size, -1) for part in widened))
            between = each.logs.var(axis=1)
            mean, new = (np.sqrt((part**2).mean(axis=1) + between) for part in (each.of_mean, each.of_new))
            told[name] = Told(each.logs.mean(axis=1), mean, new)
        table = banded(told, self.width)
        table.insert(0, "fill_ratio", fill_ratios)
        return table

    def at(self, fill_ratio: float) -> dict[str, Estimate]:
        """The master curves at one fill ratio; raises ConfigError outside the simulated fill ratios."""
        return self._with_intervals(bands(self.curve(np.array([fill_ratio]))), fill_ratio)

    def further_curve(self, curve: pd.DataFrame) -> pd.DataFrame:
        """A table of `curve` with the columns Q_by_ORIGIN_lower and _upper of every origin that was analysed.

        NaN at a fill ratio where the factors of an origin are not known.
        """
        rows = [
            self._with_intervals(bands(curve.iloc[[place]]), fill) for place, fill in enumerate(curve["fill_ratio"])
        ]
        columns = {
            column: [row[name].ends(origin)[place] for row in rows]
            for origin in self.further
            for name in CURVES
            for place, column in enumerate(columns_of(name, origin))
        }
        return curve.assign(**columns)

    def _with_intervals(self, scaled: dict[str, Estimate], fill_ratio: float) -> dict[str, Estimate]:
        """Scaled quantities with the intervals of the further origins that are known at a fill ratio.

        The parts of the power have intervals within what that of the power allows.
        """
        known = self.further.keys() - self.missing(fill_ratio).keys()
        factors = {origin: self.further[origin].at(np.array([fill_ratio])) for origin in known}
        found = {}
        for name, own in scaled.items():
            # A quantity with another counting rule is not known.
            intervals = {
                origin: Interval(*(own.value * ends[name][:, 0]).tolist())
                for origin, ends in factors.items()
                if np.isfinite(own.value * ends[name]).all()
            }
            found[name] = own.having(intervals)
        return with_parts(found)

    def missing(self, fill_ratio: float) -> dict[str, str]:
        """Why the interval of an origin is not known at a fill ratio, for each that is not."""
        found = {origin: "not analysed" for origin in FURTHER if origin not in self.further}
        for origin, factors in self.further.items():
            low, high = factors.fill_range
            if not low * (1 - 1e-9) <= fill_ratio <= high * (1 + 1e-9):
                found[origin] = f"fill_ratio = {fill_ratio:g}: analysed from {low:g} to {high:g}"
        return found

    def outside(self, condition: Condition[float], volume_m3: float, charge: str = ONE_SIZE) -> tuple[str, ...]:
        """Which variables, charge and jar volume included, are outside what was simulated; and LAYERS, near these."""
        beyond = self._beyond(condition, charge)
        found = [name for name, out in beyond.items() if out.any()]
        return (*found, *([] if np.isclose(volume_m3, self.about["volume_m3"]) else ["volume_m3"]))

    def _beyond(self, condition: Condition, charge: str) -> dict[str, np.ndarray]:
        """For each variable, and the charge, which conditions (m,) are outside what was simulated."""
        # Balls of one size give no information on a charge of several sizes, nor the other way round.
        diameters = [diameter for _, diameter, own in self.settings if own == charge]
        ranges = self.about["ranges"]
        if self.about.get("charges") and diameters:
            ranges = ranges | {"ball_diameter_m": [min(diameters), max(diameters)]}

        def is_beyond(name: str, low: float, high: float) -> np.ndarray:
            return ~((low * (1 - 1e-9) <= values[name]) & (values[name] <= high * (1 + 1e-9)))

        values = dict(zip(VARIABLES, condition.rows().T, strict=True))
        beyond, near = {name: is_beyond(name, *ranges[name]) for name in VARIABLES}, self.near_layers(condition, charge)
        # Fill ratios without impacts were simulated too.
        fills = [*self.fill_range, *np.exp(self.layers[:, 0])]
        beyond["fill_ratio"] &= ~near | is_beyond("fill_ratio", min(fills), max(fills))
        return beyond | {CHARGE: np.array([not diameters]), LAYERS: near}

    def predict_table(self, conditions: pd.DataFrame) -> pd.DataFrame:
        """The conditions of a table with their predictions: a column for each descriptor, and for the ends of its band.

        conditions: columns as a sweep has them, ball_diameter_mm, speed_rpm (or speed_hz), and fill_ratio, number,
        mass_g or bulk_filling; or ball_diameter_m; density_kg_m3 and amplitude_m if not as built. Further columns are
        kept. Raises ConfigError, in one line, for a missing column and an impossible condition.
        """
        condition = self._of_balls(conditions_of(conditions, self.about), self.about["volume_m3"])
        told, width = self.scaled(condition), ("", *(f"_{end}" for end in ENDS))
        balls = np.array([ball_count(row[0], self.about["volume_m3"], row[2]) for row in condition.rows()])
        ends = {}
        for end in width:
            scaled = {name: told[f"{name}{end}"].to_numpy() for name in CURVES}
            scaled[SHARE.curve] = scaled["ratio"] / (1 + scaled["ratio"])
            ends[end] = {name: scaled[own.curve] * own.scale_of(condition, balls) for name, own in PREDICTED.items()}
        columns = {f"{name}{end}": ends[end][name] for name in ends[""] for end in width}
        beyond = {name: np.broadcast_to(out, balls.shape) for name, out in self._beyond(condition, ONE_SIZE).items()}
        outside = [", ".join(name for name in beyond if beyond[name][row]) for row in range(len(balls))]
        table = pd.DataFrame({"balls": balls, **columns, "outside": outside}, index=conditions.index)
        return conditions.drop(columns=[name for name in table if name in conditions]).join(table)

    def __repr__(self) -> str:
        about = self.about
        return f"<Fingerprint of {about['mill']} with contact set {about['contact']}: {len(self.settings)} settings>"

    @overload
    def predict(self, condition: pd.DataFrame) -> pd.DataFrame: ...

    @overload
    def predict(
        self, condition: Condition[float], volume_m3: float | None = None, charge: str = ONE_SIZE
    ) -> Prediction: ...

    def predict(
        self, condition: Condition[float] | pd.DataFrame, volume_m3: float | None = None, charge: str = ONE_SIZE
    ) -> Prediction | pd.DataFrame:
        """Descriptors of a condition by Eqs 3.28, 3.29 and 4.5, with the variables outside the simulated range.

        Of a table of conditions, a table: `predict_table`.

        volume_m3: of the jar; if left out, of the mill as built. charge: name of a charge of several sizes; the
        condition then has its ball of mean volume (`charge_diameter_m`). If left out, balls of one size. Beyond the
        simulated range, the scaling of the thesis extends the curves, with a wider interval. Raises ConfigError for an
        impossible condition: a value of 0 or less, or a fill ratio of 1 or more.
        """
        if isinstance(condition, pd.DataFrame):
            return self.predict_table(condition)
        if not isinstance(condition, Condition):
            raise ConfigError(f"condition = {condition!r}: must be a Condition, as `condition` makes it, or a table")
        volume = self.about["volume_m3"] if volume_m3 is None else volume_m3
        for name, value in (*vars(condition).items(), ("volume_m3", volume)):
            if not 0 < value < (1 if name == "fill_ratio" else np.inf):
                raise ConfigError(f"{name} = {value:g}: must be over 0{' and under 1' * (name == 'fill_ratio')}")
        condition = self._of_balls(condition, volume, charge)
        scaled = self._with_intervals(bands(self.scaled(condition, charge)), condition.fill_ratio)
        scaled[SHARE.curve] = share_of(scaled["ratio"])
        balls = ball_count(condition.fill_ratio, volume, condition.ball_diameter_m)
        return Prediction(
            balls=balls,
            known={
                name: replace(scaled[own.curve] * own.scale_of(condition, balls), unit=own.unit)
                for name, own in PREDICTED.items()
            },
            outside=self.outside(condition, volume, charge),
            missing=self.missing(condition.fill_ratio),
        )
