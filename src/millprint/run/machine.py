"""The machine: environment variables that every job inherits, and the provenance of a run."""

import os
import platform
import subprocess
from importlib.metadata import distributions, version
from pathlib import Path

from platformdirs import user_cache_path

from millprint import JOB_VARIABLE

# Numba is not among them: its loops use threads only if a simulation asks for them (millprint.dem.advance), and never
# more than at its start.
THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
# How OpenMP threads wait for each other; read when they start.
WAIT_POLICY = "OMP_WAIT_POLICY"

# The packages that results depend on.
PACKAGES = ("snakemake", "numpy", "numba", "scipy", "pandas", "statsmodels", "scikit-learn", "torch", "torch-geometric")


def prepare_environment() -> None:
    """Set one thread per job for numerical libraries, and put this library first on the path of the jobs.

    Snakemake runs one simulation or fit per core, so a library that starts more threads slows all of them; a script
    that gets threads asks for them itself. If another copy of this library is installed too, jobs must use the one that
    read the Snakefile.
    """
    os.environ[JOB_VARIABLE] = "1"
    for variable in THREAD_VARIABLES:
        os.environ.setdefault(variable, "1")
    # Waiting threads must not spin: next to another job, spinning doubles the time of a training step.
    os.environ.setdefault(WAIT_POLICY, "PASSIVE")
    folder = Path(__file__).parents[2]
    if folder.name != "site-packages":
        os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [str(folder), os.environ.get("PYTHONPATH")]))


def package_versions() -> dict[str, str]:
    """Versions of the packages that results depend on, by name; those of extras that are installed."""
    return {name: version(name) for name in PACKAGES if any(distributions(name=name))}


def commit(folder: str | Path = Path(__file__).parent) -> str:
    """The commit of a working tree, by default the library's, marked `with changes` if files differ from it.

    `unknown` outside a repository, as for an installed library.
    """
    command = ["git", "-C", str(folder), "describe", "--always", "--dirty= with changes", "--abbrev=40", "--exclude=*"]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def cores() -> int:
    """Processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def provenance() -> dict[str, str]:
    """Commit, machine and versions as text, by name."""
    return {
        "commit": commit(),
        "Python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}, {cores()} cores",
        **package_versions(),
    }


PACKAGE = Path(__file__).parents[1]


def cache_root() -> Path:
    """The folder of the cache: in a checkout of the project, or in the user's cache for an installed library."""
    project = PACKAGE.parents[1]
    if (project / "pyproject.toml").is_file() and os.access(project, os.W_OK):
        return project / ".numba_cache"
    return user_cache()


def user_cache() -> Path:
    """The user's cache; where that cannot be written, one in the working folder, for Snakemake and every job too."""
    folder = user_cache_path("millprint", appauthor=False)
    nearest = next(each for each in (folder, *folder.parents) if each.is_dir())
    if os.access(nearest, os.W_OK):
        return folder
    os.environ["XDG_CACHE_HOME"] = str(Path(".snakemake/cache").absolute())
    return user_cache_path("millprint", appauthor=False)


CACHE_ROOT = cache_root()
