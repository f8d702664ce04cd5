"""Runs the workflow: the Snakemake command for a mill and some targets, printed before it runs."""

import os
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Sequence
from itertools import chain
from pathlib import Path

from millprint.cli.commands import INTERRUPTED, PIPE
from millprint.config.arguments import values_of
from millprint.config.errors import ConfigError
from millprint.config.load import YAML
from millprint.config.wording import close_to

SHAPES = (".stl", ".ply", ".obj")
# Words of Snakemake that print something to standard output in place of a run: a plan, a list, a graph, a summary.
PRINTS = re.compile(
    r"-[a-zA-Z]*n[a-zA-Z]*|-[lSDhv]|--(dry-?run|list.*|l[tcipu]|(d3)?dag|(rule|file)graph|(detailed-)?summary|lint"
    r"|print-compilation|help|version)"
)
# Python ignores the signal that other programs end by.
ENDS_WITH_READER = (
    "import signal; from snakemake.cli import main; signal.signal(signal.SIGPIPE, signal.SIG_DFL); main()"
)


def settings_of(mill: str) -> list[str]:
    """The words of Snakemake for a mill: its name, its file in config/mills, or a configuration of a run.

    Raises ConfigError, in one line, for anything else.
    """
    from millprint.config.included import included_mills, read_run
    from millprint.config.load import MILL_FOLDER

    if not mill:
        raise ConfigError("an empty word: name a mill or a target, or leave it out")
    if Path(mill).suffix in SHAPES:
        raise ConfigError(f"{mill}: is the shape of a jar; `millprint new stl --set path={mill}` makes a mill of it")
    if Path(mill).suffix not in YAML:
        if Path(f"{mill}.yaml").is_file():
            return settings_of(f"{mill}.yaml")
        if (other := Path(MILL_FOLDER, f"{mill}.yml")).is_file():
            raise ConfigError(f"{other}: runs look for {mill}.yaml; rename it")
        if mill not in included_mills():
            raise ConfigError(
                f"{mill}: unknown mill{close_to(mill, included_mills())}; `millprint new` describes yours"
            )
        return ["--config", f"mill={mill}"]
    content = read_run(mill)
    if "mill" in content:
        return ["--configfile", mill]
    place = Path(MILL_FOLDER) / f"{content.get('name')}.yaml"
    if not place.is_file() or not place.samefile(mill):
        raise ConfigError(f"{mill}: is the file of a mill; put it where runs look for it: {place}")
    return ["--config", f"mill={content['name']}"]


def snakefile_words() -> list[str]:
    """Where the Snakefile is: nothing in a checkout, where Snakemake finds it itself."""
    from millprint.config.included import shipped

    if Path("workflow/Snakefile").is_file() and Path("src/millprint").is_dir():
        return []
    found = shipped("workflow/Snakefile")
    if found is None:
        raise ConfigError("workflow/Snakefile: not in this installation; install millprint from its wheel or a clone")
    # A checkout or folder that lies in the working folder has a shorter name.
    return ["--snakefile", os.path.relpath(found) if Path(found).is_relative_to(Path.cwd()) else found]


def check_settings(words: Sequence[str]) -> None:
    """Refuse a word after --config that is not key=value, in a line; Snakemake ends with a traceback."""
    for word in chain.from_iterable(values_of(words, "--config")):
        if not re.match(r"\w+=", word):
            key, _, value = word.partition("=")
            if sections := re.fullmatch(r"(\w+)\.(\w+)", key):
                raise ConfigError(f"--config: {word!r}: write '{sections[1]}={{{sections[2]}: {value or 'VALUE'}}}'")
            raise ConfigError(f"--config: {word!r}: write {key.strip()}={value.strip() or 'VALUE'}, without blanks")


def run_workflow(words: Sequence[str]) -> int:
    """Print a Snakemake command and run it; returns its exit status."""
    from millprint.run.machine import user_cache

    check_settings(words)
    user_cache()
    words = [*snakefile_words(), *words]
    print(f"snakemake {shlex.join(words)}", file=sys.stderr, flush=True)
    # Whoever reads what is printed may end first, such as `head`: then Snakemake ends too.
    prints = any(PRINTS.fullmatch(word) for word in words)
    program = ["-c", ENDS_WITH_READER] if prints else ["-m", "snakemake"]
    status = run_python([*program, *words])
    return PIPE if status == -signal.SIGPIPE else status


def run_python(words: Sequence[str]) -> int:
    """Run this Python with some arguments, in this terminal; returns its exit status."""
    return waited_for(subprocess.Popen([sys.executable, *words]))


def waited_for(process: subprocess.Popen) -> int:
    """The exit status of a process of this terminal, however often it is interrupted.

    Each interrupt went to that process too: Snakemake then ends its jobs and removes its lock, which takes seconds, and
    says itself what it stopped. `subprocess.run` would kill it after a quarter of a second.
    """
    interrupted = False
    while True:
        try:
            return INTERRUPTED if process.wait() and interrupted else process.returncode
        except KeyboardInterrupt:
            interrupted = True
