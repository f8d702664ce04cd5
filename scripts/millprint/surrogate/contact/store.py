"""Weights of an ensemble on disk; they load with weights_only=True."""

from pathlib import Path

from millprint.config.contact_surrogate import ContactRecipe
from millprint.surrogate.checkpoint import read_tensors, write_tensors
from millprint.surrogate.contact.network import Predictor
from millprint.surrogate.contact.scratch import Weights, make_weights

KIND = "contact"


def write_ensemble(path: str | Path, states: list[dict], recipe: ContactRecipe) -> None:
    """Write the weights of every member, with the recipe that gives them a shape."""
    members = [{name: value.cpu() for name, value in state.items()} for state in states]
    write_tensors(path, {"kind": KIND, "recipe": recipe.model_dump(mode="json"), "members": members})


def is_ensemble(path: str | Path) -> bool:
    """Whether a weights file holds a contact surrogate."""
    return read_tensors(path).get("kind") == KIND


def read_ensemble(path: str | Path) -> tuple[list[Weights], ContactRecipe]:
    """The members' weights as the kernels take them, and the recipe."""
    content = read_tensors(path)
    recipe = ContactRecipe(**content["recipe"])
    members = []
    for state in content["members"]:
        model = Predictor(recipe.network.width, recipe.network.rounds)
        model.load_state_dict(state)
        members.append(make_weights(model.arrays()))
    return members, recipe
