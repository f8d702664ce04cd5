"""The network in torch, for training: the formulas of `predictor`, for all contacts of many states at once."""

import torch
from torch import Tensor, nn

from millprint.surrogate.contact import samples as s
from millprint.surrogate.contact.pair import INPUTS, OUTPUT, OUTPUTS
from millprint.surrogate.contact.predictor import (
    DASHPOT_FACTOR,
    KNEE,
    NORMAL_SHARE,
    SLIP_SHARE,
    SMALL,
    SPRING_FACTOR,
    UNIT,
)


def squareplus(z: Tensor) -> Tensor:
    """(z + sqrt(z^2 + 4)) / 2: a smooth ramp without exponentials, cheap in a kernel."""
    return (z + torch.sqrt(z * z + 4)) / 2


def compressed(number: Tensor) -> Tensor:
    """x / sqrt(|x| + KNEE): linear near zero, a root far from it."""
    return number / torch.sqrt(number.abs() + KNEE)


def along(a: Tensor, b: Tensor) -> Tensor:
    """Dot product over the last axis, kept."""
    return (a * b).sum(-1, keepdim=True)


def size(a: Tensor) -> Tensor:
    """Length over the last axis, kept; smooth at zero."""
    return torch.sqrt(along(a, a) + 1e-20)


class Graph:
    """Contacts of many states: rows of samples (n, SAMPLE_COLUMNS), with separate ball numbers for each state."""

    def __init__(self, rows: Tensor, first: Tensor, second: Tensor, balls: int):
        """first (n,) and second (n,; -1 for a wall): numbers of the balls; balls: how many in all."""
        self.first, self.balls = first, balls
        self.second = torch.where(second < 0, balls, second)
        take = lambda at, width=1: rows[:, at : at + width]  # noqa: E731
        self.step, self.is_wall = take(s.STEP), take(s.IS_WALL)
        away = take(s.AWAY, 3)
        distance = size(away)
        self.normal = away / distance
        self.arm, self.other = take(s.ARM), take(s.OTHER_ARM)
        self.inverse = take(s.INVERSE_MASS), take(s.OTHER_INVERSE_MASS)
        self.inverse_inertia = take(s.INVERSE_INERTIA), take(s.OTHER_INVERSE_INERTIA)
        mass = 1 / (self.inverse[0] + self.inverse[1])
        root = mass / (take(s.STIFFNESS) * self.step**2)
        self.length = UNIT * root**2
        self.unit = mass * self.length / self.step**2
        self.friction, self.overlap = take(s.FRICTION), -take(s.GAP) / self.length
        velocity = take(s.VELOCITY, 3)
        turning = self.arm * take(s.ANGULAR_VELOCITY, 3) + self.other * take(s.OTHER_ANGULAR_VELOCITY, 3)
        self.slip = self.step / self.length * (velocity - torch.linalg.cross(turning, self.normal))
        self.force = take(s.FORCE, 3)
        self.base = take(s.BASE, 3)

    def torques(self, force: Tensor) -> tuple[Tensor, Tensor]:
        """Torques (n, 3) of forces (n, 3) [N] on the first and on the second body [N m]."""
        lever = torch.linalg.cross(force, self.normal)
        return self.arm * lever, self.other * lever

    def external(self, expected: Tensor) -> Tensor:
        """External acceleration of each contact's point (n, 3) [m/s2], if contacts exert `expected` (n, 3) [N]."""
        torque, back = self.torques(expected)
        sums = expected.new_zeros(self.balls + 1, 6)
        sums.index_add_(0, self.first, torch.cat([expected, torque], 1))
        sums.index_add_(0, self.second, torch.cat([-expected, back], 1))
        mine, others = sums[self.first], sums[self.second]
        linear = self.base + self.inverse[0] * (mine[:, :3] - expected) - self.inverse[1] * (others[:, :3] + expected)
        angular = self.inverse_inertia[0] * (mine[:, 3:] - torque)
        other_angular = self.inverse_inertia[1] * (others[:, 3:] - back)
        twisting = self.arm * angular + self.other * other_angular
        return linear - torch.linalg.cross(twisting, self.normal)


class Predictor(nn.Module):
    """Rounds of messages, each with two hidden layers. Untrained, it predicts the last forces."""

    def __init__(self, width: int, rounds: int):
        super().__init__()
        self.rounds = nn.ModuleList(
            nn.ModuleList([nn.Linear(INPUTS, width), nn.Linear(width, width), nn.Linear(width, OUTPUTS)])
            for _ in range(rounds)
        )
        for layers in self._layers():
            nn.init.zeros_(layers[2].weight)
            nn.init.zeros_(layers[2].bias)

    def _layers(self) -> list[list[nn.Linear]]:
        """The three layers of each round."""
        return [[layer for layer in layers.children() if isinstance(layer, nn.Linear)] for layers in self.rounds]

    def forward(self, graph: Graph) -> list[tuple[Tensor, Tensor]]:
        """Mean force and its tilt (n, 3) of every contact after each round, in units of the contact."""
        expected, results = graph.force, []
        for layers in self._layers():
            mean, tilt = self.one_round(layers, graph, expected)
            results.append((mean, tilt))
            expected = graph.unit * mean
        return results

    def one_round(self, layers: list[nn.Linear], graph: Graph, expected: Tensor) -> tuple[Tensor, Tensor]:
        """Mean force and tilt of each contact, in its units, if all exert `expected` (n, 3) [N]."""
        external = graph.step**2 / graph.length * graph.external(expected)
        force = graph.force / graph.unit
        f, a, u = along(force, graph.normal), along(external, graph.normal), -along(graph.slip, graph.normal)
        p, q, r = force - f * graph.normal, graph.slip + u * graph.normal, external - a * graph.normal
        sizes = size(p), size(q), size(r)
        after = graph.overlap + u - 0.5 * a
        cosines = [
            along(x, y) / (m * n + SMALL)
            for x, y, m, n in ((p, q, sizes[0], sizes[1]), (p, r, sizes[0], sizes[2]), (q, r, sizes[1], sizes[2]))
        ]
        used = (sizes[0] / (graph.friction * f.abs() + 1e-3)).clamp(max=2)
        scalars = [compressed(v) for v in (graph.overlap, u, f, a, *sizes)]
        inputs = torch.cat([*scalars, *cosines, used, graph.is_wall, compressed(after)], 1)
        hidden = squareplus(layers[1](squareplus(layers[0](inputs))))
        o = layers[2](hidden)
        o = (o / torch.sqrt(1 + o * o)).split(1, dim=1)
        root = torch.sqrt(torch.maximum(after, graph.overlap).clamp(min=0) + 1e-24)
        s_ = (SPRING_FACTOR * root + DASHPOT_FACTOR * torch.sqrt(root)) * (u.abs() + 0.5 * (f + a).abs())
        cap = graph.friction * (f.abs() + s_)
        q, r = SLIP_SHARE * q * cap / (cap + sizes[1] + SMALL), r * cap / (cap + sizes[2] + SMALL)
        w = s_ / (s_ + f.abs() + SMALL)
        mean = (f + NORMAL_SHARE * s_ * o[OUTPUT.normal]) * graph.normal
        mean = mean + (1 + w * o[OUTPUT.friction]) * p + o[OUTPUT.slip] * q + o[OUTPUT.sideways] * r
        tilt = NORMAL_SHARE * s_ * o[OUTPUT.normal_tilt] * graph.normal + w * o[OUTPUT.friction_tilt] * p
        tilt = tilt + o[OUTPUT.slip_tilt] * q + o[OUTPUT.sideways_tilt] * r
        return mean, tilt

    def arrays(self) -> list:
        """Layers as weights.make_weights takes them."""
        stacked = []
        for k in range(3):
            stacked.append(torch.stack([layers[k].weight for layers in self._layers()]))
            stacked.append(torch.stack([layers[k].bias for layers in self._layers()]))
        return [value.detach().cpu().numpy() for value in stacked]


def targets(rows: Tensor, graph: Graph) -> tuple[Tensor, Tensor]:
    """Mean force J / h and tilt 3 J / h - 6 M / h^2 of the labels, in units of the contact."""
    impulse, moment = rows[:, s.IMPULSE : s.IMPULSE + 3], rows[:, s.MOMENT : s.MOMENT + 3]
    mean = impulse / graph.step
    return mean / graph.unit, (3 * mean - 6 * moment / graph.step**2) / graph.unit
