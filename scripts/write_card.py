"""Writes the milling card of one experiment of the table `cards.experiments`.

Settings: dose, dem, mills.counting_rule, fingerprint.interval, cards.animation; the experiment with its cases, mill
and contact set.
Inputs: `runs`, `summaries`, `materials`, and `uncertainty` and `wear` where they are known.
Outputs: `card`, `figure`, `pdf`, `tsv`, `methods`, `table`, `references`, and the `animation` if it is asked for.
"""

from pathlib import Path

from millprint.card.build import build_card
from millprint.card.card_files import GIF, animate, remove_left_overs, write_card
from millprint.card.read import CardSettings, Runs, known_of
from millprint.cases.table import animated_case
from millprint.config.card import Experiment
from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig, overridden
from millprint.fingerprint.readers import read_counted
from millprint.run.job import job

if "snakemake" in globals():
    given = snakemake.params
    with job(snakemake.log[0], f"card {snakemake.wildcards.card}") as logger:
        experiment, mill = Experiment(**given.experiment), MillConfig(**given.mill)
        first = Case(**given.cases[0])
        contact = overridden(first, mill, ContactConfig(**given.contact))[1]
        paths = list(snakemake.input.runs)
        summaries = [read_counted(path, given.rules) for path in snakemake.input.summaries]
        known = known_of(
            next(iter(snakemake.input.get("uncertainty", [])), None),
            next(iter(snakemake.input.get("wear", [])), None), snakemake.input.materials, contact.name,
        )  # fmt: skip
        folder = Path(snakemake.output.card).parent
        card = build_card(experiment, mill, contact, Runs(summaries, paths), CardSettings(**given.settings), known)
        write_card(card, mill, folder)
        if given.animation:
            remove_left_overs(folder)
            animate(animated_case(first), mill, contact, DemConfig(**given.dem), folder / GIF)
        logger.info("%s", card.methods)
