"""Three lines at the end of a run for each of its targets. The Snakefile imports this, so no heavy imports here."""

import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from millprint.run.outputs import listed_targets

# With more targets than this, the lines would not be a summary.
SHOWN = 4


@dataclass(frozen=True)
class Ending:
    """What a target has made, the file to look at first and what it shows, and what to do next."""

    made: str
    look: str
    shows: str
    next: str

    def lines(self, values: Mapping[str, str]) -> list[str]:
        """The three lines, with names of folders and mill in place of their keys."""
        return [
            f"made:  {self.made}".format(**values),
            f"look:  {self.look}: {self.shows}".format(**values),
            f"next:  {self.next}".format(**values),
        ]


@cache
def endings() -> dict[str, Ending]:
    """Every target with its texts."""
    return {name: Ending(**texts) for name, texts in listed_targets().items()}


def given_run(files: Sequence[Path], settings: Mapping[str, object]) -> str:
    """The word after the target in a command that goes on with the same mill, with a blank before it; or nothing.

    files, settings: of --configfile and --config.
    """
    mill = files[-1] if files else settings.get("mill", "")
    return f" {shlex.quote(str(mill))}" if mill else ""


def success_lines(targets: Iterable[str], chapters: bool, values: Mapping[str, str]) -> list[str]:
    """The lines for the targets of a successful run.

    targets: names of rules or files; without any, and for `everything`, the lines of the whole run: of the chapters or,
    in a run without them, of a fingerprint. values: results, mill, contact and given (`given_run`). Other names, as of
    rules of a workflow that uses this one as a module, are left out.
    """
    whole = "all" if chapters else "fingerprint"
    named = [whole if name in ("all", "everything") else name for name in targets] or [whole]
    known = list(dict.fromkeys(name for name in named if name in endings()))
    lines = [line for name in known[:SHOWN] for line in ["", *endings()[name].lines(values)]]
    files = [name for name in named if name not in endings() and Path(name).exists()]
    if files:
        more = f" and {len(files) - 1} more" if len(files) > 1 else ""
        lines += ["", f"made:  {files[0]}{more}", f"look:  {values['results']}/logs has the log of every job"]
        lines += ["next:  millprint plan says what the whole run would make, and how long it takes"]
    return lines
