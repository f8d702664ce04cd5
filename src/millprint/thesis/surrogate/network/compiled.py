"""The roll-out of a graph network as one kernel, and what takes the steps on which device."""

from functools import cached_property

import numpy as np

from millprint.mill.distance import SignedDistance
from millprint.thesis.surrogate.network.folded import Folded, fold
from millprint.thesis.surrogate.network.forward import make_scratch
from millprint.thesis.surrogate.network.graph_surrogate import GraphSurrogate, State, Sums, no_sums
from millprint.thesis.surrogate.network.graphs import ball_reach
from millprint.thesis.surrogate.network.recursion import Batch, Rules, roll
from millprint.thesis.surrogate.network.sdf_network import NormalisedNetwork, read_weights
from millprint.thesis.surrogate.protocol import Setting
from millprint.thesis.surrogate.scene import read_scene
from millprint.thesis.surrogate.trajectory import read_trajectory


class CompiledSurrogate(GraphSurrogate):
    """A graph network whose steps are compiled. Its model is a NormalisedNetwork, and its vessel one of facets."""

    @cached_property
    def weights(self) -> Folded:
        """The weights of the model. Raises TypeError for a model that is not this network."""
        if not isinstance(self.model, NormalisedNetwork):
            raise TypeError(f"the compiled step knows NormalisedNetwork, not {type(self.model).__name__}")
        return fold(self.model)

    @cached_property
    def rules(self) -> Rules:
        """The rules of the recursion as the kernel takes them."""
        return Rules(
            step_s=self.step_s,
            speed_rpm=self.scene.speed_rpm,
            reach_squared_m2=np.float32(ball_reach(self.edges, self.scene.ball_radius_m) ** 2),
            wall_threshold_m=np.float32(self.edges.wall_threshold_m),
            snap_back_m=np.inf if self.snap_back_m is None else self.snap_back_m,
        )

    def batch(self, state: State) -> Batch:
        """A state for the kernel to write over; the state itself stays as it is."""
        position, velocity, ball, wall = (
            np.array(values, order="C") for values in (state.position_m, state.velocity_m_s, state.ball, state.wall)
        )
        return Batch(position, velocity, ball, wall, *no_sums(state))

    def advance_many(self, state: State, steps: int) -> tuple[State, Sums]:
        """The state some steps later, and what is added up over them. Raises TypeError for a wall without facets."""
        distance = self.scene.distance
        if not isinstance(distance, SignedDistance):
            raise TypeError(f"the compiled step knows the walls of SignedDistance, not {type(distance).__name__}")
        graphs, balls, _ = state.position_m.shape
        # Added up step by step, as a clock does.
        later = np.full((steps, graphs), self.step_s)
        times_s = np.cumsum(np.concatenate([state.time_s[None], later]), axis=0)[1:]
        batch = self.batch(state)
        panels, inputs, panel = self.weights.node_first.shape
        scratch = make_scratch(graphs, balls, inputs, panels * panel)
        walls = np.ascontiguousarray(self.scene.wall_position(times_s))
        roll(self.weights, scratch, distance.surface, self.rules, batch, walls)
        after = State(times_s[-1], batch.position, batch.velocity, batch.ball, batch.wall)
        return after, Sums(batch.dissipated, batch.crossed, batch.edges)


# By the type of a torch device: a graphics card has no kernels of ours.
STEPPED_BY: dict[str, type[GraphSurrogate]] = {"cpu": CompiledSurrogate, "cuda": GraphSurrogate}


def open_graph_surrogate(setting: Setting) -> GraphSurrogate:
    """The network of a weights file in the scene of a simulation.

    Raises ConfigError for a damaged file, and KeyError for a device that is not in STEPPED_BY.
    """
    model, recipe = read_weights(setting.weights, setting.device)
    source, window = read_trajectory(setting.run, until_s=setting.until_s), recipe.graph.window
    stepped = STEPPED_BY[setting.device.type]
    return stepped(model, read_scene(setting.run), source, window, setting.edges, setting.snap_back_m, setting.device)
