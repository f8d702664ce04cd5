"""Compares mills: do their curves collapse, and which of their settings come nearest to another mill or to a card?

Of the box, a table of the collapse with a row for each mill, its figure, and how often new simulations are within the
bands of each. Of a match, the conditions of a mill nearest to a condition of another. Of milling cards, the settings of
other mills that come nearest to each, and a sentence on what is lost.

Settings: mills.box; mills.match, fingerprint.descriptors.
Inputs: `collapse` and `coverage`, a table of each mill in the order of the box; or fingerprints of the `mill` and of
the one that it is to be `like`; or `cards` and `fingerprints`.
Outputs: `table`, `figure` of the collapse, `coverage`; or the conditions as `match`; or `table` and `verdict`.
"""

import pandas as pd

from millprint.card.read import match_card, read_card
from millprint.config.fingerprint import DescriptorSet, LikeConfig, MatchConfig, SearchConfig, TargetConfig
from millprint.config.mill_sweep import MatchMillsConfig
from millprint.figures.mill_sheet_figure import plot_collapse
from millprint.figures.style import save
from millprint.fingerprint.condition_search import rank_conditions, target_of
from millprint.fingerprint.coverage import sum_coverage
from millprint.fingerprint.match_words import match_in_words
from millprint.fingerprint.mill_collapse import COLLAPSE_MAX, one_row_a_mill
from millprint.fingerprint.model import Fingerprint
from millprint.run.files import read_table, whole_file, write_table
from millprint.run.job import job


def collect(collapse: list[str], coverage: dict[str, str], output) -> pd.DataFrame:
    """Write the collapse of all mills with its figure, and the coverage of each with a sum, which is returned."""
    table = one_row_a_mill([read_table(path) for path in collapse])
    write_table(table, output.table)
    save(plot_collapse(table, COLLAPSE_MAX), *output.figure)
    found = sum_coverage({name: read_table(path) for name, path in coverage.items()})
    write_table(found, output.coverage)
    return found


def match_mill(settings: MatchMillsConfig, mill: str, like: str, descriptors: DescriptorSet, output: str) -> list[str]:
    """Write the conditions of a mill nearest to one of another, by the paths of both; returns the sentences on them."""
    own = Fingerprint.read(mill)
    condition = LikeConfig(fingerprint=like, **settings.like.model_dump(exclude={"mill"}))
    asked = TargetConfig(name=settings.like.mill, like=condition)
    speeds_and_balls = settings.model_dump(include={"speeds_rpm", "ball_diameters_mm"})
    request = MatchConfig(targets=[asked], descriptors=descriptors, **speeds_and_balls)
    target = target_of(asked, [own], request)
    table = rank_conditions(target, [own], request)
    table.insert(0, "target", asked.name)
    write_table(table, output)
    return match_in_words(table, target, request, [own])


def match_cards(cards: list[str], fingerprints: list[str], output, descriptors: DescriptorSet) -> list[str]:
    """Match every card to every mill but its own; write the table and the sentences, and return these."""
    tables, lines = [], []
    known = [Fingerprint.read(path) for path in fingerprints]
    for card in map(read_card, cards):
        for fingerprint in known:
            if fingerprint.about["mill"] != card.machine.name:
                _, table, said = match_card(card, fingerprint, SearchConfig(descriptors=descriptors))
                tables.append(table)
                lines += said
    write_table(pd.concat(tables, ignore_index=True) if tables else pd.DataFrame(columns=["target"]), output.table)
    with whole_file(output.verdict) as partial:
        partial.write_text("".join(f"{line}\n" for line in dict.fromkeys(lines)))
    return lines


if "snakemake" in globals():
    given, made, own = snakemake.input, snakemake.output, snakemake.params
    with job(snakemake.log[0], "compare mills") as logger:
        if made.get("coverage"):
            found = collect(given.collapse, dict(zip(own.mills, given.coverage, strict=True)), made)
            for row in found[found["quantity"] == "powers"].itertuples():
                logger.info("%s: %d of %d powers of new simulations", row.mill, row.held, row.conditions)
        elif made.get("match"):
            settings = MatchMillsConfig(**own.settings)
            for line in match_mill(settings, given.mill, given.like, own.descriptors, made.match):
                logger.info("%s", line)
        else:
            for line in match_cards(given.cards, given.fingerprints, made, own.descriptors):
                logger.info("%s", line)
