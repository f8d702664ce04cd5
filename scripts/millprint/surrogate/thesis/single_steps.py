"""Single steps of a graph network from states of the simulation: what is lost before any error can grow."""

import numpy as np
import torch

from millprint.config.surrogate import EdgeConfig, Recipe
from millprint.surrogate import measures
from millprint.surrogate.scene import Scene
from millprint.surrogate.thesis.features import featurise
from millprint.surrogate.thesis.graphs import graphs_at
from millprint.surrogate.thesis.normalise import Surrogate, target
from millprint.surrogate.trajectory import Trajectory


def one_step(
    model: Surrogate, recipe: Recipe, rule: EdgeConfig, run: Trajectory, scene: Scene, graphs: int, device: torch.device
) -> dict[str, float]:
    """Single steps from up to `graphs` states, with the edges of the roll-out.

    Returns the explained share of accelerations and of dissipation, and the bias of dissipation [%], each also with
    the DEM's own contacts as edges (`_contacts`).
    """
    snapshots = featurise(run, scene)
    last = len(run.time_s) - 2
    count = min(graphs, last - recipe.graph.window + 2)
    rows = torch.from_numpy(np.linspace(recipe.graph.window - 1, last, count).astype(np.int64))
    truth = target(snapshots, recipe.graph)[rows].numpy(), snapshots.dissipation[rows].numpy()
    found = {}
    for suffix, edges in (("", rule), ("_contacts", None)):
        with torch.inference_mode():
            batches = (graphs_at(snapshots, part, recipe.graph.window, edges) for part in rows.split(256))
            parts = [model(batch.to(device)) for batch in batches]
        acceleration, dissipation = (torch.cat(values).cpu().numpy() for values in zip(*parts, strict=True))
        found[f"one_step_acceleration_r2{suffix}"] = measures.explained_share(acceleration, truth[0])
        found[f"one_step_dissipation_r2{suffix}"] = measures.explained_share(dissipation, truth[1])
        found[f"one_step_dissipation_bias{suffix}_percent"] = float(100 * (dissipation.sum() / truth[1].sum() - 1))
    return found
