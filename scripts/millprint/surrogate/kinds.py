"""The kinds of surrogates: how each is trained, opened and rolled out. What is not among KINDS is refused.

The modules of a kind are imported where they are used: torch_geometric takes seconds to import, and the contact
surrogate does without it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
import torch

from millprint.config.surrogate import Recipe
from millprint.errors import ConfigError
from millprint.surrogate.checkpoint import read_tensors
from millprint.surrogate.protocol import Setting, Surrogate

Train = Callable[[str, Path, dict, torch.device], tuple[dict, pd.DataFrame]]


@dataclass(frozen=True)
class SurrogateKind:
    """A kind of surrogate: its title, how it is trained, and how it is opened.

    train: from a data set, a path for checkpoints, settings as plain values and a device to the content of the weights
    file and a row of losses an epoch. A training that was killed goes on from its checkpoint.
    """

    title: str
    train: Train
    open: Callable[[Setting], Surrogate]


def _train_graph(dataset: str, checkpoint: Path, settings: dict, device: torch.device) -> tuple[dict, pd.DataFrame]:
    from millprint.surrogate.thesis.training import train

    return train(dataset, checkpoint, Recipe(**settings), device)


def _open_graph(setting: Setting) -> Surrogate:
    from millprint.surrogate.thesis.compiled import open_graph_surrogate

    return open_graph_surrogate(setting)


def _train_contact(dataset: str, checkpoint: Path, settings: dict, device: torch.device) -> tuple[dict, pd.DataFrame]:
    from millprint.surrogate.contact.ensemble import ContactTrainingJob, train

    return train(dataset, checkpoint, ContactTrainingJob(**settings), device)


def _open_contact(setting: Setting) -> Surrogate:
    from millprint.surrogate.contact.surrogate import ContactSurrogate

    return ContactSurrogate(setting.weights, setting.run, setting.member)


# By the name in `surrogate.variants.NAME.kind`.
GRAPH, CONTACT = "graph", "contact"
KINDS = {
    GRAPH: SurrogateKind("graph network of balls and wall", _train_graph, _open_graph),
    CONTACT: SurrogateKind("ensemble that predicts contact forces", _train_contact, _open_contact),
}


def kind_of(name: str) -> SurrogateKind:
    """The kind of this name. Raises ConfigError for one that is not among KINDS."""
    if name not in KINDS:
        raise ConfigError(f"unknown kind of surrogate: {name}; known: {', '.join(KINDS)}")
    return KINDS[name]


def open_surrogate(setting: Setting) -> Surrogate:
    """The surrogate of a weights file, of any kind. Raises ConfigError for a file that is damaged or unknown."""
    # The weights of graph networks name no kind.
    return kind_of(read_tensors(setting.weights).get("kind", GRAPH)).open(setting)
