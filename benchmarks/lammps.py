"""LAMMPS: the input that expresses a case of ours, the run, and what its log says.

The contact law is ours as far as LAMMPS has the words (`pair_style granular`):

- `hertz/material` with `damping coeff_restitution` is our normal force, damping included. `damping tsuji` is not: in
  the wheel of envs/bench.lock a restitution of 0.30 comes out as 0.44.
- `tangential mindlin NULL x mu` is our spring; x makes its damping that of Eq. 3.9, see `tangential_damping_ratio`.
  The Coulomb cap differs: LAMMPS caps at mu times the size of the damped normal force, millprint at mu times the
  elastic one.
- `rolling sds` resists rolling by a spring, dashpot and slider whose lever is the reduced radius; our lever is the
  ball's radius, so a pair of equal balls has twice the coefficient. Our torque acts against the whole relative spin,
  about the normal too, which takes `twisting sds`.

Means are compared with all of that (`lammps.compared` in bench.yaml). What is timed is the plainer input that
its users write (`lammps.timed`): x = 1, the coefficient as it is, no twisting, `damping tsuji`, which costs it less.
"""

import math
from pathlib import Path

import numpy as np

from benchmarks.cases import Setup, Timing
from benchmarks.config import LammpsConfig, LammpsLaw
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import SimulationError
from millprint.dem.lammps.input import BALLS, INPUT, balls_text, head_lines
from millprint.dem.lammps.lammps_case import LammpsLog, start
from millprint.dem.laws.hertz import tangential_damping_ratio

# Steps between the samples of a mean.
SAMPLE_EVERY = 20

# Means in the order of `fix ave/time`, with the variable of the input that each is.
MEANS = {
    "kinetic_translation_J": "c_translation",
    "kinetic_spin_J": "c_spin",
    "wall_power_W": "v_wallpower",
    "identity_power_W": "v_identity",
    "ball_contacts": "v_ballcontacts",
    "wall_contacts": "v_wallcontacts",
}

MEANS_FILE = "means.txt"


def law_text(contact: ContactConfig, radius: float, law: LammpsLaw, lever: float) -> str:
    """The contact law for equal balls of a radius [m]; lever: that radius over the reduced one [-]."""
    sliding, rolling, poisson = 1.0, contact.rolling_friction, contact.value_of("poisson_ratio")
    if law.matched:
        sliding, rolling = tangential_damping_ratio(poisson), contact.rolling_friction * lever
    words = [
        f"hertz/material {contact.value_of('young_modulus_gpa') * 1e9!r} {contact.restitution!r} {poisson!r}",
        f"tangential mindlin NULL {sliding!r} {contact.static_friction!r}",
    ]
    stiffness, damping = law.rolling_stiffness_n_m, law.rolling_damping_ns_m
    if contact.rolling_friction:
        words.append(f"rolling sds {stiffness!r} {damping!r} {rolling!r}")
        if law.matched:
            arm = radius**2
            words.append(f"twisting sds {stiffness * arm!r} {damping * arm!r} {contact.rolling_friction * radius!r}")
    return " ".join([*words, f"damping {law.damping}"])


def data_text(setup: Setup, start: np.ndarray) -> str:
    """LAMMPS's data file: balls at rest at `start` (n, 3) [m], in a domain with room for the moving jar."""
    reach = 2 * setup.amplitude_m + setup.diameter_m
    low, high = (setup.jar.vessel.bounds + np.array([[-reach], [reach]])).tolist()
    return balls_text(low, high, start, setup.diameter_m, setup.contact.density_kg_m3)


def pair_lines(law: str) -> list[str]:
    """Input lines of the law between two balls."""
    return ["pair_style granular", f"pair_coeff * * {law}"]


def input_text(setup: Setup, settings: LammpsConfig, step_s: float, runs: list[int], with_means: bool) -> str:
    """LAMMPS's input: the jar moves by A (cos wt - 1), A sin wt from step 0 on, for each number of steps in `runs`.

    with_means: write the means of MEANS over every revolution of the last run to MEANS_FILE, under the law that
    means are compared with.
    """
    radius = setup.diameter_m / 2
    law = settings.compared if with_means else settings.timed
    pair, wall = (law_text(setup.contact, radius, law, lever) for lever in (2.0, 1.0))
    lines = [
        *head_lines(pair_lines(pair), settings.skin_m, step_s),
        f"variable A equal {setup.amplitude_m!r}",
        f"variable w equal {setup.angular_frequency!r}",
        "variable dx equal v_A*(cos(v_w*step*dt)-1)",
        "variable dy equal v_A*sin(v_w*step*dt)",
        "fix gravity all gravity 9.81 vector 0 0 -1",
        "fix motion all nve/sphere",
        f"region jar {setup.jar.region} side in move v_dx v_dy NULL units box",
        f"fix wall all wall/gran/region granular {wall} region jar",
        "thermo_style custom step cpu",
        f"thermo {max(runs)}",
        *[f"run {steps}" for steps in runs[:-1]],
        *(means_lines(setup, step_s) if with_means else []),
        f"run {runs[-1]}",
    ]
    return "\n".join(lines) + "\n"


def means_lines(setup: Setup, step_s: float) -> list[str]:
    """Input lines that average energies, powers and contacts over each revolution of the box.

    Wall power is F . V, of the force on all balls (pair forces cancel, and gravity is across V) and the jar's
    velocity; identity: M A w^2 (cos wt, sin wt) . <v>, its mean by parts over whole revolutions.
    """
    low, high = setup.jar.vessel.bounds.tolist()
    radius = setup.diameter_m / 2
    shift = {"x": "-v_dx", "y": "-v_dy", "z": ""}
    touching = [
        term
        for k, axis in enumerate("xyz")
        for term in (
            f"({axis}{shift[axis]}<{low[k] + radius!r})",
            f"({axis}{shift[axis]}>{high[k] - radius!r})",
        )
    ]
    revolution = round(2 * math.pi / setup.angular_frequency / step_s)
    if revolution % SAMPLE_EVERY:
        raise SimulationError(f"{revolution} steps a revolution: must be a multiple of {SAMPLE_EVERY} for means")
    return [
        "compute translation all ke",
        "compute spin all erotate/sphere",
        "compute touch all contact/atom",
        "compute pairs all reduce ave c_touch",
        f"variable walls atom {'+'.join(touching)}",
        "compute walls all reduce ave v_walls",
        "variable ballcontacts equal c_pairs",
        "variable wallcontacts equal c_walls",
        "variable wallpower equal v_A*v_w*(fcm(all,y)*cos(v_w*step*dt)-fcm(all,x)*sin(v_w*step*dt))",
        "variable identity equal mass(all)*v_A*v_w^2*(vcm(all,x)*cos(v_w*step*dt)+vcm(all,y)*sin(v_w*step*dt))",
        f"fix means all ave/time {SAMPLE_EVERY} {revolution // SAMPLE_EVERY} {revolution} "
        f"{' '.join(MEANS.values())} file {MEANS_FILE}",
    ]


def timing(log: LammpsLog) -> Timing:
    """The last loop of a log as a timing."""
    return Timing(log.steps, log.balls, log.loop_s, log.loop_s * log.processor_share)


class Lammps:
    """The LAMMPS of an environment: `folder/bin/lmp`; `version` is that of its last run, empty before."""

    version = ""

    def __init__(self, folder: str | Path, settings: LammpsConfig) -> None:
        self.folder, self.settings = Path(folder).resolve(), settings
        if not (self.folder / "bin" / "lmp").is_file():
            raise SimulationError(f"{folder}: there is no LAMMPS in this environment; `make bench` installs it")

    def run(self, place: Path, text: str, data: str) -> LammpsLog:
        """Run an input on one core in the folder `place`. Raises SimulationError where LAMMPS fails."""
        place.mkdir(parents=True, exist_ok=True)
        (place / INPUT).write_text(text)
        (place / BALLS).write_text(data)
        found = start([str(self.folder / "bin" / "lmp")], place, None)
        self.version = found.version
        return found

    def time(self, place: Path, setup: Setup, start: np.ndarray, steps: int, step_s: float) -> LammpsLog:
        """Time `steps` of the driven motion from `start`, with no output on the way."""
        return self.run(place, input_text(setup, self.settings, step_s, [steps], False), data_text(setup, start))

    def means(self, place: Path, setup: Setup, start: np.ndarray, runs: list[int], step_s: float) -> dict[str, float]:
        """Means of MEANS over the last of some runs, of whole revolutions each."""
        log = self.run(place, input_text(setup, self.settings, step_s, runs, True), data_text(setup, start))
        if log.balls != setup.balls:
            raise SimulationError(f"LAMMPS has lost {setup.balls - log.balls} balls in {setup.name}")
        rows = np.atleast_2d(np.loadtxt(place / MEANS_FILE))[:, 1:]
        return dict(zip(MEANS, rows.mean(axis=0).tolist(), strict=True))
