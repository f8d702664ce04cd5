"""Records the contacts of simulations at each coarse step: the training data of the contact surrogate."""

import logging

from millprint.config.contact_surrogate import ContactSurrogateConfig
from millprint.job import job
from millprint.progress import progress
from millprint.surrogate.contact.dataset import TracedModels, follow, open_tracer, truths, write_dataset

logger = logging.getLogger("millprint")


def main(output: str, settings: ContactSurrogateConfig, models: TracedModels) -> None:
    parts, true_states = [], []
    with progress(10 * len(settings.traces), "follow contacts", "part") as bar:
        for number, trace in enumerate(settings.traces):
            tracer = open_tracer(trace, models, settings.coarse, settings.judge.position_s)
            parts.append(follow(tracer, trace, bar))
            logger.info("%s: %d contacts in %d states", trace, len(parts[-1].rows), len(parts[-1].sizes))
            if number == 0:
                # From the same simulation, after the training data.
                true_states = truths(tracer, settings.judge)
    write_dataset(parts, true_states, output)


if "snakemake" in globals():
    with job(snakemake.log[0], "follow contacts for the surrogate"):
        main(
            snakemake.output.dataset,
            ContactSurrogateConfig(**snakemake.params.settings),
            TracedModels(**snakemake.params.models),
        )
