"""The yield model of a run as plain values, from which the explorer computes."""

from pathlib import Path

import numpy as np

from millprint.config.averaged_process import INPUTS
from millprint.config.next_experiments import PredictionConfig
from millprint.thesis.yields.averaging import BISECTIONS, HIGHEST, LOWEST, NODE_WEIGHTS, NODES, Member
from millprint.thesis.yields.features import CHEMICAL
from millprint.thesis.yields.model_files import load_averaged, training_rows
from millprint.thesis.yields.new_conditions import trained_ranges
from millprint.thesis.yields.structured import JITTER, MEAN_VARIANCE


def explorer_yields(model: str | Path, prediction: PredictionConfig, level: float) -> dict:
    """What the explorer shows of yields: `yield`, the model, and `chemistry`, the range of each chemical condition.

    model: file of a stored averaged Gaussian process; prediction: how far beyond the trained range a yield is still
    answered; level: of the yield's interval [-].
    """
    return {"yield": yield_content(model, prediction, level), "chemistry": chemistry(model)}


def yield_content(path: str | Path, prediction: PredictionConfig, level: float) -> dict:
    """An averaged yield model with its transformed data: scaled inputs and standardised yields of every member."""
    model = load_averaged(str(path))
    ranges = trained_ranges(training_rows(str(path)), prediction)
    return {
        "inputs": list(INPUTS),
        "level": level,
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


def chemistry(yield_model: str | Path) -> dict[str, list[float]]:
    """Smallest, middle and largest value that the yield model was trained on, of each chemical condition."""
    rows = training_rows(str(yield_model))
    return {name: np.quantile(rows[name], [0, 0.5, 1]).tolist() for name in CHEMICAL}
