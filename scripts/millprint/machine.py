"""Environment variables that every job inherits."""

import os
from pathlib import Path

# Numba is not among them: its loops take threads only where a simulation is given some (millprint.dem.threads), and it
# can never be given more than it began with.
THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def prepare_environment() -> None:
    """Set one thread per job for numerical libraries, and put this library first on the path of the jobs.

    Snakemake runs one simulation or fit a core, so a library that starts threads of its own slows all of them; a
    script that is given threads asks for them itself. Where another copy of the library is installed too, jobs must
    take the one that the Snakefile was read with.
    """
    for variable in THREAD_VARIABLES:
        os.environ.setdefault(variable, "1")
    # Waiting threads must not spin: next to another job, spinning doubles the time of a training step.
    os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
    folder = Path(__file__).parents[1]
    if folder.name != "site-packages":
        os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [str(folder), os.environ.get("PYTHONPATH")]))
