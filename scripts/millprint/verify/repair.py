"""Asks what to do with damaged files, since a file that was edited on purpose looks like one, and repairs them."""

import os
import shlex
import shutil
import sys
from collections.abc import Iterable, Sequence
from itertools import groupby
from pathlib import Path

from millprint.records import Damage, is_kept, keep, read_record, replace_entries, set_aside
from millprint.verify.runner import Snakemake, say

MAKE_AGAIN, KEEP, STOP = "make again", "keep", "stop"
BEFORE = ".before"


def mend_files(damages: Sequence[Damage], choice: str | None, snakemake: Snakemake, command: Sequence[str]) -> bool:
    """Make damaged files again or keep them, as the user has chosen or chooses now; True if all are settled.

    choice: MAKE_AGAIN or KEEP for all files; None asks, if there is a terminal. command: how this program was called,
    to print the two possible commands if there is no terminal.
    """
    if choice is None and not sys.stdin.isatty():
        offer(command)
        return False
    jobs = jobs_of(damages)
    chosen = [choice or ask(own) for own in jobs]
    if STOP in chosen:
        say("stopped; nothing was changed")
        return False
    again = []
    for own, what in zip(jobs, chosen, strict=True):
        if what == MAKE_AGAIN:
            again.append(own)
        elif what == KEEP:
            for damage in own:
                keep(damage)
                say(f"kept: {damage.path}")
        else:
            raise ValueError(f"{what}: must be {MAKE_AGAIN}, {KEEP} or {STOP}")
    return make_again(again, snakemake)


def ask(damages: Sequence[Damage]) -> str:
    """Ask the user what to do with the damaged files of one job: MAKE_AGAIN, KEEP or STOP."""
    answers = {"m": MAKE_AGAIN, "k": KEEP, "s": STOP}
    say(" ".join(damage.path for damage in damages))
    while True:
        try:
            answer = input("  [m]ake again and rename the present file to NAME.damaged, [k]eep as it is, [s]top? ")
        except (EOFError, KeyboardInterrupt):
            return STOP
        if answer.strip().lower()[:1] in answers:
            return answers[answer.strip().lower()[:1]]


def offer(command: Sequence[str]) -> None:
    """Print the two possible commands."""
    cut = command.index("--") if "--" in command else len(command)
    repair, kept = (shlex.join([*command[:cut], option, *command[cut:]]) for option in ("--repair", "--keep"))
    say("nothing was changed; choose one of two:")
    say(f"  {repair}  # renames them to NAME.damaged and makes them again")
    say(f"  {kept}  # keeps them as they are and records them as results")


def jobs_of(damages: Iterable[Damage]) -> list[list[Damage]]:
    """Damaged files by job: a job writes all of its files at once, so they share one decision."""

    def record(damage: Damage) -> Path:
        return damage.record

    return [list(own) for _, own in groupby(sorted(damages, key=record), key=record)]


def make_again(jobs: Sequence[Sequence[Damage]], snakemake: Snakemake) -> bool:
    """Rename damaged files and make exactly these again; True if all were made. Other files are restored.

    There is a run of Snakemake for each job, because a single run would also repeat all jobs between two of them, and
    all that follow. If a file is made again bit for bit, the files made from it need no job: Snakemake compares digests
    (max-checksum-file-size in profiles/default/config.yaml).
    """
    repairs, done = [], True
    try:
        # All are renamed before the first is made again, because one may be made from another.
        for own in jobs:
            repairs.append(Repair(own))
        for repair in repairs:
            missing = repair.missing()
            done = (not missing or snakemake.run("--", *missing)) and done
    finally:
        whole = [repair.finish() for repair in repairs]
    return done and all(whole)


class Repair:
    """One job whose damaged files have been renamed, and the data to restore its other files."""

    def __init__(self, damages: Sequence[Damage]) -> None:
        self.record = damages[0].record
        self.entries = read_record(self.record)
        damaged = [damage.path for damage in damages]
        # The job also writes its other files again, and some differ: a summary contains the run time.
        self.others = [name for name in self.entries if name not in damaged and Path(name).is_file()]
        for name in self.others:
            shutil.copy2(name, name + BEFORE)
        self.moved = {name: set_aside(name) for name in damaged}
        for name, aside in self.moved.items():
            say(f"moved: {name} to {aside}")

    def missing(self) -> list[str]:
        """The damaged files that have not been made again."""
        return [name for name in self.moved if not Path(name).exists()]

    def finish(self) -> bool:
        """Restore the undamaged files or, if the job failed, all files; True if it succeeded."""
        lost = self.missing()
        for name in lost:
            os.replace(self.moved[name], name)
            say(f"not made again, see above: {name} is unchanged")
        new = read_record(self.record)
        changed = [name for name in self.moved if new.get(name, {}).get("sha256") != self.entries[name]["sha256"]]
        for name in self.others:
            # Files that belong to others than before are no longer of use, unless the user has kept them.
            if changed and not lost and not is_kept(self.entries[name]):
                os.unlink(name + BEFORE)
            else:
                os.replace(name + BEFORE, name)
                new[name] = self.entries[name]
        # A failed job has removed its record.
        replace_entries(self.record, self.entries if lost else new)
        for name in self.moved:
            if name in lost:
                continue
            if name in changed:
                say(f"made again: {name}, with another content: the next run makes what follows from it")
            else:
                say(f"made again: {name}, bit for bit as it was written")
        return not lost
