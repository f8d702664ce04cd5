"""Trains the ensemble of the contact surrogate, and goes on from its last checkpoint if it was killed."""

from pathlib import Path

from millprint.config.contact import ContactConfig
from millprint.config.contact_surrogate import ContactSurrogateConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import DemConfig
from millprint.files import write_table
from millprint.job import job
from millprint.surrogate.contact.dataset import open_tracer, read_dataset
from millprint.surrogate.contact.ensemble import recipe_of, train_ensemble
from millprint.surrogate.contact.store import write_ensemble
from millprint.surrogate.device import choose_device


def main(
    dataset: str,
    weights: str,
    history: str,
    settings: ContactSurrogateConfig,
    mills: dict[str, MillConfig],
    contacts: dict[str, ContactConfig],
    dem: DemConfig,
    threads: int,
) -> None:
    device = choose_device(threads)
    parts, truths = read_dataset(dataset)
    interval_s = settings.judge.position_s
    tracers = [
        open_tracer(trace, mills[trace.mill], contacts[trace.contact], dem, settings.coarse, interval_s)
        for trace in settings.traces
    ]
    # Beside the outputs and none of them: Snakemake removes the outputs of a job that was killed.
    checkpoint = Path(weights).with_suffix(".checkpoint.pt")
    members, table = train_ensemble(parts, truths, tracers, settings, checkpoint, device)
    write_table(table, history)
    write_ensemble(weights, members, recipe_of(settings))
    for number in range(settings.members):
        checkpoint.with_suffix(f".{number}.pt").unlink(missing_ok=True)


if "snakemake" in globals():
    with job(snakemake.log[0], f"train the surrogate {snakemake.wildcards.variant}"):
        main(
            snakemake.input.dataset,
            snakemake.output.weights,
            snakemake.output.history,
            ContactSurrogateConfig(**snakemake.params.settings),
            {name: MillConfig(**mill) for name, mill in snakemake.params.mills.items()},
            {name: ContactConfig(**contact) for name, contact in snakemake.params.contacts.items()},
            DemConfig(**snakemake.params.dem),
            threads=snakemake.threads,
        )
