"""The input of LAMMPS for a case: our packing, step, window and walls, and what it writes."""

from typing import ClassVar, NamedTuple

import numpy as np

from millprint.config.sweep import DemConfig
from millprint.dem.lammps.granular_law import law_text
from millprint.dem.lammps.regions import wall_lines
from millprint.dem.resources import COLLISION_ROWS_MAX, COLLISIONS_HZ
from millprint.dem.simulation import Simulation
from millprint.mill.gravity import GRAVITY

# Files of a run, in its folder.
BALLS, INPUT, LOG = "balls.data", "in.lammps", "log.lammps"
STATES, TOUCHES, SNAPSHOTS = "states.txt", "contacts.txt", "snapshots.txt"
RESTARTS = ("restart_a", "restart_b")
# What is written of all balls together: mean position, mean velocity, angular momentum about the middle [SI] and of the
# spins, and kinetic energies.
STATE_NAMES = (
    "step",
    *(f"{name}{axis}" for name in ("x", "v", "l", "s") for axis in "xyz"),
    "translation_J",
    "spin_J",
)
CONTACT_NAMES = ("first", "second", "created", "steps", "closest_m")
SNAPSHOT_NAMES = ("id", "x", "y", "z", "vx", "vy", "vz", "omegax", "omegay", "omegaz")
# The skin of lists over a ball's radius.
SKIN_SHARE = 0.2
# Steps between outputs of contacts, in those of states.
CONTACTS_EVERY = 10
# Steps between checks of the balance of the ranks.
BALANCE_EVERY = 1000


class SampledDem(DemConfig):
    """Settings of a run whose states are written often enough for an integral over a turn."""

    ledger_samples_per_revolution: ClassVar[int] = 200


class Schedule(NamedTuple):
    """Steps of a run, counted by LAMMPS from 0 at the packing: when the mill starts, the window, what is written."""

    start: int
    begin: int
    end: int
    states: int
    snapshots: int

    @classmethod
    def of(cls, simulation: Simulation) -> "Schedule":
        """The schedule of our simulation."""
        begin = simulation.settle_steps + simulation.discard_steps
        end = begin + simulation.window_steps
        return cls(simulation.settle_steps, begin, end, simulation.sample_every, simulation.snapshot_every)


def balls_text(low: list[float], high: list[float], places_m: np.ndarray, diameter_m: float, density: float) -> str:
    """LAMMPS's data file: balls at rest at places (n, 3) [m], in a box from `low` to `high` [m]; density [kg/m3]."""
    lines = ["millprint", "", f"{len(places_m)} atoms", "1 atom types", ""]
    lines += [f"{low[k]!r} {high[k]!r} {axis}lo {axis}hi" for k, axis in enumerate("xyz")]
    lines += ["", "Atoms # sphere", ""]
    ball = f"{diameter_m!r} {density!r}"
    lines += [f"{number} 1 {ball} {x!r} {y!r} {z!r}" for number, (x, y, z) in enumerate(places_m.tolist(), start=1)]
    return "\n".join(lines) + "\n"


def head_lines(pair: list[str], skin_m: float, step_s: float, read: str = f"read_data {BALLS}") -> list[str]:
    """The beginning of an input: where balls are read, the law between two of them, the step [s]."""
    return [
        "units si",
        "atom_style sphere",
        "boundary f f f",
        "newton off",
        "comm_modify vel yes",
        read,
        *pair,
        f"neighbor {skin_m!r} bin",
        f"timestep {step_s!r}",
    ]


def data_text(simulation: Simulation) -> str:
    """The packed balls, in a domain with room for the walls at every time of a turn."""
    times = np.linspace(0, 1 / simulation.frequency_hz, 181) if simulation.frequency_hz else np.zeros(1)
    body = simulation.bodies[0]
    places = np.concatenate([body.to_laboratory(body.vessel.vertices, time) for time in times])
    # Vertices lie on a round wall, which reaches a little further between them.
    reach = simulation.diameter + 0.1 * float(np.ptp(places, axis=0).max())
    low, high = (places.min(axis=0) - reach).tolist(), (places.max(axis=0) + reach).tolist()
    return balls_text(low, high, simulation.balls.position, simulation.diameter, simulation.contact.density_kg_m3)


def tracks_contacts(simulation: Simulation) -> bool:
    """Whether the contacts between balls are written: not more than a table of ours may have."""
    return simulation.count * simulation.window_s * COLLISIONS_HZ <= COLLISION_ROWS_MAX


def input_text(simulation: Simulation, restart_every: int, ranks: int = 1) -> str:
    """The input of a case; `-var begin FILE` goes on from a restart file.

    restart_every: steps between restart files; ranks: processes, among which balls are shared evenly.
    """
    contact, radius, step = simulation.contact, simulation.radius, simulation.step
    schedule, tracked = Schedule.of(simulation), tracks_contacts(simulation)
    ball, wall = law_text(contact, radius, step, 2.0), law_text(contact.at_wall, radius, step, 1.0)
    smooth = law_text(contact.without_friction, radius, step, 1.0)
    pair = ["pair_style granular", f"pair_coeff * * {ball}"]
    if tracked:
        every = CONTACTS_EVERY * schedule.states
        tracker = f"tracker contacts {every} finite id1 id2 time/created time/total r/min"
        pair = [f"pair_style hybrid/overlay granular {tracker}"]
        pair += [f"pair_coeff * * granular {ball}", "pair_coeff * * tracker"]
    read = f'if "${{begin}} == packing" then "read_data {BALLS}" else "read_restart ${{begin}}"'
    # Balls lie in a bed that moves: domains are cut again, so that each rank has as many of them.
    shared = [f"fix shared all balance {BALANCE_EVERY} 1.1 rcb"] if ranks > 1 else []
    lines = [
        f"# {simulation.case.path}",
        "variable begin index packing",
        *(["comm_style tiled"] if shared else []),
        *head_lines(pair, SKIN_SHARE * radius, step, read),
        f"fix gravity all gravity {GRAVITY} vector 0 0 -1",
        "fix motion all nve/sphere",
        *wall_lines(simulation.mill, simulation.motion, schedule.start, wall, smooth),
        *shared,
        *state_lines(radius),
        f"restart {restart_every} {' '.join(RESTARTS)}",
        "thermo_style custom step cpu atoms ke",
        f"thermo {max(1, schedule.end // 100)}",
    ]
    before = schedule.begin - 1
    lines += [
        f'if "$(step) < {before}" then "run {before} upto"',
        f"variable at equal stride({schedule.begin},{schedule.end},{schedule.states})",
    ]
    values = " ".join(f"${{{name}}}" for name in STATE_NAMES)
    lines.append(f'fix states all print v_at "{values}" append {STATES} screen no title ""')
    if schedule.snapshots:
        lines += _dump("snapshots", f"custom {schedule.snapshots} {SNAPSHOTS} {' '.join(SNAPSHOT_NAMES)}")
        lines.append(f"variable shot equal stride({schedule.begin},{schedule.end},{schedule.snapshots})")
        lines.append("dump_modify snapshots sort id every v_shot")
    if tracked:
        values = " ".join(f"f_contacts[{n}]" for n in range(1, len(CONTACT_NAMES) + 1))
        lines += _dump("contacts", f"local {every} {TOUCHES} {values}")
    return "\n".join([*lines, f"run {schedule.end} upto"]) + "\n"


def _dump(name: str, words: str) -> list[str]:
    return [f"dump {name} all {words}", f"dump_modify {name} append yes format float %.9g"]


def state_lines(radius: float) -> list[str]:
    """Variables with the names of STATE_NAMES."""
    lines = ["compute omega all property/atom omegax omegay omegaz", "compute spin all erotate/sphere"]
    for number, axis in enumerate("xyz", start=1):
        lines += [
            f"variable own{axis} atom 0.4*mass*{radius**2!r}*c_omega[{number}]",
            f"compute s{axis} all reduce sum v_own{axis}",
            f"variable x{axis} equal xcm(all,{axis})",
            f"variable v{axis} equal vcm(all,{axis})",
            f"variable l{axis} equal angmom(all,{axis})",
            f"variable s{axis} equal c_s{axis}",
        ]
    return [*lines, "variable step equal step", "variable translation_J equal ke", "variable spin_J equal c_spin"]
