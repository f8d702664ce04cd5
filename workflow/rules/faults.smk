"""What an earlier run left behind that was killed: its locks, its jobs, and files that were damaged since."""

import shutil
import subprocess
import tempfile

import yaml

from millprint.liveness import announce, claim, end_with_run
from millprint.records import damaged_files, put_back_dates, set_aside

# Jobs, and a Snakemake inside a job, end when the run that started them has ended.
end_with_run()


def say(text: str) -> None:
    """A line about what was found, before Snakemake's own."""
    print(f"found: {text}", file=sys.stderr, flush=True)


def make_again(files: list[str]) -> None:
    """Make damaged files again, and nothing that was made from them: bit for bit the same, they are no news to it.

    In a run of its own: within one run, Snakemake would redo everything that follows.
    """
    with tempfile.NamedTemporaryFile("w", suffix=".yaml", dir=".snakemake") as merged:
        yaml.safe_dump(config, merged)
        merged.flush()
        command = [sys.executable, "-m", "snakemake", "--snakefile", str(workflow.main_snakefile)]
        command += ["--configfile", merged.name, "--cores", str(workflow.cores or 1), "--nolock", "--"]
        done = subprocess.run(command + files).returncode
    if done:
        say("not all of them could be made again: see above; what this run needs, it makes itself")


if workflow.is_main_process:
    # No other run is alive that could hold them: locks are those of a killed run.
    if claim(".snakemake/millprint.lock"):
        if list(Path(".snakemake/locks").glob("*.lock")) and not workflow.dryrun:
            say("the locks of a run that was killed; they are removed, and what it had begun is done again")
            shutil.rmtree(".snakemake/locks")
        damages = list(damaged_files(f"{CONFIG.results}/logs"))
        for damage in damages:
            say(f"{damage}; " + ("it would be made again" if workflow.dryrun else "set aside, and made again"))
            if not workflow.dryrun:
                set_aside(damage)
        announce()
        if damages and not workflow.dryrun:
            make_again([damage.path for damage in damages])
            for damage in damages:
                put_back_dates(damage.record)
    announce()
