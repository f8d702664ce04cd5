"""The process environment that every job inherits."""

import os
import sys
from pathlib import Path

# Numba is not among them: its loops take threads only where a simulation is given some (millprint.dem.threads), and it
# can never be given more than it began with.
THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def prepare_environment() -> None:
    """One thread a job for numerical libraries, and this Python's own programs first on the path.

    Snakemake runs one simulation or fit a core, so a library that starts threads of its own slows all of them; a
    script that is given threads asks for them itself. The path lets the report's job find the running Snakemake
    also where its environment is not activated.
    """
    for variable in THREAD_VARIABLES:
        os.environ.setdefault(variable, "1")
    # Threads that wait without spinning: beside another job, spinning doubles the time of a training step.
    os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
    os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
