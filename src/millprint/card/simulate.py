"""Simulates the cases of one experiment in parallel, and draws the cases with snapshots.

Finished cases are kept, so that a killed call continues.
"""

import hashlib
import json
import os
import threading
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context, parent_process
from pathlib import Path

from millprint.card.experiment_cases import ANIMATION
from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig, overridden
from millprint.dem.run import run_case
from millprint.run.files import write_json
from millprint.run.kernel import kernel_digest
from millprint.run.progress import progress
from millprint.view.frames import read_movie

# Next to run.h5: a digest of everything that decides its content.
IDENTITY = "identity.json"
GIF = "mill.gif"


def identity_of(case: Case, mill: MillConfig, contact: ContactConfig, dem: DemConfig) -> str:
    """A digest of a case, its mill and contact set, the settings, and the code of the simulation."""
    parts = [part.model_dump_json() for part in (case, mill, contact, dem)]
    return hashlib.sha256(json.dumps([*parts, kernel_digest()]).encode()).hexdigest()


def end_with_parent() -> None:
    """End this process of a pool as soon as its parent has ended, even if the parent was killed."""
    parent = parent_process()

    def watch() -> None:
        if parent:
            parent.join()
            # Not sys.exit, which would only end this thread.
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def is_done(folder: Path, identity: str) -> bool:
    """Whether a folder holds the finished simulation of this identity."""
    try:
        known = json.loads((folder / IDENTITY).read_text())
    except (OSError, ValueError):
        return False
    return known == {"identity": identity} and all((folder / name).is_file() for name in ("run.h5", "summary.json"))


def draw_run(run: Path, gif: Path) -> None:
    """Draw the animation of a run with snapshots."""
    # Imported here: slow to import, and only one process needs it.
    from millprint.figures.animation import save_animation

    save_animation(read_movie(run, ANIMATION), gif)


def _simulate(case: Case, mill: MillConfig, contact: ContactConfig, dem: DemConfig, folder: Path) -> None:
    """Simulate one case, in a separate process or the caller's; with snapshots, also draw its animation, GIF."""
    (folder / IDENTITY).unlink(missing_ok=True)
    run_case(case, *overridden(case, mill, contact), dem, folder / "run.h5", folder / "summary.json")
    if case.snapshot_interval_s:
        draw_run(folder / "run.h5", folder / GIF)
    write_json({"identity": identity_of(case, mill, contact, dem)}, folder / IDENTITY)


def simulate_cases(
    cases: Mapping[Path, Case], mill: MillConfig, contact: ContactConfig, dem: DemConfig, cores: int
) -> int:
    """Simulate each case into its folder, several at a time, unless it is done; returns how many were done.

    The processes end with this one. A stopped case continues from its restart file. Raises SimulationError.
    """
    waiting = {
        folder: case for folder, case in cases.items() if not is_done(folder, identity_of(case, mill, contact, dem))
    }
    for folder in waiting:
        folder.mkdir(parents=True, exist_ok=True)
    with progress(len(cases), "simulating", "simulation") as bar:
        bar.update(len(cases) - len(waiting))
        if cores == 1 or len(waiting) <= 1:
            for folder, case in waiting.items():
                _simulate(case, mill, contact, dem, folder)
                bar.update()
            return len(cases) - len(waiting)
        # Spawned, not forked: a copy of this process would have its threads.
        with ProcessPoolExecutor(cores, mp_context=get_context("spawn"), initializer=end_with_parent) as pool:
            tasks = [pool.submit(_simulate, case, mill, contact, dem, folder) for folder, case in waiting.items()]
            for task in as_completed(tasks):
                task.result()
                bar.update()
    return len(cases) - len(waiting)
