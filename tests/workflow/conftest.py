"""Shared by the workflow tests: a copy of the project to run in, Snakemake, its output, and one smoke run."""

import os
import re
import shutil
import subprocess
import sys
from functools import cache
from importlib.util import cache_from_source
from pathlib import Path

import pytest
import yaml
from numba.core.caching import UserProvidedCacheLocator

from millprint.checks.before_running import check_before_running
from millprint.checks.check_once import PASSED
from millprint.config.checks import load_workflow
from millprint.config.errors import ConfigError
from millprint.config.load import read_yaml
from millprint.run import kernel
from millprint.thesis.chapter_checks import chapter_faults
from tests.conftest import ROOT
from tests.mutations import DUMPER
from tests.remembered import SLOW_PARTS
from tests.workflow import drawn_mill, warm_snakemake

CONFIG = "config/config.yaml"

# The options of `make smoke` and `make thesis` for the report.
REPORT = (
    *("--report", "results/report/report.html", "--report-after-run"),
    *("--report-stylesheet", "workflow/report/report.css"),
)


def active_environment() -> dict[str, str]:
    """The variables of this process, with the programs of its virtual environment first on the PATH."""
    return {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}


def copy_project(folder: Path, *parts: str) -> Path:
    """Copy the working tree to `folder` as a clean clone: every file that git tracks or would track.

    parts: the folders to copy; all if left out.

    Modules come with what Python made of them, which it takes where their dates and sizes are those of the source.
    """
    for name in files_of(parts):
        source, target = ROOT / name, folder / name
        if source.is_file():
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(source, target)
            if source.suffix == ".py":
                copy_compiled(source, target)
    return folder


@cache
def files_of(parts: tuple[str, ...]) -> list[str]:
    """The files of the working tree, or of some folders, that git tracks or would track."""
    listing = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard", "--", *parts],
        cwd=ROOT,
        capture_output=True,
        check=True,
        text=True,
    )
    return [name for name in listing.stdout.split("\0") if name]


def copy_compiled(source: Path, target: Path) -> None:
    """Copy the bytecode of a module, if there is any, to that of its copy."""
    own, its = (Path(cache_from_source(str(path))) for path in (source, target))
    if own.is_file():
        its.parent.mkdir(exist_ok=True)
        shutil.copy2(own, its)


def share_kernels(project: Path) -> None:
    """Let a clone take its machine code from this checkout, and leave there what it compiles itself.

    Numba names its folders after the path of the source, and checks by its date and size that the code is that of the
    source. A clone whose kernels are edited has a folder of another name, and compiles.
    """
    own_cache = kernel.cache_folder()
    its_cache = project / ".numba_cache" / own_cache.name
    its_cache.mkdir(parents=True)
    name_of = UserProvidedCacheLocator.get_suitable_cache_subpath
    for folder in {file.parent for file in kernel.kernel_files()}:
        own, its = (name_of(str(place / "any.py")) for place in (folder, project / folder.relative_to(ROOT)))
        (own_cache / own).mkdir(parents=True, exist_ok=True)
        (its_cache / its).symlink_to(own_cache / own)


def share_checks(project: Path) -> None:
    """Let a clone know which configurations have passed the check before a run here, and leave here what passes there.

    What has passed is named after all that the check reads, and after what it computes.
    """
    (ROOT / PASSED).mkdir(parents=True, exist_ok=True)
    (project / PASSED).parent.mkdir(parents=True)
    (project / PASSED).symlink_to(ROOT / PASSED)


def _whole_plan(arguments: tuple[str, ...]) -> list[str]:
    """Arguments with which a dry run names its files too, and not only its rules."""
    return ["--verbose", *arguments] if "-n" in arguments and "--verbose" not in arguments else [*arguments]


def run_snakemake(project: Path, *arguments: str, timeout: float = 120) -> subprocess.CompletedProcess:
    """Run Snakemake on 2 cores in `project`, with both streams in `stdout`."""
    return warm_snakemake.run(
        ["--cores", "2", *_whole_plan(arguments)], project, active_environment(), timeout, one_stream=True
    )


def ask_snakemake(folder: Path, *arguments: str, timeout: float = 180) -> subprocess.CompletedProcess:
    """Run Snakemake in `folder` with these arguments only, not even --cores; its two streams are kept apart."""
    return warm_snakemake.run(_whole_plan(arguments), folder, os.environ, timeout, one_stream=False)


def error_lines(output: str) -> list[str]:
    """The lines of an output that begin with `error: `."""
    return [line for line in output.splitlines() if line.startswith("error: ")]


def jobs_of(output: str) -> dict[str, int]:
    """Number of jobs of each rule, from Snakemake's table of jobs."""
    return {rule: int(count) for rule, count in re.findall(r"^(\w+) +(\d+)$", output, re.MULTILINE) if rule != "total"}


def edit_yaml(path, *place, value):
    """Set a value in a YAML file; `place` is the path to it, of keys and list positions."""
    content = read_yaml(path)
    inner = content
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = value
    path.write_text(yaml.dump(content, Dumper=DUMPER))


def copy_planetary(mills: Path) -> None:
    """Copy the planetary mill to `mills`/mine.yaml, as the handbook tells users to."""
    text = (ROOT / "config/mills/planetary.yaml").read_text()
    (mills / "mine.yaml").write_text(text.replace("name: planetary", "name: mine"))


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A clean copy with the kernels of this checkout, and the checks that have passed in it."""
    folder = copy_project(tmp_path / "millprint")
    share_kernels(folder)
    share_checks(folder)
    return folder


@pytest.fixture
def settings(tmp_path: Path) -> Path:
    """A folder with only the configuration, which is all that the check before a run reads."""
    return copy_project(tmp_path / "millprint", "config", "results")


@pytest.fixture
def check(settings, monkeypatch):
    """A function that checks the settings as a run does, and returns its warnings. Raises ConfigError."""
    monkeypatch.chdir(settings)
    for place, quick in SLOW_PARTS.items():
        monkeypatch.setattr(place, quick)

    def checked() -> list[str]:
        return check_before_running(*load_workflow(read_yaml(settings / CONFIG), [CONFIG]), CONFIG, chapter_faults)

    return checked


@pytest.fixture
def refusal(check):
    """A function that checks the settings and returns the one line that refuses them; none or several are a failure."""

    def read_line() -> str:
        with pytest.raises(ConfigError) as caught:
            check()
        (line,) = str(caught.value).splitlines()
        return line

    return read_line


@pytest.fixture(scope="session")
def smoke_project(tmp_path_factory) -> Path:
    """A clean copy in which the smoke workflow has run from nothing but kernels."""
    folder = copy_project(tmp_path_factory.mktemp("smoke") / "millprint")
    share_kernels(folder)
    share_checks(folder)
    done = run_snakemake(folder, "--configfile", "config/smoke.yaml", *REPORT, timeout=1200)
    assert done.returncode == 0, done.stdout[-6000:]
    return folder


# A drum with lifters and a lining of its own friction, with a charge of three sizes, and balls of one size.
LINED = {
    "name": "lined",
    "title": "Drum with lifters and a rubber lining",
    "source": "made for a test",
    "volume_ml": 148.0,
    "geometry": {
        "kind": "lifter_drum",
        "axis": "y",
        "radius_mm": 50,
        "length_mm": 20,
        "lifters": {"number": 4, "height_mm": 8, "width_mm": 14, "face_angle_deg": 70},
        "smooth_ends": True,
    },
    "motion": {"kind": "rotation", "axis": [0, 1, 0]},
    "sweep": {
        "speeds_rpm": [90],
        "ball_diameters_mm": [{"name": "graded", "sizes_mm": [13, 11, 9], "shares": [0.3, 0.3, 0.4]}, 11],
        "fill_ratios": [0.12, 0.17, 0.24],
        "discard_turns": 1,
        "window_turns": 2,
    },
}
MATCH = {
    "mill": "lined",
    "like": {"mill": "lined", "speed_rpm": 90, "ball_diameter_mm": "graded", "fill_ratio": 0.17},
    "speeds_rpm": [90, 90],
    "ball_diameters_mm": [11, "graded"],
}
LINED_SETTINGS = ("--configfile", "lined.yaml")
LINED_CONFIG = {
    "mill": "lined",
    "dem": {"settle_s": 0.1, "discard_turns": 1, "window_s": 0.2},
    "mills": {
        "contact": "lined", "rayleigh_fraction": 0.1, "held_out": 1, "box": ["mine"], "match": MATCH,
        "precision": "standard", "settle_s": 0.1, "first_case_only": True,
    },
    "dose": {"heat": {"samples": 40}},
}  # fmt: skip
LINED_RUN = ("fingerprint", "explorer", "match", *LINED_SETTINGS)


@pytest.fixture(scope="session")
def lined_project(smoke_project) -> Path:
    """The project of the smoke run, with the fingerprint, the explorer and a match of the drum LINED.

    And in the same run with the fingerprint of a drawn mill, since a run of its own would check all input again.
    """
    steel = yaml.safe_load((smoke_project / "config/contacts/steel.yaml").read_text())
    lining = {"name": "lined", "wall_restitution": 0.4, "wall_static_friction": 0.5, "wall_rolling_friction": 0.02}
    (smoke_project / "config/contacts/lined.yaml").write_text(yaml.safe_dump(steel | lining))
    (smoke_project / "config/mills/lined.yaml").write_text(yaml.safe_dump(LINED))
    (smoke_project / LINED_SETTINGS[1]).write_text(yaml.safe_dump(LINED_CONFIG))
    drawn_mill.make(smoke_project)
    done = run_snakemake(smoke_project, *drawn_mill.FILES, *LINED_RUN, timeout=600)
    assert done.returncode == 0, done.stdout[-4000:]
    return smoke_project
