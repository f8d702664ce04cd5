"""The input of LAMMPS for a case: our contact law, walls, packing, step and window in its words.

- `damping coeff_restitution` is our normal dashpot. Our force may pull before a contact ends, and our Coulomb cap is mu
  times the elastic force, whose impulse is m (1 + e) v; LAMMPS caps at mu times the damped force. With `limit_damping`
  its force never pulls, and its impulse is m (1 + e) v too, if the coefficient is the one with which such a force has
  the restitution e: `damped_coefficient`.
- `tangential mindlin/force NULL x mu` is our spring, and x makes its dashpot that of Eq. 3.9. A spring that is stored
  as a displacement would be drawn backwards by a dashpot above the cap and stick where ours slides.
- `rolling sds` and `twisting sds` resist by a spring, dashpot and slider; the spring is as stiff as the step allows,
  so that the slider's constant torque acts. Its lever is the reduced radius, ours the ball's.

docs/how_to/lammps.md has how near single impacts are.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar, NamedTuple, cast

import numpy as np

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import BoxGeometry, CylinderGeometry, DrumGeometry, LifterDrumGeometry, MillConfig
from millprint.config.motion_kinds import Drive
from millprint.config.sweep import DemConfig
from millprint.dem.laws.record import InLammps, ball_mass, damping_ratio
from millprint.dem.laws.registry import LAWS
from millprint.dem.resources import COLLISION_ROWS_MAX, COLLISIONS_HZ
from millprint.dem.simulation import Simulation
from millprint.mill.gravity import GRAVITY
from millprint.mill.motion import Motion

# Angle that a ball's rolling spring swings through in a step [rad].
ROLLING_PHASE = 0.2
# The smallest coefficient that is tried.
LEAST = 1e-4
REMEDY = "take dem.engine: numba for it"


def law_for(kind: str) -> tuple[float, InLammps]:
    """The power of the overlap in the normal force of a law, and its words. Raises ConfigError for one without any."""
    law = LAWS.get(kind)
    if law is None or law.lammps is None:
        known = ", ".join(name for name, each in LAWS.items() if each.lammps)
        raise ConfigError(f"kind = {kind}: LAMMPS gets {known}; {REMEDY}")
    return law.overlap_power - 1, law.lammps


def restitution_without_pull(coefficient: float, kind: str) -> float:
    """The restitution of an impact whose damped force x^p + c x^((p - 1) / 2) v, of `coefficient`, may not pull."""
    from scipy.integrate import solve_ivp

    if coefficient == 1:
        return 1.0
    power, own = law_for(kind)
    damping = -damping_ratio(coefficient) * own.damping

    def force(_: float, y: tuple[float, float]) -> float:
        overlap = max(y[0], 0.0)
        return float(overlap**power + damping * overlap ** ((power - 1) / 2) * y[1])

    force.terminal, force.direction = True, -1  # type: ignore[attr-defined]
    found = solve_ivp(
        lambda t, y: (y[1], -force(t, y)), (0, 1e3), (1e-9, 1.0), rtol=1e-9, atol=1e-13, events=force, max_step=0.1
    )
    return float(-found.y[1, -1])


@lru_cache(maxsize=64)
def damped_coefficient(restitution: float, kind: str) -> float:
    """The coefficient with which LAMMPS's force that may not pull has a restitution. Raises ConfigError below any."""
    # Slow to import, and the Snakefile imports this module.
    from scipy.optimize import brentq

    if restitution == 1:
        return 1.0
    least = restitution_without_pull(LEAST, kind)
    if restitution <= least:
        raise ConfigError(
            f"restitution = {restitution:g}: a force of LAMMPS that never pulls has {least:.2g} at least; "
            "take a larger one, or dem.engine: numba"
        )
    return cast(float, brentq(lambda own: restitution_without_pull(own, kind) - restitution, LEAST, 1.0))


def law_text(contact: ContactConfig, radius: float, step_s: float, lever: float) -> str:
    """The law of equal balls of a radius [m] at a step [s]; lever: that radius over the reduced one [-]."""
    coefficient = damped_coefficient(contact.value_of("restitution"), contact.kind)
    words = law_for(contact.kind)[1].words(contact, coefficient, contact.value_of("static_friction"))
    if contact.rolling_friction:
        # Of a ball on a wall, I w^2 = k R^2 with w = ROLLING_PHASE / step and I = 2/5 m R^2; damped to a half.
        inertia = 0.4 * ball_mass(contact, radius)
        stiffness, damping = inertia * (ROLLING_PHASE / step_s) ** 2, inertia * ROLLING_PHASE / step_s
        words.append(f"rolling sds {stiffness!r} {damping!r} {contact.rolling_friction * lever!r}")
        arm = radius**2
        words.append(f"twisting sds {stiffness * arm!r} {damping * arm!r} {contact.rolling_friction * radius!r}")
    return " ".join([*words, "damping coeff_restitution limit_damping"])


AXES = "xyz"
# Half the size of a block that is endless across two of its axes [m].
ENDLESS = 100.0


@dataclass(frozen=True)
class Region:
    """A vessel as a region of LAMMPS; of a round one, the number of its axis and its ends along it [m]."""

    words: str
    along: int = 0
    low: float = 0.0
    high: float = 0.0


@dataclass(frozen=True)
class Form:
    """A kind of shape that LAMMPS has.

    region(shape): its vessel; lacks(shape, drive): the key that LAMMPS cannot express, and why; parts(shape): walls
    besides the vessel, each of which turns about the axis on its own, and part(shape): the first of them.
    """

    region: Callable[[Any], Region]
    lacks: Callable[[Any, Drive], str | None] = lambda shape, drive: None
    parts: Callable[[Any], int] = lambda shape: 0
    part: Callable[[Any], str] = lambda shape: ""


def unsupported(mill: MillConfig) -> str | None:
    """The key of a mill that LAMMPS cannot express, and why; None for one that it can."""
    shape, motion, drive = mill.geometry, mill.motion, mill.motion.drive()
    if shape.kind not in FORMS:
        return f"geometry.kind = {shape.kind}: LAMMPS gets {', '.join(FORMS)}"
    if shape.faceted:
        return "geometry.faceted = true: LAMMPS has smooth walls"
    if drive.is_curve:
        return f"motion.kind = {motion.kind}: LAMMPS gets motions of harmonics and rotations"
    if reason := FORMS[shape.kind].lacks(shape, drive):
        return reason
    return "inserts: LAMMPS gets the vessel only" if mill.inserts else None


def _waves(rows: np.ndarray, cosine: int, sine: int) -> str:
    """The formula of a sum of waves: angular frequency [rad/s] and the amplitudes in two columns."""
    terms = []
    for row in rows.tolist():
        if row[cosine]:
            terms.append(f"{row[cosine]!r}*cos({row[0]!r}*v_t)")
        if row[sine]:
            terms.append(f"{row[sine]!r}*sin({row[0]!r}*v_t)")
    return "+".join(terms)


def motion_lines(motion: Motion, start: int) -> tuple[list[str], str]:
    """Variables of a motion from step `start` on, and the words that give it to a region in the body frame.

    LAMMPS turns a region by v_angle about a point and moves it then, as `mill.motion` does.
    """
    lines, words = [f"variable t equal dt*(step-{start})*(step>{start})"], ""
    moved = [_waves(motion.harmonics, 1 + axis, 4 + axis) for axis in range(3)]
    if any(moved):
        lines += [f"variable d{name} equal {text}" for name, text in zip(AXES, moved, strict=True) if text]
        words += f" move {' '.join(f'v_d{name}' if text else 'NULL' for name, text in zip(AXES, moved, strict=True))}"
    if motion.turns:
        turned = [f"{motion.rate!r}*v_t" if motion.rate else "", _waves(motion.swing, 1, 2)]
        lines.append(f"variable angle equal {'+'.join(filter(None, turned))}")
        words += f" rotate v_angle {' '.join(map(repr, [*motion.pivot.tolist(), *motion.axis.tolist()]))}"
    return lines, words


def _block(low: np.ndarray, high: np.ndarray) -> str:
    return "block " + " ".join(f"{a!r} {b!r}" for a, b in zip(low.tolist(), high.tolist(), strict=True))


def _box(shape: BoxGeometry) -> Region:
    half = np.array([shape.x_mm, shape.y_mm, shape.z_mm]) / 2e3
    centre = np.array([0, 0, half[2]]) if shape.centre_mm is None else np.array(shape.centre_mm) / 1e3
    return Region(_block(centre - half, centre + half))


def _round(shape: DrumGeometry, length: float, centre: np.ndarray) -> Region:
    """A cylinder of a length [m] about its centre (3,) [m]."""
    along, radius = AXES.index(shape.axis), shape.radius_mm / 1e3
    low, high = float(centre[along] - length / 2), float(centre[along] + length / 2)
    first, second = np.delete(centre, along).tolist()
    return Region(f"cylinder {shape.axis} {first!r} {second!r} {radius!r} {low!r} {high!r}", along, low, high)


def _cylinder(shape: CylinderGeometry) -> Region:
    length, centre = shape.height_mm / 1e3, np.zeros(3)
    if shape.centre_mm is not None:
        centre = np.array(shape.centre_mm) / 1e3
    elif shape.axis == "z":
        centre[2] = length / 2
    return _round(shape, length, centre)


def _fillets(shape: CylinderGeometry, _drive: Drive) -> str | None:
    if shape.fillet_radius_mm and shape.fillet_ends != "none":
        return f"geometry.fillet_radius_mm = {shape.fillet_radius_mm:g}: LAMMPS's cylinder has flat ends"
    return None


def _drum(shape: LifterDrumGeometry) -> Region:
    return _round(shape, shape.length_mm / 1e3, np.zeros(3))


def _slanted(shape: LifterDrumGeometry, drive: Drive) -> str | None:
    if shape.lifters.face_angle_deg != 90:
        return f"geometry.lifters.face_angle_deg = {shape.lifters.face_angle_deg:g}: LAMMPS gets lifters of 90 degrees"
    along = AXES.index(shape.axis)
    off_axis = (value for vector in (drive.axis, drive.pivot_mm) for axis, value in enumerate(vector) if axis != along)
    if (drive.turns or drive.swing) and any(off_axis):
        return "motion.axis: LAMMPS turns a drum with lifters about its own axis only"
    return None


def _lifter(shape: LifterDrumGeometry) -> str:
    """The first lifter: a block that reaches through the shell and the ends, where no ball is."""
    along = AXES.index(shape.axis)
    radial, across = (along + 1) % 3, (along + 2) % 3
    inner, height, low, high = shape.radius_mm / 1e3, shape.lifters.height_mm / 1e3, np.zeros(3), np.zeros(3)
    low[[along, radial, across]] = -shape.length_mm / 1e3, inner - height, -shape.lifters.width_mm / 2e3
    high[[along, radial, across]] = shape.length_mm / 1e3, inner + height, shape.lifters.width_mm / 2e3
    return _block(low, high)


# By the kind of a geometry.
FORMS = {
    "cylinder": Form(_cylinder, _fillets),
    "lifter_drum": Form(_drum, _slanted, lambda shape: shape.lifters.number, _lifter),
    "box": Form(_box),
}


def wall_lines(mill: MillConfig, motion: Motion, start: int, law: str, smooth_law: str) -> list[str]:
    """Regions and walls of a mill that starts at a step; law: of the walls; smooth_law: of ends without friction."""
    shape = mill.geometry
    lines, words = motion_lines(motion, start)

    def wall(name: str, region: str, side: str, own: str, at: str = "", ends: str = "") -> list[str]:
        return [
            f"region {name} {region} side {side}{at or words} units box{ends}",
            f"fix {name} all wall/gran/region granular {own} region {name}",
        ]

    form = FORMS[shape.kind]
    region, parts, has_ends = form.region(shape), form.parts(shape), shape.smooth_axis is not None
    lines += wall("vessel", region.words, "in", law, ends=" open 1 open 2" if has_ends else "")
    end = np.eye(3)[region.along]
    if has_ends:
        corner = np.full(3, ENDLESS)
        corner[region.along] = 0
        lines += wall("ends", _block(region.low * end - corner, region.high * end + corner), "in", smooth_law)
    axis, sense = " ".join(map(repr, end.tolist())), float(motion.axis[region.along])
    for number in range(parts):
        place = 2 * np.pi * number / parts
        turned = f"+{sense!r}*v_angle" if motion.turns else ""
        lines.append(f"variable angle{number} equal {float(place)!r}{turned}")
        moved = words.split(" rotate")[0]
        at = f"{moved} rotate v_angle{number} 0.0 0.0 0.0 {axis}"
        lines += wall(f"lifter{number}", form.part(shape), "out", law, at)
    return lines


# Files of a run, in its folder.
BALLS, INPUT, LOG = "balls.data", "in.lammps", "log.lammps"
STATES, TOUCHES, SNAPSHOTS = "states.txt", "contacts.txt", "snapshots.txt"
RESTARTS = ("restart_a", "restart_b")
# What is written of all balls together: mean position, mean velocity, angular momentum about the middle [SI] and of the
# spins, and kinetic energies.
STATE_NAMES = ("step", *(f"{name}{axis}" for name in ("x", "v", "l", "s") for axis in "xyz"), "translation_J", "spin_J")
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
