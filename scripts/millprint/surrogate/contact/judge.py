"""How good a network is in the roll-out, and the states that it reaches there."""

import numpy as np

from millprint.config.contact_surrogate import ContactTrainingConfig, JudgeConfig
from millprint.dem import state
from millprint.dem.advance import all_works
from millprint.surrogate.contact.coarse import CoarseSimulation
from millprint.surrogate.contact.dataset import CHANNELS, Samples, Truth
from millprint.surrogate.contact.scratch import Weights
from millprint.surrogate.contact.tracer import Tracer

# What a roll-out scores that has lost a ball [%].
LOST = 1e6


def dissipated_works(coarse: CoarseSimulation) -> np.ndarray:
    """Normal and tangential work of a coarse simulation since its state was loaded (2,) [J]."""
    out = np.zeros(state.TOTALS)
    all_works(coarse.contacts, coarse.counters, coarse.totals, out)
    return out[CHANNELS]


def judged(coarse: CoarseSimulation, weights: Weights, truths: list[Truth], settings: JudgeConfig) -> dict[str, float]:
    """Roll-outs against the DEM: errors of the normal and tangential works and of the positions after a while [%].

    The works are summed over all roll-outs and their absolute errors over the channels, relative to both channels
    together; the position's root mean square error is relative to the ball's radius. roll_out_score is their sum.
    """
    coarse.weights = weights
    works, wanted, squares = np.zeros(2), np.zeros(2), []
    looks = round(settings.position_s / coarse.step)
    for truth in truths:
        coarse.load(truth.begin)
        if not coarse.run(looks):
            return {"roll_out_score": LOST, "roll_out_dissipation_percent": LOST, "roll_out_position_percent": LOST}
        squares.append(((coarse.balls.position - truth.position_m) ** 2).sum(axis=1).mean())
        if not coarse.run(round(settings.length_s / coarse.step) - looks):
            return {"roll_out_score": LOST, "roll_out_dissipation_percent": LOST, "roll_out_position_percent": LOST}
        works += dissipated_works(coarse)
        wanted += truth.works_J
    dissipation = 100 * np.abs(works - wanted).sum() / wanted.sum()
    position = 100 * np.sqrt(np.mean(squares)) / coarse.radius
    return {
        "roll_out_score": float(dissipation + position),
        "roll_out_dissipation_percent": float(dissipation),
        "roll_out_position_percent": float(position),
    }


def reached(tracers: list[Tracer], weights: Weights, settings: ContactTrainingConfig) -> Samples:
    """Samples of states that the network reaches in every traced case, a share of each."""
    share = max(1, settings.push_forward_states // len(tracers))
    parts = [
        tracer.push_forward(weights, settings.push_forward_steps, settings.push_forward_steps, share)
        for tracer in tracers
    ]
    return Samples(np.concatenate([part[0] for part in parts]), np.concatenate([part[1] for part in parts]))
