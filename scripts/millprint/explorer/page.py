"""The explorer: an HTML file with the fingerprints and the yield model of a run, and the ranges of its sliders."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.stats import norm

from millprint.config.averaging import INPUTS
from millprint.config.fingerprint import TARGET_DESCRIPTORS, MatchConfig
from millprint.config.mixture import ONE_SIZE
from millprint.config.proposals import PredictionConfig
from millprint.fingerprint.bands import FURTHER, SCATTER, checked_factors
from millprint.fingerprint.condition import VARIABLES
from millprint.fingerprint.descriptors import CHARGE
from millprint.fingerprint.inputs import read_content
from millprint.fingerprint.search import GRID
from millprint.pages import embed_files, embed_json, render_page
from millprint.predict.averaging import BISECTIONS, HIGHEST, LOWEST, NODE_WEIGHTS, NODES, Member
from millprint.predict.features import CHEMICAL
from millprint.predict.model_files import load_averaged, training_rows
from millprint.predict.new_conditions import trained_ranges
from millprint.predict.structured import JITTER, MEAN_VARIANCE

# A slider extends beyond the simulated range, and by this factor both ways if only one value was simulated.
BEYOND = 1.25
LONE = 2.0
# The keys of the request that the search of the page uses.
SEARCHED = {"speeds_rpm", "fill_ratios", "ball_diameters_mm", "densities_kg_m3", "weights", "ranked"}
FOLDER = Path(__file__).parent
SCRIPTS = ("numerics.js", "fingerprint.js", "yields.js", "search.js", "charts.js", "page.js")


class Yields(NamedTuple):
    """The yields that a page answers for.

    model: file of a stored averaged Gaussian process; prediction: how far beyond the trained range a yield is still
    answered; level: of the yield's interval [-].
    """

    model: str | Path
    prediction: PredictionConfig
    level: float


def explorer_page(content: dict) -> str:
    """The page with `content` from `explorer_content`, from which it computes in the browser."""
    abouts = [stored["about"] for stored in content["fingerprints"]]
    first, trained = abouts[0], content["yield"]
    return render_page(
        FOLDER / "page.html",
        name=content["name"],
        title=content["title"],
        probability=f"{100 * first['probability']:g}",
        level=f"{100 * trained['level']:g}" if trained else "",
        search=content["search"],
        about=first,
        contacts=[about["contact"] for about in abouts],
        conditions=sum(len(stored["inputs"]["fill_ratio"]) for stored in content["fingerprints"]),
        runs=len(trained["members"][0]["target"]) if trained else 0,
        charges=any(about.get("charges") for about in abouts),
        balls=balls_searched(content["search"]["ball_diameters_mm"]),
        origins=content["origins"],
        style=embed_files(FOLDER, "page.css"),
        scripts=embed_files(FOLDER, *SCRIPTS),
        content=embed_json(content),
    )


def explorer_content(
    name: str,
    title: str,
    fingerprints: list[str | Path],
    request: MatchConfig,
    yields: Yields | None = None,
) -> dict:
    """Everything that the page computes from, as plain values.

    fingerprints: fingerprint_CONTACT.json files of one mill, with further intervals or without; request: what the user
    of the mill can set; yields: None for a mill without measured yields. Raises ConfigError for a file that is not what
    it should be.
    """
    contents = [read_content(path) for path in fingerprints]
    # Only the data of the processes and the factors are needed, without format and file name.
    kept = [
        {key: content[key] for key in ("about", "inputs", "processes")} | _further(content, str(path))
        for content, path in zip(contents, fingerprints, strict=True)
    ]
    origins = {"scatter": SCATTER} | {
        name: about for name, about in FURTHER.items() if any(name in own for own in kept)
    }
    return {
        "name": name,
        "title": title,
        "variables": list(VARIABLES),
        "descriptors": list(TARGET_DESCRIPTORS),
        "widths": [float(norm.ppf(0.5 + 0.5 * content["about"]["probability"])) for content in contents],
        "fingerprints": kept,
        "origins": {name: about._asdict() for name, about in origins.items()},
        "yield": yield_content(yields) if yields else None,
        "sliders": sliders([content["about"] for content in contents], request),
        "chemistry": chemistry(yields.model) if yields else {},
        "search": {
            "grid": list(GRID),
            **request.model_dump(include=SEARCHED),
            "targets": {target.name: target.given for target in request.targets if target.like is None},
        },
    }


def _further(content: dict, source: str) -> dict:
    """The factors of every further origin of intervals that a fingerprint has, as far as the page needs them."""
    found = {}
    for origin in FURTHER:
        if origin in content:
            factors = checked_factors(content[origin], origin, content["about"], f"{source}: {origin}")
            found[origin] = factors.model_dump(mode="json", include={"fill_ratios", "factors", "probability"})
    return found


def yield_content(yields: Yields) -> dict:
    """An averaged yield model with its transformed data: scaled inputs and standardised yields of every member."""
    model = load_averaged(str(yields.model))
    ranges = trained_ranges(training_rows(str(yields.model)), yields.prediction)
    return {
        "inputs": list(INPUTS),
        "level": yields.level,
        "ranges": {name: [float(end) for end in ends] for name, ends in ranges.items()},
        "nodes": NODES.tolist(),
        "node_weights": NODE_WEIGHTS.tolist(),
        "bisections": BISECTIONS,
        "search": [LOWEST, HIGHEST],
        "mean_variance": MEAN_VARIANCE,
        "jitter": JITTER,
        "members": [
            _member(member, float(weight)) for member, weight in zip(model.members, model.weights, strict=True)
        ],
    }


def _member(member: Member, weight: float) -> dict:
    own = member.process.terms
    terms = zip(own.factors.astype(int).tolist(), own.linear.tolist(), strict=True)
    return {
        "weight": weight,
        "link": member.candidate.link,
        "scales": list(member.candidate.scales),
        "terms": [{"factors": factors, "linear": linear} for factors, linear in terms],
        "log_parameters": member.process.logs.tolist(),
        "input_mean": member.standard.mean.tolist(),
        "input_spread": member.standard.deviation.tolist(),
        "target_mean": float(member.mean),
        "target_spread": float(member.spread),
        "known": member.process.inputs.tolist(),
        "target": member.process.target.tolist(),
    }


def sliders(abouts: list[dict], request: MatchConfig) -> dict[str, list[float]]:
    """The range of every slider in SI units: the possible and the simulated values, and a margin.

    Where charges of several sizes alone were simulated there is none for the ball diameter.
    """
    asked = {
        "speed_hz": [speed / 60 for speed in request.speeds_rpm],
        "fill_ratio": request.fill_ratios,
        "ball_diameter_m": [size * 1e-3 for size in request.ball_diameters_mm if not isinstance(size, str)],
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
    # Random packings of balls fill at most about 0.6 of a vessel.
    found["fill_ratio"][1] = min(found["fill_ratio"][1], 0.6)
    return found


def _simulated(about: dict, name: str) -> list[float]:
    """The ends of a variable's simulated range; of the ball diameter, the diameters of balls of one size."""
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


def chemistry(yield_model: str | Path) -> dict[str, list[float]]:
    """Smallest, middle and largest value that the yield model was trained on, of each chemical condition."""
    rows = training_rows(str(yield_model))
    return {name: np.quantile(rows[name], [0, 0.5, 1]).tolist() for name in CHEMICAL}
