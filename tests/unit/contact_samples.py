"""A small mill for the tests of the contact surrogate, and untrained networks."""

import numpy as np
import torch

from millprint.config.contact_surrogate import CoarseConfig, ContactTrainingConfig, PredictorConfig, TraceConfig
from millprint.config.sweep import DemConfig
from millprint.dem.compilation import TINY_CONTACT, TINY_MILL
from millprint.dem.layout import HISTORY_WIDTH
from millprint.surrogate.contact.coarse import CoarseSimulation, SavedState
from millprint.surrogate.contact.dataset import TracedModels, open_tracer
from millprint.surrogate.contact.network import Predictor
from millprint.surrogate.contact.tracer import Tracer

COARSE = CoarseConfig(rayleigh_multiple=0.96, substeps=4, warm_up_s=0.001)
TRACE = TraceConfig(
    mill="tiny", contact="tiny", ball_diameter_mm=4, fill_ratio=0.08, speed_rpm=600, seed=0, from_s=0.02, until_s=0.1,
    every=10,
)  # fmt: skip
NETWORK = PredictorConfig(width=8, rounds=2)
TRAINING = ContactTrainingConfig(
    epochs=3, steps_per_epoch=6, batch_size=4, learning_rate=1e-3, final_learning_rate=1e-4, push_forward_after=1,
    push_forward_steps=5, push_forward_states=6, patience=3, wall_time_max_s=100, checkpoint_every_s=100, seed=0,
)  # fmt: skip


def tiny_tracer() -> Tracer:
    """The DEM of a small jar with a post, just in motion."""
    dem = DemConfig(time_step_s=2e-6, settle_s=0.05, discard_s=0, window_s=0.05)
    models = TracedModels(mills={"tiny": TINY_MILL}, contacts={"tiny": TINY_CONTACT}, dem=dem)
    tracer = open_tracer(TRACE, models, COARSE, interval_s=1e-3)
    tracer.to_time(TRACE.from_s)
    return tracer


def random_network(seed: int = 0, size: float = 0.1) -> Predictor:
    """An untrained network with outputs of about `size`."""
    torch.manual_seed(seed)
    model = Predictor(NETWORK.width, NETWORK.rounds)
    for layers in model.rounds:
        torch.nn.init.normal_(layers[2].weight, std=size)
    return model


def in_mid_air(
    coarse: CoarseSimulation, position: np.ndarray, velocity: np.ndarray, angular_velocity: np.ndarray
) -> SavedState:
    """Balls without contacts, before the mill starts; `position` in the jar's frame."""
    position = position + coarse.bodies[0].motion.position(-1.0)
    none = np.zeros(0, dtype=np.int64)
    return SavedState(
        position, np.hstack([velocity, angular_velocity]), none, none, np.zeros((0, HISTORY_WIDTH)), -1_000_000
    )
