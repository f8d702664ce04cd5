"""Compiles every kernel by running a tiny case that records everything; with two cores, in two processes.

Three quarters of the time are the step loop's, whose two longest parts are compiled side by side. Each process finds in
numba's cache what the other one has compiled.
"""

import gc
import inspect
import platform
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import llvmlite
import numba
import numpy as np
from numba.core import event
from numba.core.dispatcher import Dispatcher
from tqdm import tqdm

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import SimulationError
from millprint.config.mill import MillConfig, PostGeometry, StadiumGeometry
from millprint.config.motion_kinds import CircleMotion
from millprint.config.sweep import Case, DemConfig, ball_count
from millprint.dem.advance import apply_forces, can_step
from millprint.dem.laws.registry import mark_of
from millprint.dem.recording import count_occupancy, end_window, make_table, record, silent_recorder
from millprint.dem.run import simulate
from millprint.dem.simulation import Simulation
from millprint.run.job import progress
from millprint.run.kernel import drop_old_caches, kernel_digest, processor_type

TINY_MILL = MillConfig(
    name="tiny",
    title="a small jar with a post",
    source="made for compiling",
    volume_ml=10,
    geometry=StadiumGeometry(
        kind="stadium",
        end_radius_mm=12,
        straight_mm=10,
        height_mm=15,
        facets_per_half_circle=4,
        fillet_radius_mm=2,
        fillet_facets=1,
        post=PostGeometry(radius_mm=2, facets=4),
    ),
    motion=CircleMotion(kind="circle", amplitude_mm=10),
)
TINY_CONTACT = ContactConfig(
    name="tiny",
    source="made for compiling",
    restitution=0.5,
    static_friction=0.3,
    rolling_friction=0.01,
    density_kg_m3=7700,
    young_modulus_gpa=2,
    poisson_ratio=0.3,
)
TINY_CASE = Case(
    mill="tiny",
    contact="tiny",
    ball_diameter_m=0.003,
    fill_ratio=0.01,
    speed_hz=20.0,
    seed=0,
    settle_s=1e-3,
    discard_s=0,
    window_s=0.05,
    snapshot_interval_s=1e-3,
)
TINY_DEM = DemConfig(time_step_s=2e-6)

# The parts of a simulation that each of two processes compiles, the longest first.
FORCES, OTHERS = (apply_forces,), (can_step, record, count_occupancy, end_window)

# Objects that numba makes between two looks for garbage; with Python's 700, the looks take a tenth of the time.
SELDOM = 100_000


class CompiledKernels(event.Listener):
    """Advances a progress bar to the number of kernels that the cache has got, whichever process has compiled them."""

    def __init__(self, bar: tqdm) -> None:
        self._bar, self._before = bar, compiled_kernels()

    def on_start(self, event: event.Event) -> None:
        """Show nothing: a kernel that calls others ends after them."""

    def on_end(self, event: event.Event) -> None:
        """Look into the cache."""
        self._bar.update(compiled_kernels() - self._before - self._bar.n)


def own_kernels() -> set[Dispatcher]:
    """Kernels of the modules that a simulation imports; some are for threads or other jars, and are not compiled."""
    modules = [module for name, module in sys.modules.items() if name.startswith(("millprint.dem.", "millprint.mill."))]
    kernels = {value for module in modules for value in vars(module).values() if isinstance(value, Dispatcher)}
    return {each for each in kernels if each.targetoptions.get("inline") != "always"}


def compiled_kernels() -> int:
    """How many kernels are in the cache."""
    folders = {Path(path) for each in own_kernels() if (path := each.stats.cache_path)}
    return len([file for folder in folders for file in folder.glob("*.nbi")])


@contextmanager
def seldom_collected() -> Iterator[None]:
    """Look for garbage seldom."""
    before = gc.get_threshold()
    gc.set_threshold(SELDOM, *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)


def run_tiny_case() -> None:
    """Simulate a case that calls most kernels. Raises RuntimeError where its energy balance does not close."""
    try:
        simulate(TINY_CASE, TINY_MILL, TINY_CONTACT, TINY_DEM)
        # Without snapshots, the step changes where the window begins.
        simulate(TINY_CASE.model_copy(update={"snapshot_interval_s": None}), TINY_MILL, TINY_CONTACT, TINY_DEM)
    except SimulationError as error:
        raise RuntimeError(f"the compiled kernels do not work on this machine: {error}") from None


def compile_parts(parts: tuple[Dispatcher, ...], simulation: Simulation) -> None:
    """Compile parts of a simulation, whose objects have the names of the parts' parameters."""
    others = {
        "mark": mark_of(simulation.contact), "table": make_table(0), "recorder": silent_recorder(),
        "time": 0.0, "since": 0,
    }  # fmt: skip
    objects = {**vars(simulation), **others}
    for part in parts:
        names = inspect.signature(part.py_func).parameters
        part.compile(tuple(numba.typeof(objects[name]) for name in names))


def compile_others() -> None:
    """What the second process does, with balls that need not be packed first."""
    count = ball_count(TINY_CASE.fill_ratio, TINY_MILL.volume_ml / 1e6, TINY_CASE.ball_diameter_m)
    with seldom_collected():
        simulation = Simulation(TINY_CASE, TINY_MILL, TINY_CONTACT, TINY_DEM, start=np.zeros((count, 3)))
        compile_parts(OTHERS, simulation)


def compile_in_two() -> None:
    """Compile the forces, while a second process compiles the other parts."""
    with subprocess.Popen(
        [sys.executable, "-P", "-m", "millprint.dem.compilation"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as second:
        try:
            compile_parts(FORCES, Simulation(TINY_CASE, TINY_MILL, TINY_CONTACT, TINY_DEM))
        except BaseException:
            second.kill()
            raise


def compile_kernels(cores: int = 1) -> dict:
    """Compile what is not in the cache yet; returns seconds, versions, processor and the digest of the kernels' source.

    With more than one core, a first compilation is shared by two processes. Not the step loop with threads, which takes
    as long again: the few simulations that have threads compile it.
    """
    drop_old_caches()
    begin = time.perf_counter()
    with (
        progress(len(own_kernels()), "compiling the kernels", "kernel") as bar,
        event.install_listener("numba:compile", CompiledKernels(bar)),
        seldom_collected(),
    ):
        if cores > 1 and not compiled_kernels():
            compile_in_two()
        run_tiny_case()
        bar.total = bar.n
    return {
        "seconds": time.perf_counter() - begin,
        "digest": kernel_digest(),
        "processor": processor_type(),
        "versions": {
            "numba": numba.__version__,
            "llvmlite": llvmlite.__version__,
            "numpy": np.__version__,
            "python": platform.python_version(),
        },
    }


if __name__ == "__main__":
    compile_others()
