"""Weights of a graph network on disk; they load with weights_only=True."""

from pathlib import Path

import torch

from millprint.config.surrogate import Recipe
from millprint.surrogate.checkpoint import read_tensors, write_tensors
from millprint.surrogate.thesis.normalise import Surrogate


def write_weights(path: str | Path, model: Surrogate, recipe: Recipe) -> None:
    """Write the weights, with the recipe that gives them a shape."""
    state = {name: value.cpu() for name, value in model.state_dict().items()}
    write_tensors(path, {"recipe": recipe.model_dump(mode="json"), "state": state})


def read_weights(path: str | Path, device: torch.device) -> tuple[Surrogate, Recipe]:
    """The model with its weights, ready to predict, and its recipe. Raises ConfigError for a damaged file."""
    content = read_tensors(path, device)
    recipe = Recipe(**content["recipe"])
    model = Surrogate(recipe)
    model.load_state_dict(content["state"])
    return model.to(device).eval(), recipe
