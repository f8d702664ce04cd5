"""Fuzzing of the input files: every damaged file is refused in one line per fault, or makes a valid plan.

    python -m tests.fuzz --count 5000 --seed 1

Each change is checked in this process as before the first job of a run: the configuration is read, bodies are built
and balls counted. The program is at fault if it raises another exception than ConfigError, if its message is not one
readable line per fault, or if it takes more than SECONDS of processor time or MEMORY_BYTES of memory.
"""

import argparse
import importlib
import random
import resource
import shutil
import signal
import tempfile
import time
import traceback
from collections import Counter
from contextlib import chdir
from dataclasses import dataclass, field
from pathlib import Path

import yaml
from snakemake.utils import update_config

ROOT = Path(__file__).parents[1]

import sys  # noqa: E402

sys.path.insert(0, str(ROOT / "src"))

import millprint.checks.before_running as preflight  # noqa: E402
import millprint.thesis.chapter_checks as chapters  # noqa: E402
from millprint.config.checks import load_workflow  # noqa: E402
from millprint.config.errors import ConfigError  # noqa: E402
from millprint.config.load import read_yaml  # noqa: E402
from millprint.config.workflow import WorkflowConfig  # noqa: E402
from tests.mutations import mutate_table, mutate_yaml  # noqa: E402
from tests.remembered import SLOW_PARTS  # noqa: E402

SECONDS = 20.0
MEMORY_BYTES = 3 << 30
LONGEST_LINE = 2000
CONFIG = "config/config.yaml"


@dataclass
class Outcome:
    """Results of the fuzzing: how often each outcome came, the faults of the program, the slowest check [s]."""

    kinds: Counter = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)
    slowest_s: float = 0.0


# Keys that no included mill of the run has, each with a value that is valid.
OWN_DRUM = {
    "name": "own_drum",
    "title": "Drum with lifters",
    "source": "made up",
    "volume_ml": 2300,
    "volume_tolerance": 0.1,
    "geometry": {
        "kind": "lifter_drum", "axis": "y", "radius_mm": 100, "length_mm": 80, "facets": 36, "smooth_ends": True,
        "lifters": {"number": 6, "height_mm": 12, "width_mm": 20, "face_angle_deg": 60},
    },
    "motion": {"kind": "rotation", "axis": [0, 1, 0]},
    "sweep": {
        "speeds_rpm": [50],
        "ball_diameters_mm": [
            20,
            {"name": "half", "sizes_mm": [20, 12.5], "shares": [0.5, 0.5]},
            {"name": "few", "sizes_mm": [15, 20], "numbers": [3, 1]},
        ],
        "fill_ratios": [0.1, 0.15, 0.2],
        "seeds": [0],
    },
}  # fmt: skip
OWN_WALLS = {
    "wall_restitution": {"speeds_m_s": [0.1, 1.0], "values": [0.7, 0.6]},
    "wall_static_friction": 0.4,
    "wall_rolling_friction": 0.02,
    "cohesion": {"ball_ball_J_m2": 0.1, "ball_wall_N": 0.01},
}
# Sections that the configuration at hand leaves to their defaults, written out so that each key is damaged.
DEFAULTED = ("convergence", "validation", "uncertainty")


def make_project(folder: Path) -> Path:
    """Copy the configuration at smoke size to `folder`, and add what it does not have.

    Tables of measured drops and of a track, a drum with lifters and charges of several sizes, frictions of walls, and
    every key of the sections DEFAULTED.
    """
    shutil.copytree(ROOT / "config", folder / "config")
    content = yaml.safe_load((ROOT / CONFIG).read_text())
    update_config(content, yaml.safe_load((ROOT / "config/smoke.yaml").read_text()))
    content["calibration"]["drop_test"]["measured"] = "config/data/drops.tsv"
    content["calibration"]["oscillation"]["experiments"].append(
        {"name": "own", "contact": "steel", "track": "config/data/track.tsv"}
    )
    content["mills"]["box"].append("own_drum")
    (folder / "config/mills/own_drum.yaml").write_text(yaml.safe_dump(OWN_DRUM, sort_keys=False))
    steel = folder / "config/contacts/steel.yaml"
    steel.write_text(yaml.safe_dump(yaml.safe_load(steel.read_text()) | OWN_WALLS, sort_keys=False))
    whole = WorkflowConfig(**content).model_dump(mode="json")
    content |= {section: whole[section] for section in DEFAULTED}
    (folder / CONFIG).write_text(yaml.safe_dump(content, allow_unicode=True, sort_keys=False))
    rows = [(0.02 * k, 20 - 0.1 * k, 5 + 0.05 * k) for k in range(100)]
    lines = ["time_s\tacross_mm\theight_mm", *("\t".join(f"{value:g}" for value in row) for row in rows)]
    (folder / "config/data/track.tsv").write_text("\n".join(lines) + "\n")
    drops = ["drop_height_mm\tbounce_height_mm", "10\t3", "20\t6.1", "40\t12.2"]
    (folder / "config/data/drops.tsv").write_text("\n".join(drops) + "\n")
    return folder


def remember_shapes() -> None:
    """Cache the slow checks: most changes do not touch the mills."""
    for place, quick in SLOW_PARTS.items():
        module, name = place.rsplit(".", 1)
        setattr(importlib.import_module(module), name, quick)


def plan() -> None:
    """Check the input as the Snakefile does before the first job. Raises ConfigError."""
    loaded = load_workflow(read_yaml(CONFIG), [CONFIG])
    preflight.check_before_running(*loaded, CONFIG, chapters.chapter_faults)


class TooSlow(BaseException):
    """Raised in a check that takes too long. A BaseException, so that no `except Exception` catches it."""


def _stop_slow_check(number, frame):
    raise TooSlow(f"takes more than {SECONDS:g} s")


def outcome_of(name: str) -> str:
    """The outcome of one damaged file: `valid`, `refused`, or a description of the fault."""
    signal.signal(signal.SIGPROF, _stop_slow_check)
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    try:
        plan()
        return "valid"
    except ConfigError as error:
        lines = str(error).splitlines() or [""]
        bad = [line for line in lines if not line.strip() or len(line) > LONGEST_LINE or not line.isprintable()]
        return f"a refusal that is not one readable line: {bad[0][:300]!r}" if bad else "refused"
    except BaseException:
        return traceback.format_exc(limit=-6)
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)


def fuzz(count: int, seed: int, folder: Path, only: str = "") -> Outcome:
    """Make a project in `folder` and damage one file at a time, `count` times."""
    project, outcome, rng = make_project(folder), Outcome(), random.Random(seed)
    # Each group gets the same number of changes; the configuration counts twice.
    groups = [sorted((project / "config").glob(pattern)) for pattern in
              ("mills/*.yaml", "contacts/*.yaml", "config.yaml", "config.yaml", "data/*.tsv")]  # fmt: skip
    groups = [[file for file in group if only in str(file)] for group in groups]
    groups = [group for group in groups if group]
    with chdir(project):
        for number in range(count):
            file = rng.choice(rng.choice(groups))
            whole = file.read_text()
            damage = (mutate_table if file.suffix == ".tsv" else mutate_yaml)(whole, rng)
            file.write_text(damage, encoding="utf-8", errors="surrogatepass")
            begin = time.process_time()
            found = outcome_of(file.name)
            outcome.slowest_s = max(outcome.slowest_s, time.process_time() - begin)
            file.write_text(whole)
            outcome.kinds[found if found in ("valid", "refused") else "fault"] += 1
            if found not in ("valid", "refused"):
                outcome.faults.append(f"change {number} of {file.name}, seed {seed}:\n{damage[:400]}\n{found}")
                (folder / f"fault_{seed}_{number}_{file.name}").write_text(damage, errors="surrogatepass")
    return outcome


def limit_memory() -> None:
    """Limit the memory of this process: a change that needs too much ends with MemoryError and does not swap."""
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY_BYTES, resource.RLIM_INFINITY))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=1000, help="damaged files")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", default="", help="damage only files whose path contains this, such as mills/ or .tsv")
    parser.add_argument("--keep", type=Path, help="folder for the project and for each file that caused a fault")
    options = parser.parse_args()
    folder = options.keep or Path(tempfile.mkdtemp(prefix="fuzz_"))
    limit_memory()
    remember_shapes()
    outcome = fuzz(options.count, options.seed, folder, options.only)
    for fault in outcome.faults:
        print(f"--- {fault}")
    print(f"{dict(outcome.kinds)}; slowest {outcome.slowest_s:.1f} s")
    return bool(outcome.faults)


if __name__ == "__main__":
    sys.exit(main())
