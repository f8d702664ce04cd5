"""One case from its description to its files."""

import logging
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from pathlib import Path

import numpy as np

from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.collisions import collision_table
from millprint.dem.ledger import ledger_series
from millprint.dem.recording import Recording
from millprint.dem.simulation import Simulation
from millprint.dem.store import write_run
from millprint.dem.summary import is_certain, summarise
from millprint.dem.threads import use_threads
from millprint.files import write_json

logger = logging.getLogger("millprint")

# The restart file of an unfinished case.
RESTART = "restart.h5"


def _enough(case: Case, dem: DemConfig) -> Callable[[Recording], bool] | None:
    """A function that tells whether a window gives the powers accurately enough; None if any window does."""
    if not case.power_error_max:
        return None
    samples, largest = dem.ledger_samples_per_revolution, case.power_error_max
    return lambda recording: is_certain(ledger_series(np.concatenate(recording.samples)), samples, largest)


def balls_in_words(counts: Sequence[int], sizes_mm: Sequence[float]) -> str:
    """The charge for a log: "285 balls: 43 of 36.83 mm, ...", or "80 balls of 10 mm"."""
    if len(sizes_mm) == 1:
        return f"{counts[0]} balls of {sizes_mm[0]:g} mm"
    parts = (f"{count} of {size:g} mm" for count, size in zip(counts, sizes_mm, strict=True))
    return f"{sum(counts)} balls: {', '.join(parts)}"


def run_case(
    case: Case,
    mill: MillConfig,
    contact: ContactConfig,
    dem: DemConfig,
    run_path: str | Path,
    summary_path: str | Path,
    cores: int = 1,
) -> dict:
    """Simulate a case, write run.h5 and summary.json, and return the summary.

    cores: how many the case's threads may run on; with fewer than it has threads it is slower, and the same.

    A stopped run continues from its restart file in the folder of run.h5, which is removed at the end.

    Raises SimulationError for balls that do not fit, a ball that escapes or overlaps too much, a number that is not
    finite, a step over the Rayleigh fraction, or an energy balance that does not close; nothing is written then.
    """
    simulation = Simulation(case, mill, contact, dem)
    logger.info(
        "%s, step %.4g s (%.3g of the Rayleigh time), %d facets",
        balls_in_words(simulation.ball_counts, case.sizes_mm),
        simulation.step,
        simulation.step / simulation.rayleigh_s,
        sum(len(body.vessel.facets) for body in simulation.bodies),
    )
    restart = Path(run_path).with_name(RESTART)
    with use_threads(cores) if simulation.threads > 1 else nullcontext():
        recording = simulation.run(case.path, restart, _enough(case, dem))
    series = ledger_series(np.concatenate(recording.samples))
    table = collision_table(recording.table)
    summary = summarise(simulation, series, table, recording.height_m)
    logger.info(
        "simulated in %.1f s (%.1f ns a ball-step); energy balance closes within %.2g of the wall work; %d contacts",
        simulation.wall_clock_s,
        summary["ns_per_ball_step"],
        summary["closure"],
        len(table),
    )
    write_run(run_path, simulation, recording, series, table)
    write_json(summary, summary_path)
    restart.unlink(missing_ok=True)
    return summary


def simulate(case: Case, mill: MillConfig, contact: ContactConfig, dem: DemConfig, title: str | None = None) -> dict:
    """The summary of one case, without any file; title: of a progress bar. Raises SimulationError as `run_case`."""
    simulation = Simulation(case, mill, contact, dem)
    recording = simulation.run(title)
    series = ledger_series(np.concatenate(recording.samples))
    return summarise(simulation, series, collision_table(recording.table), recording.height_m)
