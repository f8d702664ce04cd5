"""Reads milling cards back: the settings of other mills that come nearest to each, and a sentence on what is lost.

Settings: fingerprint.descriptors.
Inputs: `cards` and `fingerprints`.
Outputs: `table` and `verdict`.
"""

import pandas as pd

from millprint.card.match import match_card, verdict
from millprint.card.read import read_card
from millprint.config.fingerprint import DescriptorSet
from millprint.fingerprint.comparison import Wanted
from millprint.fingerprint.model import Fingerprint
from millprint.run.files import whole_file, write_table
from millprint.run.job import job


def main(
    cards: list[str], fingerprints: list[str], table_path: str, verdict_path: str, descriptors: DescriptorSet
) -> list[str]:
    """Match every card to every mill but its own; write the table and the sentences, and return these."""
    tables, lines = [], []
    known = [Fingerprint.read(path) for path in fingerprints]
    for card in map(read_card, cards):
        for fingerprint in known:
            if fingerprint.about["mill"] == card.machine.name:
                continue
            table = match_card(card, fingerprint, Wanted(descriptors=descriptors))
            tables.append(table)
            lines += verdict(card, fingerprint, table)
    write_table(pd.concat(tables, ignore_index=True) if tables else pd.DataFrame(columns=["target"]), table_path)
    with whole_file(verdict_path) as partial:
        partial.write_text("".join(f"{line}\n" for line in dict.fromkeys(lines)))
    return lines


if "snakemake" in globals():
    with job(snakemake.log[0], "match cards") as logger:
        for line in main(
            snakemake.input.cards,
            snakemake.input.fingerprints,
            snakemake.output.table,
            snakemake.output.verdict,
            snakemake.params.descriptors,
        ):
            logger.info("%s", line)
