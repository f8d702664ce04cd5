"""One case from its description to its files."""

import logging
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.advance import use_threads
from millprint.dem.collisions import collision_table
from millprint.dem.laws.registry import law_of
from millprint.dem.ledger import OpenBalanceError, ledger_series
from millprint.dem.recording import Recording
from millprint.dem.simulation import Simulation
from millprint.dem.store import write_run
from millprint.dem.summary import described, is_certain, summarise
from millprint.dem.turns import scale_of_hits
from millprint.run.files import write_json

logger = logging.getLogger("millprint")

# The restart file of an unfinished case.
RESTART = "restart.h5"
# How often a step is shortened until the energy balance closes, and to what part of the first one at least.
SHORTENED, SHORTEST = 2, 0.4


def _enough(simulation: Simulation) -> Callable[[Recording], bool] | None:
    """A function that tells whether a window gives the powers accurately enough; None if any window does."""
    largest, samples = simulation.case.power_error_max, simulation.dem.ledger_samples_per_revolution
    if not largest:
        return None
    scale_J = scale_of_hits(described(simulation))
    return lambda recording: is_certain(ledger_series(np.concatenate(recording.samples)), samples, largest, scale_J)


def balls_in_words(counts: Sequence[int], sizes_m: Sequence[float]) -> str:
    """The charge for a log: "285 balls: 43 of 36.83 mm, ...", or "80 balls of 10 mm"."""
    if len(sizes_m) == 1:
        return f"{counts[0]} balls of {1e3 * sizes_m[0]:g} mm"
    parts = (f"{count} of {1e3 * size:g} mm" for count, size in zip(counts, sizes_m, strict=True))
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
    finite, a step that is too long for the law, or an energy balance that does not close, see `_closing`; nothing is
    written then.
    """
    restart = Path(run_path).with_name(RESTART)

    def recorded(simulation: Simulation) -> Recording:
        logger.info(
            "%s, step %.4g s (%.3g of %s), %d facets",
            balls_in_words(simulation.ball_counts, case.sizes_m),
            simulation.step,
            simulation.step / simulation.step_scale_s,
            law_of(simulation.contact).scale_title,
            sum(len(body.vessel.normals) for body in simulation.bodies),
        )
        with use_threads(cores) if simulation.threads > 1 else nullcontext():
            return simulation.run(case.path, restart, _enough(simulation))

    simulation, recording, series, table, summary = _closing(case, mill, contact, dem, recorded)
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
    return _closing(case, mill, contact, dem, lambda simulation: simulation.run(title, enough=_enough(simulation)))[-1]


def _closing(
    case: Case, mill: MillConfig, contact: ContactConfig, dem: DemConfig, recorded: Callable[[Simulation], Recording]
) -> tuple[Simulation, Recording, pd.DataFrame, pd.DataFrame, dict]:
    """A simulation whose energy balance closes, its recording, ledger, collisions and summary; recorded: runs it.

    A step that is given as a fraction of the law's scale is what suits most mills: where the balance does not close
    with it, and a shorter one helps, that is taken, SHORTENED times and to SHORTEST of the first. The case of the
    summary and of run.h5 has the fraction that was taken. A step that is given in seconds stays. Raises SimulationError
    as `run_case`.
    """
    first = case.rayleigh_fraction or 0.0
    for attempt in range(SHORTENED + 1):
        simulation = Simulation(case, mill, contact, dem)
        recording = recorded(simulation)
        series = ledger_series(np.concatenate(recording.samples))
        table = collision_table(recording.table)
        try:
            return simulation, recording, series, table, summarise(simulation, series, table, recording)
        except OpenBalanceError as error:
            shorter = (case.rayleigh_fraction or 0.0) * error.step_factor
            if attempt == SHORTENED or not shorter > SHORTEST * first:
                raise
            logger.warning("%s; again with rayleigh_fraction %.2g", error, shorter)
            case = case.model_copy(update={"rayleigh_fraction": shorter})
    raise AssertionError("the last attempt returns or raises")
