"""The progress of a job: a bar in a terminal, and plain lines in a file, where bars of parallel jobs collide."""

import sys
from contextvars import ContextVar
from typing import Any

from tqdm import tqdm

from millprint.run.plan import duration

# Time between lines [s], and time before the first line, so that a short job writes none [s].
EVERY_S, FIRST_S = 30.0, 10.0


# The title of the running job, for progress without another name.
job_title = ContextVar("job_title", default="working")


class Lines(tqdm):
    """Progress as single lines: the work, how much of it is done, and the remaining time."""

    _said_s = float("-inf")
    _shown = False

    def display(self, msg: str | None = None, pos: int | None = None) -> bool:
        """Write a line, unless the last line is younger than EVERY_S. A message, which clears a bar, is left out."""
        now = self._time()
        if msg is not None or now - self._said_s < EVERY_S:
            return False
        self._say(now)
        return True

    def __exit__(self, kind: Any, value: Any, traceback: Any) -> None:
        """Write no last line after a failure, because it would say that everything is done."""
        self._shown = self._shown and kind is None
        super().__exit__(kind, value, traceback)

    def close(self) -> None:
        """Write a last line if there was one before."""
        shown = self._shown and not self.disable
        self.leave = False
        super().close()
        if shown:
            self._say(self._time(), ended=True)

    def _say(self, now: float, ended: bool = False) -> None:
        self._said_s, self._shown = now, True
        # One call, so that lines of parallel jobs do not mix.
        self.fp.write(f"{progress_line(self.format_dict, ended)}\n")
        self.fp.flush()


def progress_line(state: dict[str, Any], ended: bool) -> str:
    """One line of progress. state: as tqdm's `format_dict`."""
    scale = 1 if isinstance(state["unit_scale"], bool) else state["unit_scale"]
    unit, done, total, elapsed = state["unit"].strip(), state["n"], state["total"], state["elapsed"]
    units = unit if unit.endswith("s") or " " in unit else f"{unit}s"
    reached = _number(done * scale)
    amount = f"{reached} {units}" if total is None else f"{reached} of {_number(total * scale)} {units}"
    text = f"{state['prefix']}: {amount}, {duration(elapsed)} so far"
    if state["postfix"]:
        text += f", {state['postfix']}"
    if ended:
        return f"{text}; done"
    # The rate of the last steps, or of all. Before the first step of this process there is none.
    rate = state["rate"] or ((done - state["initial"]) / elapsed if elapsed else 0.0)
    return text if total is None or not rate else f"{text}; about {duration((total - done) / rate)} to go"


def _number(value: float) -> str:
    return str(value) if isinstance(value, int) else f"{value:.2f}"


def progress(total: float | None, what: str | None, unit: str = "it", **options: Any) -> tqdm:
    """A progress bar with the remaining time in a terminal; lines if the output is a file or CI.

    what: the work; None for the title of the job. unit: what is counted, in the singular.
    """
    name = job_title.get() if what is None else what
    if sys.stderr.isatty():
        terminal = {"mininterval": 0.5, "dynamic_ncols": True, "leave": False}
        return tqdm(total=total, desc=name, unit=unit, file=sys.stderr, **terminal, **options)
    lines = {"mininterval": 1.0, "maxinterval": EVERY_S, "delay": FIRST_S}
    return Lines(total=total, desc=name, unit=unit, file=sys.stderr, **lines, **options)
