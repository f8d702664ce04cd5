"""Compiles every kernel by running a tiny case that records everything."""

import platform
import sys
import time
from types import FunctionType

import llvmlite
import numba
import numpy
from numba.core import event
from numba.core.dispatcher import Dispatcher
from tqdm import tqdm

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import SimulationError
from millprint.config.mill import CircleMotion, MillConfig, PostGeometry, StadiumGeometry
from millprint.config.sweep import Case, DemConfig
from millprint.dem.run import simulate
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


class CompiledKernels(event.Listener):
    """Advances a progress bar for every kernel that numba compiles, at its first signature."""

    def __init__(self, bar: tqdm) -> None:
        self._bar = bar
        self._seen: set[FunctionType] = set()

    def on_start(self, event: event.Event) -> None:
        """Show nothing: a kernel that calls others ends after them."""

    def on_end(self, event: event.Event) -> None:
        """Count a kernel, except for further signatures and for functions of numba itself."""
        function = event.data["dispatcher"].py_func
        if function not in self._seen and function.__module__.startswith("millprint."):
            self._seen.add(function)
            self._bar.update()


def count_kernels() -> int:
    """Kernels of the modules that a simulation on one core imports, most of which it calls."""
    modules = [module for name, module in sys.modules.items() if name.startswith(("millprint.dem.", "millprint.mill."))]
    kernels = {value for module in modules for value in vars(module).values() if isinstance(value, Dispatcher)}
    return sum(kernel.py_func.__module__ != "millprint.dem.advance" for kernel in kernels)


def run_tiny_case() -> None:
    """Simulate a case that calls most kernels. Raises RuntimeError where its energy balance does not close."""
    dem = DemConfig(time_step_s=2e-6)
    case = Case(
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
    try:
        simulate(case, TINY_MILL, TINY_CONTACT, dem)
        # Without snapshots, the step changes where the window begins.
        simulate(case.model_copy(update={"snapshot_interval_s": None}), TINY_MILL, TINY_CONTACT, dem)
    except SimulationError as error:
        raise RuntimeError(f"the compiled kernels do not work on this machine: {error}") from None


def compile_kernels() -> dict:
    """Compile what is not in the cache yet; returns seconds, versions, processor and the digest of the kernels' source.

    Not the step loop with threads, which takes as long again: the few simulations that have threads compile it.
    """
    drop_old_caches()
    begin = time.perf_counter()
    with (
        progress(count_kernels(), "compiling the kernels", "kernel") as bar,
        event.install_listener("numba:compile", CompiledKernels(bar)),
    ):
        run_tiny_case()
        # Some kernels are for other jars, and those of the cache were compiled before.
        bar.update(bar.total - bar.n)
    return {
        "seconds": time.perf_counter() - begin,
        "digest": kernel_digest(),
        "processor": processor_type(),
        "versions": {
            "numba": numba.__version__,
            "llvmlite": llvmlite.__version__,
            "numpy": numpy.__version__,
            "python": platform.python_version(),
        },
    }
