"""The loss (thesis Eqs 6.28 to 6.30)."""

import torch
from torch import Tensor

from millprint.config.surrogate import TrainingConfig


def huber(error: Tensor, delta: float) -> Tensor:
    """Huber penalty, Eq. 6.30: e^2 / (2 delta) below delta, |e| - delta / 2 from there on. Elementwise."""
    size = error.abs()
    return torch.where(size < delta, error * error / (2 * delta), size - delta / 2)


def losses(
    predicted: tuple[Tensor, Tensor], wanted: tuple[Tensor, Tensor], settings: TrainingConfig
) -> dict[str, Tensor]:
    """Loss of accelerations (Eq. 6.29a), of dissipation (Eq. 6.29b) and their weighted sum `total` (Eq. 6.28).

    Both pairs hold normalised accelerations (n, 3) and normalised dissipation (graphs,).
    """
    acceleration = huber(predicted[0] - wanted[0], settings.huber_delta).mean()
    dissipation = huber(predicted[1] - wanted[1], settings.huber_delta).mean()
    total = settings.acceleration_weight * acceleration + settings.dissipation_weight * dissipation
    return {"total": total, "acceleration": acceleration, "dissipation": dissipation}
