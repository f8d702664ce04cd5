"""The data of the explorer: fingerprints of mills, their yields, spectra and temperatures, as plain values.

The explorer: one HTML file with the fingerprints of mills, which computes in the browser and fetches nothing.
"""

import hashlib
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple, TypedDict

import numpy as np
import pandas as pd

from millprint.config.charge import ONE_SIZE, balls_in_words
from millprint.config.dose import HeatConfig
from millprint.config.errors import ConfigError
from millprint.config.fingerprint import DescriptorSet, MatchConfig
from millprint.config.mill import MillConfig
from millprint.dose.heat_balance import BAND, BODIES
from millprint.dose.spectra import BIN_EDGES
from millprint.fingerprint import processes
from millprint.fingerprint.bands import FURTHER, ORIGINS, checked_factors
from millprint.fingerprint.condition_search import GRID, SOLD_MM, simulated_request
from millprint.fingerprint.descriptors import CHARGE, CONDITION, CONDITION_TEXT, FEWEST_TURNS, NOTHING
from millprint.fingerprint.model import LAYERS, Fingerprint
from millprint.fingerprint.predicted_values import KNOWN, OF_COLLISIONS
from millprint.fingerprint.readers import read_content
from millprint.mill.gravity import GRAVITY
from millprint.mill.speed_limits import mill_in_words, wall_acceleration
from millprint.observables.condition import SCALES, VARIABLES
from millprint.observables.counted_collisions import BOTH, CHANNELS, PAIRS
from millprint.observables.definitions import DESCRIPTOR_SETS, OWN_CURVES, PREDICTED, TARGET_DESCRIPTORS
from millprint.run.files import read_table
from millprint.run.html_pages import embed_files, embed_json, render_page

# What the page needs of the record of an observable.
ON_PAGE = ("name", "title", "symbol", "unit", "curve", "scale", "adds_up", "matched", "panel", "line")
# Digits of a spectrum on the page, and decimals of a temperature [degC].
DIGITS, DECIMALS = 8, 2
SHOWN = ("collisions_hz", "power_W", "mean_J", "median_J", "half_power_J")
OF_LIMIT = ("total_W", "limit_degC", "over_limit_share", "milling_min")
BANDS_OF_LIMIT = ("time_to_limit_h", "pause_needed_min")


class Spectra(NamedTuple):
    """Tables of energy spectra: pairs of spectra...tsv and spectra_summary...tsv, and the rule to show."""

    tables: Sequence[tuple[str | Path, str | Path]]
    rule: str


class Heat(NamedTuple):
    """Tables of temperatures: temperatures.tsv and limits.tsv, and the settings that they were made with."""

    temperatures: str | Path
    limits: str | Path
    settings: HeatConfig


def _number(value: float, digits: int = DIGITS) -> float | None:
    """A number with a few digits; None if it is not finite."""
    return float(f"{value:.{digits}g}") if np.isfinite(value) else None


def _condition(row: dict) -> dict:
    """The condition of a row of a table, in SI, and its name in addresses and in words.

    The words are without the speed, because its unit is chosen on the page.
    """
    varied = "" if row["varied"] == NOTHING else row["varied"]
    named = [row["contact"], row[CHARGE] or f"d{row['ball_diameter_mm']:g}", f"f{row['fill_ratio']:g}"]
    named += [f"n{row['speed_rpm']:g}"]
    balls = balls_in_words(round(row["ball_diameter_mm"], 3), row[CHARGE])
    words = f"{row['contact']}, {balls}, fill {row['fill_ratio']:g}"
    if "density" in varied:
        named.append(f"rho{row['density_kg_m3']:g}")
        words += f", {row['density_kg_m3']:g} kg/m³"
    if "amplitude" in varied:
        named.append(f"a{1e3 * row['amplitude_m']:g}")
        words += f", amplitude {1e3 * row['amplitude_m']:g} mm"
    settings = {
        "fill_ratio": row["fill_ratio"],
        "speed_hz": row["speed_rpm"] / 60,
        "ball_diameter_m": row["ball_diameter_mm"] * 1e-3,
        "density_kg_m3": row["density_kg_m3"],
        "amplitude_m": row["amplitude_m"],
    }
    known = {name: float(settings[name]) for name in VARIABLES}
    return {"id": "-".join(named), "words": words, "contact": row["contact"], "charge": row[CHARGE], **known}


def spectra_content(spectra: Spectra) -> dict:
    """Bins and spectra of every condition whose contacts were recorded; the spectra of `rule`, from their first bin.

    The place of a bin is 0 below the lowest edge, and one more for each edge. Raises ConfigError for a table with other
    bins than BIN_EDGES.
    """
    found: list[dict] = []
    for path, summary_path in spectra.tables:
        text = [*CONDITION_TEXT, "counting_rule", "channel", "pair"]
        table, summary = (
            read.fillna({CHARGE: ONE_SIZE})[read["counting_rule"] == spectra.rule]
            for read in (read_table(path, text=text), read_table(summary_path, text=text))
        )
        grouped = dict(list(table.groupby([*CONDITION, "channel", "pair"], sort=False)))
        for key, rows in summary[summary["channel"].isin(CHANNELS)].groupby(CONDITION, sort=False):
            own = _condition(dict(zip(CONDITION, key, strict=True)))
            own["bins"] = {
                channel: {pair: _bins(grouped.get((*key, channel, pair)), path) for pair in PAIRS}
                for channel in CHANNELS
            }
            own["read_off"] = {channel: {} for channel in CHANNELS}
            for row in rows.to_dict("records"):
                own["read_off"][row["channel"]][row["pair"]] = {name: _number(row[name]) for name in SHOWN}
            found.append(own)
    return {"edges": BIN_EDGES.tolist(), "rule": spectra.rule, "pairs": [*PAIRS, BOTH], "conditions": found}


def _bins(rows: pd.DataFrame | None, path: str | Path) -> dict:
    """The bins of one spectrum: place of the first, collisions per second and power [W] of each."""
    if rows is None or not len(rows):
        return {"first": 0, "collisions_hz": [], "power_W": []}
    low = rows["energy_low_J"].to_numpy(float)
    places = np.where(np.isnan(low), 0, np.searchsorted(BIN_EDGES, low * (1 + 1e-6)))
    expected = np.concatenate([[np.nan], BIN_EDGES])[places]
    if not np.allclose(low, expected, rtol=1e-6, equal_nan=True) or (np.diff(places) != 1).any():
        raise ConfigError(f"{path}: its bins are not those of this version; delete the file and run again")
    numbers = {name: [_number(value) for value in rows[name]] for name in ("collisions_hz", "power_W")}
    return {"first": int(places[0]), **numbers}


def heat_content(heat: Heat) -> dict:
    """Temperatures of every condition over the programme, each with its band, and the pauses that its limit needs."""
    temperatures = read_table(heat.temperatures, text=["condition", "body"])
    limits = read_table(heat.limits, text=["condition", *CONDITION_TEXT, "limit_body"]).fillna({CHARGE: ONE_SIZE})
    grouped = dict(list(temperatures.groupby(["condition", "body"], sort=False)))
    times = next(iter(grouped.values()))["time_h"].tolist()
    found = []
    for row in limits.to_dict("records"):
        courses = {
            body: {end: grouped[row["condition"], body][f"{end}_degC"].round(DECIMALS).tolist() for end in BAND}
            for body in BODIES
        }
        found.append(
            {
                **_condition(row),
                "id": row["condition"],
                "courses": courses,
                **{name: _number(row[name]) for name in OF_LIMIT},
                # An infinite time has no number in JSON.
                **{name: [_number(row[f"{name}_{end}"]) for end in BAND] for name in BANDS_OF_LIMIT},
            }
        )
    settings = heat.settings
    return {
        "times_h": [_number(time) for time in times],
        "probability": settings.probability,
        "programme": settings.programme.model_dump(mode="json"),
        "limit_body": settings.limit.body,
        "conditions": found,
    }


# A slider extends beyond the simulated range, and by this factor both ways if only one value was simulated.
BEYOND = 1.25
LONE = 2.0
# The keys of the request that the search of the page uses.
SEARCHED = {"speeds_rpm", "fill_ratios", "ball_diameters_mm", "densities_kg_m3", "ranked", "near_percent"}
# Digits of a file's SHA-256 that name it in the methods text.
DIGEST = 12


class Machine(NamedTuple):
    """Facts about a mill on the page, in addition to its fingerprints.

    name: in addresses and files; words: the motion of its walls; acceleration: the largest of a wall at one turn per
    second, in units of gravity [s2], None if not known; speed_unit: rpm or hz.
    """

    name: str
    title: str
    words: str = ""
    acceleration: float | None = None
    speed_unit: str = "rpm"

    @classmethod
    def of_mill(cls, mill: MillConfig) -> "Machine":
        """The machine that a mill's file describes."""
        acceleration = wall_acceleration(mill) / GRAVITY
        return cls(mill.name, mill.title, mill_in_words(mill), acceleration, mill.speed_unit)


def explorer_content(name: str, mills: Sequence[dict], descriptors: DescriptorSet = "weighted") -> dict:
    """All data of the page; mills: `mill_content` of each, the first is shown first.

    name: of the run; descriptors: the set that a search begins with.
    """
    return {
        "name": name,
        "version": version("millprint"),
        "variables": list(VARIABLES),
        "observables": [{key: getattr(own, key) for key in ON_PAGE} for own in PREDICTED.values()],
        "scales": {name: scale.exponents for name, scale in SCALES.items()},
        "curves": {"known": KNOWN, "of_collisions": OF_COLLISIONS, "own_curves": OWN_CURVES},
        "descriptors": list(DESCRIPTOR_SETS[descriptors]),
        "fewest_turns": FEWEST_TURNS,
        "sold_mm": SOLD_MM,
        "mills": list(mills),
    }


def mill_content(
    machine: Machine,
    fingerprints: Sequence[str | Path],
    request: MatchConfig,
    yields: Mapping | None = None,
    spectra: Spectra | None = None,
    heat: Heat | None = None,
) -> dict:
    """The data of the page for one mill.

    fingerprints: fingerprint_CONTACT.json files of the mill, with further intervals or without; request: what the user
    of the mill can set; yields: `yield` and `chemistry` of the yield model, None without measured yields; spectra,
    heat: None if they were not calculated. Raises ConfigError for an invalid file.
    """
    contents = [read_content(path) for path in fingerprints]
    # Only the data of the processes and the factors are needed, without format and file name.
    kept = [
        {key: content[key] for key in ("about", "inputs", LAYERS) if key in content}
        | {"processes": _processes(content, path)}
        | {"digest": hashlib.sha256(Path(path).read_bytes()).hexdigest()[:DIGEST]}
        | _further(content, str(path))
        for content, path in zip(contents, fingerprints, strict=True)
    ]
    origins = {
        name: about for name, about in ORIGINS.items() if name not in FURTHER or any(name in own for own in kept)
    }
    return {
        **machine._asdict(),
        "widths": [
            processes.band_width(content["about"]["probability"], len(content["inputs"]["fill_ratio"]))
            for content in contents
        ],
        "fingerprints": kept,
        "origins": {name: about._asdict() for name, about in origins.items()},
        "yield": yields["yield"] if yields else None,
        "sliders": sliders([content["about"] for content in contents], request),
        "chemistry": yields["chemistry"] if yields else {},
        "spectra": spectra_content(spectra) if spectra else None,
        "heat": heat_content(heat) if heat else None,
        "search": {
            "grid": list(GRID),
            **request.model_dump(include=SEARCHED),
            "weights": {name: request.all_weights[name] for name in TARGET_DESCRIPTORS},
            "balls_in_words": balls_searched(request.ball_diameters_mm or []),
            # Without the last digits, which differ between processors.
            "targets": {
                target.name: {name: float(f"{value:.10g}") for name, value in target.given.items()}
                for target in request.targets
                if target.like is None
            },
        },
    }


def _processes(content: dict, path: str | Path) -> dict[str, dict]:
    """The processes for the page: unchanged or, with many conditions, with curves reduced to a few of them."""
    if len(content["inputs"]["fill_ratio"]) <= processes.WHOLE_MAX:
        return content["processes"]
    predictors = Fingerprint.read(path).predictors
    return {name: own | {"reduced": predictors[name].reduced()} for name, own in content["processes"].items()}


def _further(content: dict, source: str) -> dict:
    """The factors of every further origin of intervals in a fingerprint, as far as the page needs them."""
    found = {}
    for origin in FURTHER:
        if origin in content:
            factors = checked_factors(content[origin], origin, content["about"], f"{source}: {origin}")
            found[origin] = factors.model_dump(mode="json", include={"fill_ratios", "factors", "probability"})
    return found


def sliders(abouts: list[dict], request: MatchConfig) -> dict[str, list[float]]:
    """The range of every slider in SI units: the possible and the simulated values, and a margin.

    There is no slider for the ball diameter if only charges of several sizes were simulated.
    """
    asked = {
        "speed_hz": [speed / 60 for speed in request.speeds_rpm or []],
        "fill_ratio": request.fill_ratios or [],
        "ball_diameter_m": [size * 1e-3 for size in request.ball_diameters_mm or [] if not isinstance(size, str)],
        "density_kg_m3": request.densities_kg_m3,
    }
    found = {}
    for name, values in asked.items():
        simulated = [value for about in abouts for value in _simulated(about, name)]
        if not simulated:
            continue
        every = [*values, *simulated]
        factor = BEYOND if max(every) > min(every) * BEYOND else LONE
        found[name] = [min(every) / factor, max(every) * factor]
    # Random packings of balls fill at most about 0.6 of a vessel's volume.
    found["fill_ratio"][1] = min(found["fill_ratio"][1], 0.6)
    return found


def _simulated(about: dict, name: str) -> list[float]:
    """The ends of a variable's simulated range; for the ball diameter, only balls of one size count."""
    if name != "ball_diameter_m" or not about.get("charges"):
        return about["ranges"][name]
    settings = about["settings"]
    pairs = zip(settings["ball_diameter_m"], settings[CHARGE], strict=True)
    return [diameter for diameter, charge in pairs if charge == ONE_SIZE]


def balls_searched(choices: list[float | str]) -> str:
    """The balls of a search in words: "balls of 5, 10 mm, the charge graded"."""
    sizes = ", ".join(f"{size:g}" for size in choices if not isinstance(size, str))
    charges = [choice for choice in choices if isinstance(choice, str)]
    words = [f"balls of {sizes}\u00a0mm"] if sizes else []
    words += [f"the charge{'s' * (len(charges) > 1)} {', '.join(charges)}"] if charges else []
    return ", ".join(words)


FOLDER = Path(__file__).parent
# In the order of their dependencies.
SCRIPTS = (
    *("numerics.js", "fingerprint.js", "yields.js", "match.js", "search.js", "units.js", "mill.js", "conditions.js"),
    *("elements.js", "charts.js", "logcharts.js", "controls.js", "results.js", "finder.js", "spectra.js", "heat.js"),
    *("intro.js", "advice.js", "methods.js", "state.js", "page.js"),
)


def explorer_page(content: dict) -> str:
    """The page with `content` from `millprint.explorer.content.explorer_content`, from which it computes."""
    return render_page(
        FOLDER / "page.html",
        name=content["name"],
        title=content["mills"][0]["title"],
        near=f"{content['mills'][0]['search']['near_percent']:g}",
        style=embed_files(FOLDER, "page.css"),
        scripts=embed_files(FOLDER, *SCRIPTS),
        content=embed_json(content),
    )


# The files of a mill, as the inputs of the rules name them.
EXPLORED = ("fingerprint", "spectra", "summary", "temperatures", "limits")


class Settings(TypedDict):
    """Settings that the tables of a run were made with: the rule to show, heat balance and descriptors."""

    rule: str
    heat: HeatConfig
    descriptors: DescriptorSet


def simulated_content(mill: dict, files: dict[str, str], settings: Settings) -> dict:
    """The data of the page for a mill; the search covers everything that was simulated.

    mill: its section as plain values; files: the files of EXPLORED by name.
    """
    request = simulated_request(Fingerprint.read(files["fingerprint"]), settings["descriptors"])
    return mill_content(
        Machine.of_mill(MillConfig(**mill)),
        [files["fingerprint"]],
        request,
        spectra=Spectra([(files["spectra"], files["summary"])], settings["rule"]),
        heat=Heat(files["temperatures"], files["limits"], settings["heat"]),
    )
