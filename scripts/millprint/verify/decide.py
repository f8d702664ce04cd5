"""Asks what to do with damaged files, since a file that was edited on purpose looks like a damaged one."""

import shlex
import sys
from collections.abc import Sequence

from millprint.records import Damage, keep
from millprint.verify.repair import jobs_of, make_again
from millprint.verify.runner import Snakemake, say

MAKE_AGAIN, KEEP, STOP = "make again", "keep", "stop"


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
    for own, wanted in zip(jobs, chosen, strict=True):
        if wanted == MAKE_AGAIN:
            again.append(own)
        elif wanted == KEEP:
            for damage in own:
                keep(damage)
                say(f"kept: {damage.path}")
        else:
            raise ValueError(f"{wanted}: {MAKE_AGAIN}, {KEEP} or {STOP}")
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
