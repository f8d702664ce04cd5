"""Simulates one experiment and writes its milling card: what the mill does to balls and powder, for a paper.

    millprint card card.yaml --out my_card

card.yaml needs a name, a mill of config/mills, its speed, and the balls; config/keys.md has every key:

    name: my_card
    mill: planetary
    speed_rpm: 400
    balls: {diameter_mm: 10, fill_ratio: 0.2}
    powder: {name: quartz, mass_g: 20}
    programme: {duration_h: 5, cycle_min: 20, pause_min: 10}

Only that condition is simulated, with several seeds, without a sweep. The folder gets card.json (workflow/card.md
explains it), the card on one page (PDF, SVG, PNG), the methods paragraph, a LaTeX table, BibTeX, and an animation. A
call that was stopped continues where it stopped. Wear needs the coefficient that the target `dose` fits, and intervals
by contact parameters the target `uncertainty`; both are found in --results.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from millprint.cli.commands import parser_of
from millprint.config.arguments import Cores, value_of
from millprint.config.card import Experiment
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError, MillprintError
from millprint.config.load import check_model, load_named, read_yaml
from millprint.config.mill import MillConfig
from millprint.config.sweep import overridden
from millprint.run.files import read_json
from millprint.run.numbers import counted

if TYPE_CHECKING:
    from millprint.card.card_model import MillingCard


def say(card: MillingCard) -> None:
    """Print the numbers of the card."""
    from millprint.card.card_files import TITLES, in_words

    rows = [*card.fingerprint.descriptors.known.items(), *(vars(card.dose).items() if card.dose else [])]
    for name, quantity in rows:
        print(f"{TITLES[name]}: {in_words(quantity, quantity.scatter)}")
    print(f"\n{card.methods}")


def parse(arguments: list[str], name: str) -> argparse.Namespace:
    """Parse the command line."""
    parser = parser_of(name, __doc__)
    parser.add_argument("experiment", type=Path, help="YAML file with the experiment")
    parser.add_argument("--out", type=Path, help="folder for the card (default: results/cards/NAME)")
    parser.add_argument("--results", type=Path, default=Path("results"), help="folder with results of earlier runs")
    parser.add_argument(
        "--cores", type=value_of("cores", Cores), default=2, metavar="N", help="simulations at a time (default 2)"
    )
    parser.add_argument("--no-animation", action="store_true", help="leave the animation out")
    return parser.parse_args(arguments)


def main(arguments: list[str], name: str = "card") -> None:
    """Simulate the experiment and write its card."""
    options, begin = parse(arguments, name), time.perf_counter()
    from millprint.card.build import build_card
    from millprint.card.card_files import FILES, GIF, draw_run, write_card
    from millprint.card.experiment_checks import check_experiment
    from millprint.card.read import CardSettings, Runs, known_of
    from millprint.cases.simulate import simulate_cases
    from millprint.cases.table import animated_case, own_cases
    from millprint.checks.before_running import mill_warnings
    from millprint.config.included import SOURCES
    from millprint.config.load import CONTACT_FOLDER, MILL_FOLDER
    from millprint.config.workflow import WorkflowConfig
    from millprint.dem.compilation import compile_kernels

    sources, place = SOURCES, str(options.experiment)
    experiment = check_model(read_yaml(options.experiment), Experiment, place)
    config = WorkflowConfig(mill=experiment.mill)
    config = sources.resolve(config)
    mill = load_named(MILL_FOLDER, experiment.mill, MillConfig, "mill", sources)
    balls = experiment.contact or config.mills.contact_set
    contact = load_named(CONTACT_FOLDER, balls, ContactConfig, "contact set", sources)
    warnings, seconds = check_experiment(experiment, mill, contact, config, place)
    for line in [*warnings, *mill_warnings({mill.name: mill})]:
        print(f"warning: {line}", file=sys.stderr)
    out = options.out or options.results / "cards" / experiment.name
    cases = own_cases(experiment, mill, contact, config.mills, place)
    runs = {f"seed_{case.seed}": case for case in cases}
    wanted = runs if options.no_animation else {**runs, "animation": animated_case(cases[0])}
    print(
        f"{counted(len(wanted), 'simulation')} of about {seconds / len(cases):.2g} s of one core each, in {out}",
        file=sys.stderr,
    )
    compile_kernels(options.cores)
    try:
        done = simulate_cases(wanted, mill, contact, config.dem, out / "runs", options.cores)
    except MillprintError as error:
        raise ConfigError(f"{place}: {error}") from None
    if done:
        print(f"{done} of {len(wanted)} simulations were done before", file=sys.stderr)
    known = known_of(
        options.results / "uncertainty" / mill.name / "fingerprint.json",
        options.results / "dose" / "wear_coefficient.json", config.dose.wear.materials, balls,
    )  # fmt: skip
    settings = CardSettings(counting_rule=config.mills.rule, interval=config.fingerprint.interval, dose=config.dose)
    simulated = overridden(cases[0], mill, contact)[1]
    folders = [out / "runs" / name for name in runs]
    paths = [str(folder / "run.h5") for folder in folders]
    card = build_card(
        experiment, mill, simulated, Runs([read_json(folder / "summary.json") for folder in folders], paths),
        settings, known,
    )  # fmt: skip
    write_card(card, mill, out)
    if not options.no_animation:
        run, gif = out / "runs" / "animation" / "run.h5", out / GIF
        if not gif.is_file() or gif.stat().st_mtime < run.stat().st_mtime:
            draw_run(run, gif)
    say(card)
    made = [*FILES, *([] if options.no_animation else [GIF])]
    print(f"\n{out}: {', '.join(made)}, written in {time.perf_counter() - begin:.0f} s")
