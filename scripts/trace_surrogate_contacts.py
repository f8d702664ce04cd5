"""Follows the contacts of simulations coarse step by coarse step: what the contact surrogate learns from."""

import logging

from millprint.config.contact import ContactConfig
from millprint.config.contact_surrogate import CoarseConfig, JudgeConfig, TraceConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import DemConfig
from millprint.job import job, progress
from millprint.surrogate.contact.dataset import follow, open_tracer, truths, write_dataset

logger = logging.getLogger("millprint")


def main(
    output: str,
    traces: list[TraceConfig],
    coarse: CoarseConfig,
    judge: JudgeConfig,
    mills: dict[str, MillConfig],
    contacts: dict[str, ContactConfig],
    dem: DemConfig,
) -> None:
    parts, judged = [], []
    with progress(10 * len(traces), "follow contacts", "part") as bar:
        for number, trace in enumerate(traces):
            mill, contact = mills[trace.mill], contacts[trace.contact]
            tracer = open_tracer(trace, mill, contact, dem, coarse, judge.position_s)
            parts.append(follow(tracer, trace, bar))
            logger.info("%s: %d contacts in %d states", trace, len(parts[-1].rows), len(parts[-1].sizes))
            if number == 0:
                # What follows what is learned from.
                judged = truths(tracer, judge)
    write_dataset(parts, judged, output)


if "snakemake" in globals():
    with job(snakemake.log[0], "follow contacts for the surrogate"):
        main(
            snakemake.output.dataset,
            [TraceConfig(**trace) for trace in snakemake.params.traces],
            CoarseConfig(**snakemake.params.coarse),
            JudgeConfig(**snakemake.params.judge),
            {name: MillConfig(**mill) for name, mill in snakemake.params.mills.items()},
            {name: ContactConfig(**contact) for name, contact in snakemake.params.contacts.items()},
            DemConfig(**snakemake.params.dem),
        )
