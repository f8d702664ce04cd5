"""Chapter 3: descriptors of every condition, the fingerprint of each contact set, its scaling, and the inverse mode.

Tables of descriptors, counting rules and single revolutions; fitted curves as a table and as a model, and the coverage
of their bands; numbers of the collapse, universal curves, exponents by regression, and zones; the speeds that give
target descriptors, and conditions ranked by their distance.

Settings: mill, contacts, fingerprint (counting_rule, cycle_fill_ratio, interval, smooth_points, inverse).
Inputs: `summaries` and `runs` of the simulations, `published` values, fingerprints of `others` that a target names.
Outputs: `descriptors`, `counting_rules`, `cycles`, `densities`, `table_3_5`; for each contact set `means`, `curves`,
`coverage`, `fingerprint`; `collapse`, `universal`, `exponents`, `zones`; `inverse` (speeds) and `ranked` (conditions).
"""

import pandas as pd

from millprint.config.charge import ONE_SIZE
from millprint.config.fingerprint import InverseConfig
from millprint.fingerprint.condition_search import match_targets, target_of
from millprint.fingerprint.coverage import tabulate_coverage
from millprint.fingerprint.descriptors import CHARGE, as_built, read_descriptors, tabulate_descriptors
from millprint.fingerprint.mill_collapse import find_zones
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.readers import read_summaries
from millprint.observables.condition import fill_grid
from millprint.observables.definitions import BASIC, CURVE_COLUMNS, DESCRIPTOR_SETS, WEIGHTED_BASIC
from millprint.run.files import read_table, write_table
from millprint.run.job import job
from millprint.thesis.regimes import (
    published_cycles,
    published_point,
    read_published,
    tabulate_cycles,
    tabulate_densities,
    tabulate_published,
)
from millprint.thesis.scaling import (
    at_shared_fills,
    average_curves,
    conditions_of,
    fit_exponents,
    invert_speed,
    tabulate_collapse,
    tabulate_counting_rules,
    universal_descriptors,
)

# What is written for each contact set, by the names of the rule's outputs.
FILES = ("means", "curves", "coverage", "fingerprint")


def tabulate_conditions(given, made, own) -> None:
    """Read all summaries and write the five tables; revolutions are compared at one fill ratio."""
    summaries = read_summaries(given.summaries, own.rules)
    cycles, published = tabulate_cycles(summaries), published_cycles(read_published(*given.published))
    write_table(tabulate_descriptors(summaries, own.counting_rule), made.descriptors)
    # The chapters are of balls of one size.
    write_table(tabulate_counting_rules(summaries).drop(columns=CHARGE), made.counting_rules)
    write_table(cycles, made.cycles)
    write_table(tabulate_published(cycles, published, own.mill, own.cycle_fill_ratio), made.table_3_5)
    write_table(tabulate_densities(summaries, own.cycle_fill_ratio), made.densities)


def fit_contact(descriptors: pd.DataFrame, contact: str, made: dict[str, str], own) -> None:
    """Average the descriptors of the mill with one contact set, and fit the fingerprint; made: paths by FILES."""
    conditions = conditions_of(descriptors, own.mill, contact)
    built = as_built(conditions)
    write_table(average_curves(built), made["means"])
    fingerprint = Fingerprint.fit(conditions, own.volume_m3, own.interval)
    fills = fill_grid(built["fill_ratio"].unique(), own.smooth_points)
    write_table(fingerprint.curve(fills)[CURVE_COLUMNS], made["curves"])
    write_table(tabulate_coverage(fingerprint), made["coverage"])
    fingerprint.write(made["fingerprint"])


def measure_scaling(descriptors: pd.DataFrame, made, own) -> None:
    """Write collapse, universal curves and zones of the mill, and the exponents of every mill of the sweeps."""
    # The chapters are of balls of one size.
    counting_rules = read_table(made.counting_rules).assign(**{CHARGE: ONE_SIZE})
    chosen = descriptors[(descriptors["mill"] == own.mill) & descriptors["contact"].isin(own.contacts)]
    write_table(tabulate_collapse(chosen), made.collapse)
    write_table(average_curves(universal_descriptors(at_shared_fills(as_built(chosen)))), made.universal)
    write_table(fit_exponents(descriptors, counting_rules, own.interval), made.exponents)
    zones = pd.concat([find_zones(Fingerprint.read(path)) for path in made.fingerprint], ignore_index=True)
    write_table(zones, made.zones)


def solve_speeds(own: Fingerprint, points: dict[str, dict[str, float]], inverse: InverseConfig) -> pd.DataFrame:
    """Speeds at the fixed fill ratio and ball size from the scaling laws only, for every target and set of curves.

    Curves that know nothing of weighted descriptors, as those of the thesis, answer no target of them.
    """
    condition = own.condition(
        speed_hz=1.0,  # is what is sought
        ball_diameter_m=inverse.fixed_ball_diameter_mm * 1e-3,
        fill_ratio=inverse.fixed_fill_ratio,
    )
    tables = []
    for target in inverse.targets:
        for source, point in points.items():
            wanted = {name: each.value for name, each in target_of(target, [own], inverse).wanted.items()}
            if not wanted.keys().isdisjoint(DESCRIPTOR_SETS["weighted"]) and not point.keys() >= set(WEIGHTED_BASIC):
                continue
            table = invert_speed(wanted, point, condition, own.about["volume_m3"])
            table.insert(0, "curves", source)
            table.insert(0, "target", target.name)
            tables.append(table)
    return pd.concat(tables, ignore_index=True)


def invert(fingerprints: dict[str, str], published_paths: list[str], output, inverse: InverseConfig) -> None:
    """Solve and rank with our curves, and solve with the published curves for the contact sets that have them."""
    read = {contact: Fingerprint.read(path) for contact, path in fingerprints.items()}
    own, fill = read[inverse.contact], inverse.fixed_fill_ratio
    printed = published_point(read_published(*published_paths), inverse.contact, fill)
    scaled = own.at(fill)
    points = {"ours": {name: scaled[name].value for name in (*BASIC, *WEIGHTED_BASIC)}}
    points |= {"published": printed} if printed else {}
    write_table(solve_speeds(own, points, inverse), output.inverse)
    write_table(match_targets(inverse, [read[contact] for contact in inverse.contacts]), output.ranked)


if "snakemake" in globals():
    given, made, own = snakemake.input, snakemake.output, snakemake.params
    with job(snakemake.log[0], "fit master curves") as log:
        log.info("%d simulations", len(given.summaries))
        tabulate_conditions(given, made, own)
        descriptors = read_descriptors(made.descriptors)
        for number, contact in enumerate(own.contacts):
            fit_contact(descriptors, contact, {name: made[name][number] for name in FILES}, own)
            log.info("fitted: %s", contact)
        measure_scaling(descriptors, made, own)
        fingerprints = dict(zip(own.contacts, made.fingerprint, strict=True))
        invert(fingerprints, given.published, made, InverseConfig(**own.inverse))
