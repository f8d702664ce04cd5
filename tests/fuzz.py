"""Fuzzing of what users write: every damaged file is refused in lines that begin with it, or makes a valid plan.

    python -m tests.fuzz --count 5000 --seed 1

Each change is checked in this process, as before a first job: the configuration read, bodies built, balls counted.
Reported as a fault: an exception other than ConfigError, a refusal that is not one line a fault, more than SECONDS of
processor time, or more memory than MEMORY_BYTES.
"""

import argparse
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
from functools import cache
from pathlib import Path

import yaml
from snakemake.utils import update_config

ROOT = Path(__file__).parents[1]

import sys  # noqa: E402

sys.path.insert(0, str(ROOT / "scripts"))

import millprint.calibration.preflight as calibration  # noqa: E402
import millprint.preflight as preflight  # noqa: E402
from millprint.config.checks import load_workflow  # noqa: E402
from millprint.config.load import read_yaml  # noqa: E402
from millprint.config.mill import MillConfig  # noqa: E402
from millprint.errors import ConfigError  # noqa: E402
from tests.mutations import mutate_table, mutate_yaml  # noqa: E402

SECONDS = 20.0
MEMORY_BYTES = 3 << 30
LONGEST_LINE = 2000
CONFIG = "config/config.yaml"


@dataclass
class Outcome:
    """What became of the damaged files."""

    kinds: Counter = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)
    slowest_s: float = 0.0


def make_project(folder: Path) -> Path:
    """The project's configuration at smoke size, with tables of a user's own for what the thesis has none."""
    shutil.copytree(ROOT / "config", folder / "config")
    content = yaml.safe_load((ROOT / CONFIG).read_text())
    update_config(content, yaml.safe_load((ROOT / "config/smoke.yaml").read_text()))
    content["calibration"]["drop_test"]["measured"] = "config/data/drops.tsv"
    content["calibration"]["oscillation"]["experiments"].append(
        {"name": "own", "contact": "steel", "track": "config/data/track.tsv"}
    )
    (folder / CONFIG).write_text(yaml.safe_dump(content, allow_unicode=True, sort_keys=False))
    rows = [(0.02 * k, 20 - 0.1 * k, 5 + 0.05 * k) for k in range(100)]
    lines = ["time_s\tacross_mm\theight_mm", *("\t".join(f"{value:g}" for value in row) for row in rows)]
    (folder / "config/data/track.tsv").write_text("\n".join(lines) + "\n")
    drops = ["drop_height_mm\tbounce_height_mm", "10\t3", "20\t6.1", "40\t12.2"]
    (folder / "config/data/drops.tsv").write_text("\n".join(drops) + "\n")
    return folder


@cache
def _bodies_of(mill_json: str, volume_tolerance: float):
    # A dump leaves the tolerance out.
    mill = MillConfig.model_validate_json(mill_json).model_copy(update={"volume_tolerance": volume_tolerance})
    return _checked_bodies({mill.name: mill})[mill.name]


_checked_bodies, _capacity, _make_swing = preflight.checked_bodies, preflight.capacity, calibration.make_swing
_check_tables = preflight.check_tables


def remember_shapes() -> None:
    """Build every shape once: most changes leave the mills as they are."""
    known: dict = {}

    def capacity(vessel, diameter, **options):
        key = (id(vessel), diameter)
        if key not in known:
            known[key] = vessel, _capacity(vessel, diameter, trials=2, **options)
        return known[key][1]

    def make_swing(mill, contact, fraction, diameter, settings):
        key = (mill.model_dump_json(), contact.model_dump_json(), fraction, diameter, settings.model_dump_json())
        if key not in known:
            try:
                known[key] = _make_swing(mill, contact, fraction, diameter, settings)
            except ConfigError as error:
                known[key] = error
        if isinstance(known[key], ConfigError):
            raise known[key]
        return known[key]

    def check_tables(config, source):
        key = (config.model_dump_json(), *(table.read_bytes() for table in sorted(Path("config/data").iterdir())))
        if key not in known:
            _check_tables(config, source)
            known[key] = True

    calibration.make_swing, preflight.check_tables = make_swing, check_tables
    preflight.checked_bodies = lambda mills: {
        name: _bodies_of(mill.model_dump_json(), mill.volume_tolerance) for name, mill in mills.items()
    }
    preflight.capacity = capacity


def plan() -> None:
    """What the Snakefile does before the first job. Raises ConfigError."""
    loaded = load_workflow(read_yaml(CONFIG), [CONFIG])
    preflight.check_before_running(*loaded, CONFIG)


class Late(BaseException):
    """Raised in the middle of a check that takes too long; no `except Exception` takes it for bad input."""


def _late(number, frame):
    raise Late(f"takes more than {SECONDS:g} s")


def judge(name: str) -> str:
    """`valid`, `refused`, or what is wrong, for a project in which `name` was damaged."""
    signal.signal(signal.SIGPROF, _late)
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
    """Damage one file at a time, `count` times, in a project made in `folder`."""
    project, outcome, rng = make_project(folder), Outcome(), random.Random(seed)
    # Mills, contact sets and the configuration get as many changes as all tables together.
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
            found = judge(file.name)
            outcome.slowest_s = max(outcome.slowest_s, time.process_time() - begin)
            file.write_text(whole)
            outcome.kinds[found if found in ("valid", "refused") else "fault"] += 1
            if found not in ("valid", "refused"):
                outcome.faults.append(f"change {number} of {file.name}, seed {seed}:\n{damage[:400]}\n{found}")
                (folder / f"fault_{seed}_{number}_{file.name}").write_text(damage, errors="surrogatepass")
    return outcome


def limit_memory() -> None:
    """A change that asks for absurd memory ends in MemoryError, a fault, and not in a machine that swaps."""
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY_BYTES, resource.RLIM_INFINITY))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=1000, help="damaged files")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", default="", help="part of the path of the files to damage, such as mills/ or .tsv")
    parser.add_argument("--keep", type=Path, help="folder for the project and each file that made a fault")
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
