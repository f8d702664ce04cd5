"""A card from an experiment and its finished simulations.

Parts of a card: the descriptors of its condition, with their intervals from the scatter of its simulations, energy
spectra, dose, heat and wear.

A simulation scatters because its window is short. This scatter is seen twice: between seeds, and between blocks of
neighbouring revolutions in one window (delete-a-group jackknife, Kott, J. Official Stat. 17 (2001) 521). Both estimate
the variance v of the logarithm of a descriptor of one simulation (`variance_of_run`). With k seeds, mean m and
Student's t for the degrees of freedom of v, a new simulation of the condition falls into
exp(ln m +- t sqrt(v (1 + 1/k))), and the mean of very many into exp(ln m +- t sqrt(v / k)).
"""

import hashlib
import json
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from pydantic import BaseModel

from millprint.card.card_files import methods_paragraph, software
from millprint.card.card_model import (
    FORMAT,
    SCHEMA_VERSION,
    BallGroup,
    Balls,
    Bins,
    BodyHeat,
    CardFingerprint,
    ContactSet,
    Course,
    Descriptors,
    Dose,
    Heat,
    Hours,
    Jar,
    Machine,
    MillingCard,
    OverSpeed,
    Powder,
    Programme,
    Spectrum,
    Temperature,
    Wear,
    WearLoss,
)
from millprint.card.read import CardSettings, Known, Runs
from millprint.config.card import CardProgrammeSection, Experiment
from millprint.config.contact_set import NOMINAL_SPEED_M_S, ContactConfig
from millprint.config.counting import CountingRule, recorded_count
from millprint.config.dose import ChargeConfig, JarSection
from millprint.config.mill import MillConfig
from millprint.dem.collisions import kept_by, strongest, turns_of
from millprint.dose.heat_balance import BODIES, TIMES, heat_tables, mean_of, read_source
from millprint.dose.kinetics import doses_of
from millprint.dose.spectra import BOTH, read_contacts, tabulate_spectra
from millprint.dose.wear import FEWEST_HELD, PROBABILITY, mean_conditions, predict_wear, tabulate_sliding
from millprint.estimate.estimates import Estimate, Interval, factor_of, parts_of
from millprint.estimate.quantiles import student_quantile
from millprint.fingerprint.bands import FURTHER
from millprint.fingerprint.descriptors import (
    block_length,
    motions_in,
    run_row,
    seeds_of_motions,
    tabulate_descriptors,
    variance_of_run,
)
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.readers import check_summary
from millprint.mill.bodies import build_bodies
from millprint.mill.wall_words import walls_in_words
from millprint.observables.definitions import ON_CARD, POWER, POWER_PARTS, SHARE, STATISTICS, with_power
from millprint.run.digest import simulation_digest

# Columns for each revolution: energies [J] and sums of squared contact energies [J2] by channel, and the numbers of
# collisions, of collisions summed over the balls in them, and of strong contacts.
TOTALS = ("normal", "tangential", "rolling", "normal_square", "tangential_square", "count", "taken_part", "strong")
NORMAL, TANGENTIAL, ROLLING, NORMAL_SQUARE, TANGENTIAL_SQUARE, COUNT, TAKEN_PART, STRONG = range(len(TOTALS))
# Descriptors that depend on a number of collisions, and that number.
COUNTED = {
    "normal_energy_J": COUNT,
    "tangential_energy_J": COUNT,
    "specific_frequency_hz": COUNT,
    "collisions_of_a_ball_hz": TAKEN_PART,
    "strong_frequency_hz": STRONG,
}


@dataclass(frozen=True)
class Window:
    """What one simulation recorded in each whole revolution.

    totals: TOTALS of each (n, 8); revolution_s: time of one [s]; counted: whether the numbers were counted in each
    revolution, and are not equal shares of the whole.
    """

    totals: np.ndarray
    revolution_s: float
    balls: int
    counted: bool


def read_window(summary: dict, run_path: str, rule_name: str) -> Window:
    """The revolutions of a run. Without single contacts in the run, each has an equal share of the collisions."""
    revolutions = summary["per_revolution"]
    keys = ("normal_J", "tangential_J", "rolling_J", "normal_square_J2", "tangential_square_J2")
    energies = [np.asarray(revolutions.get(key, []), dtype=float) for key in keys]
    number, turn_s = len(energies[0]), 1 / summary["frequency_hz"]
    rule = recorded_count(summary, rule_name)
    contacts = read_contacts(run_path)
    if contacts is None:
        of_balls = [rule["collisions_of_a_ball_hz"], summary["weighted"]["strong_frequency_hz"]]
        rates = [rule["frequency_hz"], *(summary["balls"] * rate for rate in of_balls)]
        counts = [np.full(number, rate * turn_s) for rate in rates]
    else:
        own = CountingRule.of_count(rule)
        merged = contacts.merged(own, summary["frequency_hz"])
        kept = merged[kept_by(own, merged)]
        ordered = contacts.ordered("surface")
        lasting = turns_of(ordered, contacts.begin_s, summary["frequency_hz"])
        hard = ordered.iloc[strongest(ordered["normal_J"].to_numpy(), lasting)]
        chosen = [kept, kept[kept["second"] >= 0], hard]
        alone, both, strong = (_per_turn(each, contacts.begin_s, turn_s, number) for each in chosen)
        counts = [alone, alone + both, strong]
    return Window(np.column_stack([*energies, *counts]), turn_s, summary["balls"], contacts is not None)


def _per_turn(collisions: pd.DataFrame, begin_s: float, turn_s: float, number: int) -> np.ndarray:
    """Collisions that begin in each of `number` revolutions."""
    place = np.floor((collisions["start_s"].to_numpy() - begin_s) / turn_s).astype(int)
    return np.bincount(place[(place >= 0) & (place < number)], minlength=number).astype(float)


def _mean_of(total: np.ndarray, over: np.ndarray) -> np.ndarray:
    """total / over of collisions; 0 without any."""
    return np.divide(total, over, out=np.zeros_like(total), where=over > 0)


def descriptors_of_totals(totals: np.ndarray, time_s: np.ndarray | float, balls: int) -> dict[str, np.ndarray]:
    """Observables from sums of TOTALS (..., 8) over a time [s]."""
    normal, tangential, count = (totals[..., place] for place in (NORMAL, TANGENTIAL, COUNT))
    normal_square, tangential_square = totals[..., NORMAL_SQUARE], totals[..., TANGENTIAL_SQUARE]
    return with_power(
        {
            "weighted_normal_energy_J": _mean_of(normal_square, normal),
            "weighted_tangential_energy_J": _mean_of(tangential_square, tangential),
            "weighted_normal_frequency_hz": _mean_of(normal**2, normal_square) / time_s / balls,
            "weighted_tangential_frequency_hz": _mean_of(tangential**2, tangential_square) / time_s / balls,
            "strong_frequency_hz": totals[..., STRONG] / time_s / balls,
            "collisions_of_a_ball_hz": totals[..., TAKEN_PART] / time_s / balls,
            "normal_energy_J": _mean_of(normal, count),
            "tangential_energy_J": _mean_of(tangential, count),
            "specific_frequency_hz": count / time_s / balls,
            "normal_power_W": normal / time_s,
            "tangential_power_W": tangential / time_s,
            "rolling_power_W": totals[..., ROLLING] / time_s,
        }
    )


def jackknife(window: Window) -> tuple[dict[str, float], int]:
    """Variance of the logarithm of each descriptor of a window, and its degrees of freedom; empty for one block.

    Each of g blocks of equal length is left out in turn: v = (g - 1) / g sum (ln x_(j) - mean)^2. Without counts for
    each revolution, collisions vary as if they were independent.
    """
    number = len(window.totals)
    length = block_length(number) if number >= 2 else 1
    groups = number // length
    if groups < 2:
        return {}, 0
    blocks = window.totals[: groups * length].reshape(groups, length, len(TOTALS)).sum(axis=1)
    left = blocks.sum(axis=0) - blocks
    found = descriptors_of_totals(left, (groups - 1) * length * window.revolution_s, window.balls)
    # A block without collisions, or without dissipation of a kind, has no logarithm.
    variances = {
        name: float((groups - 1) * np.log(values).var()) for name, values in found.items() if (values > 0).all()
    }
    if not window.counted:
        for name, place in COUNTED.items():
            variances[name] = variances.get(name, 0.0) + 1 / window.totals[:, place].sum()
    return variances, groups - 1


class Halves(NamedTuple):
    """Half the widths of the bands of a descriptor's logarithm, for a new simulation and for the mean."""

    new: float
    mean: float


def spread(
    windows: list[Window], values: list[dict[str, float]], variances: list[dict[str, float]], probability: float
) -> dict[str, Halves]:
    """Half the widths of both bands of each descriptor; empty where there is no estimate.

    windows, values: revolutions and descriptors of each seed; variances: of the logarithms of statistics of collisions,
    from the same blocks.
    """
    seeds = len(windows)
    within = [(found | own, freedom) for (found, freedom), own in zip(map(jackknife, windows), variances, strict=True)]
    found = {}
    for name in values[0]:
        if min(own[name] for own in values) <= 0:
            continue
        inside = [(known[name], freedom) for known, freedom in within if name in known]
        run = variance_of_run([float(np.log(own[name])) for own in values], inside)
        if run is not None:
            quantile = float(student_quantile(0.5 + probability / 2, run.freedom))
            found[name] = Halves(
                *(quantile * float(np.sqrt(run.variance * share)) for share in (1 + 1 / seeds, 1 / seeds))
            )
    return found


COURSE = ["lower_degC", "median_degC", "upper_degC"]
TIMES_OF_CYCLE, MOST_TIMES = 10, 400
READ_OFF = ("collisions_hz", "power_W", "power_share", "mean_J", "median_J", "half_power_J")


def _number(value: float) -> float | None:
    """A number, or None for one that is not finite."""
    return float(value) if np.isfinite(value) else None


def spectra_part(summaries: list[dict], paths: list[str], settings: CardSettings) -> tuple[list[Spectrum], str]:
    """The spectra by channel and pair, and the reason if there are none."""
    runs = list(zip(paths, summaries, strict=True))
    bins, rows = tabulate_spectra(runs, [settings.counting_rule])
    found = []
    for row in rows.to_dict("records"):
        if row["note"] == row["note"] and row["note"]:
            return [], row["note"]
        if row["pair"] == BOTH:
            continue
        own = bins[(bins["channel"] == row["channel"]) & (bins["pair"] == row["pair"])]
        found.append(
            Spectrum(
                channel=row["channel"],
                pair=row["pair"],
                **{name: _number(row[name]) for name in READ_OFF},
                bins=Bins(**{name: [_number(value) for value in own[name]] for name in Bins.model_fields}),
            )
        )
    return found, ""


def dose_part(descriptors: Descriptors, balls: Balls, powder: Powder, programme: Programme) -> Dose:
    """Energy and hits of a gram of powder, with the relative intervals of powers and frequency."""
    rate = replace(descriptors.wall_power_W * (1 / powder.mass_g), unit="W/g")
    return Dose(**doses_of(descriptors, balls.number, programme.milling_h, powder.mass_g), rate_W_g=rate)


def _temperature(row: pd.Series, name: str) -> Temperature:
    return Temperature(**{end: float(row[f"{name}_{end}"]) for end in Temperature.model_fields})


def times_of(programme: CardProgrammeSection) -> int:
    """Number of times with temperatures: enough to show each of up to about forty cycles."""
    cycles = 60 * programme.duration_h / programme.cycle_min if programme.pause_min else 0.0
    return max(TIMES, 1 + min(MOST_TIMES, round(TIMES_OF_CYCLE * cycles)))


def heat_part(
    experiment: Experiment, jar: JarSection, powder: Powder | None, runs: Runs, settings: CardSettings
) -> Heat:
    """Temperatures of the experiment; over time only with a programme."""
    programme = experiment.programme
    own = settings.dose.heat.model_copy(
        update={
            "jars": {experiment.mill: jar},
            "powder_mass_g": powder.mass_g if powder else None,
            **({"programme": programme} if programme else {}),
        }
    )
    summaries = [path.replace("run.h5", "summary.json") for path in runs.paths]
    source = mean_of([read_source(*pair) for pair in zip(summaries, runs.paths, strict=True)])
    tables = heat_tables(own, experiment.mill, [source], times=times_of(programme) if programme else TIMES)
    limits, course = tables.limits.iloc[0], tables.temperatures
    bodies = {
        name: BodyHeat(
            steady_degC=_temperature(limits, f"{name}_steady_degC"),
            peak_degC=_temperature(limits, f"{name}_peak_degC") if programme else None,
        )
        for name in BODIES
    }
    by_body = {f"{name}_degC": course[course["body"] == name] for name in BODIES}
    temperatures = {
        name: [Temperature(lower=low, median=mid, upper=up) for low, mid, up in rows[COURSE].to_numpy().tolist()]
        for name, rows in by_body.items()
    }
    return Heat(
        probability=own.probability,
        power_W=float(limits["total_W"]),
        **bodies,
        limit_body=own.limit.body,
        limit_degC=own.limit.temperature_degC,
        time_to_limit_h=Hours(**{end: _number(limits[f"time_to_limit_h_{end}"]) for end in Hours.model_fields}),
        course=Course(time_h=by_body["balls_degC"]["time_h"].tolist(), **temperatures) if programme else None,
    )


def wear_part(
    balls: Balls, powder: Powder | None, programme: Programme | None, runs: Runs, settings: CardSettings, known: Known
) -> tuple[Wear | None, str]:
    """Wear of the balls and iron in the powder, or the reason why it is not known."""
    for name, given in (("powder", powder), ("programme", programme), ("material of the balls", balls.material)):
        if not given:
            return None, f"no {name} is given"
    if known.wear is None or known.materials is None or powder is None or programme is None:
        return None, known.why.get("wear", "no fitted wear coefficient")
    summaries = [path.replace("run.h5", "summary.json") for path in runs.paths]
    conditions = mean_conditions(tabulate_sliding(list(zip(runs.paths, summaries, strict=True))))
    charge = ChargeConfig(bpr=powder.ball_to_powder_ratio, time_h=programme.milling_h)
    factors = known.fingerprint.further.get("contact") if known.fingerprint else None
    chosen = known.materials.loc[[balls.material]]
    row = predict_wear(conditions, chosen, [charge], known.wear, factors).iloc[0]

    tested = known.wear["weighings_held_back"] >= FEWEST_HELD
    ends = "" if tested else "seen_"

    def estimate(name: str) -> WearLoss:
        return WearLoss(value=row[name], lower=row[f"{ends}lower_{name}"], upper=row[f"{ends}upper_{name}"])

    return Wear(
        material=balls.material,
        probability=PROBABILITY if tested else None,
        wear_g=estimate("wear_g"),
        iron_percent=estimate("iron_percent"),
        coefficient=known.wear["coefficient"],
        coefficient_from=(
            f"weighings of {known.wear['material']} balls in mill {known.wear['mill']}: "
            f"{known.wear['weighings_fitted']} fitted, {known.wear['weighings_held_back']} held back"
        ),
        note=row["note"],
    ), ""


def describe_runs(
    runs: Runs, settings: CardSettings, fingerprint: Fingerprint | None
) -> tuple[Descriptors, dict[str, str], list[str], Runs]:
    """The descriptors with their intervals, why an interval is not known, why the bands may be wrong, and the runs of
    one motion: of several that last, that of most seeds.
    """
    rule = settings.counting_rule
    singles = [tabulate_descriptors([summary], rule) for summary in runs.summaries]
    each = [_values(single) for single in singles]
    table = tabulate_descriptors(runs.summaries, rule)
    value = _values(table)
    lasting, motions = table["lasting_motions"].iloc[0], [runs]
    if lasting:
        places = seeds_of_motions(pd.DataFrame([run_row(summary, rule) for summary in runs.summaries]))
        motions = [Runs([runs.summaries[i] for i in own], [runs.paths[i] for i in own]) for own in places]
    of_motions = [_values(tabulate_descriptors(own.summaries, rule)) for own in motions] if lasting else []
    windows = [read_window(*run, rule) for run in zip(runs.summaries, runs.paths, strict=True)]
    errors = [{own.name: float(single[f"{own.name}_relative_se"].iloc[0]) for own in STATISTICS} for single in singles]
    variances = [{name: error**2 for name, error in own.items() if np.isfinite(error)} for own in errors]
    widths = spread(windows, each, variances, settings.interval)
    missing = {} if widths else dict.fromkeys(("scatter", "mean"), "one simulation of fewer than two turns")
    fill = float(table["fill_ratio"].iloc[0])
    factors = {}
    for origin in FURTHER:
        if fingerprint is None:
            missing[origin] = "not analysed"
        elif reason := fingerprint.missing(fill).get(origin):
            missing[origin] = reason
        else:
            factors[origin] = fingerprint.further[origin].at(table["fill_ratio"].to_numpy())
    found = {}
    for name, own in value.items():
        if not math.isfinite(own):
            continue
        known, curve = {}, ON_CARD[name].curve
        for origin, ends in factors.items():
            if name == SHARE.name:
                # The share rises with the ratio of tangential to normal.
                low, high = (1 / (1 + (1 / own - 1) / end) for end in ends["ratio"][:, 0])
            else:
                low, high = own * ends[curve][:, 0] if curve else (math.nan, math.nan)
            if math.isfinite(low):
                known[origin] = Interval(float(low), float(high))
        for origin, half in zip(("scatter", "mean"), widths.get(name, ()), strict=False):
            if interval := _around(own, half, name):
                known[origin] = interval
        own_motions = tuple(values[name] for values in of_motions if math.isfinite(values[name]))
        found[name] = Estimate(own, ON_CARD[name].unit, motions=own_motions or None).having(known)
    found |= parts_of(found[POWER], {name: found[name] for name in POWER_PARTS})
    against = [f"{own.word}: {own.meaning}" for own in motions_in(table["motion"].iloc[0]).values()]
    if lasting:
        against.append(f"several motions last: {lasting}; spectra, temperatures and wear are those of the first")
    return Descriptors(**found), missing, against, motions[0]


def _around(value: float, half: float, name: str) -> Interval | None:
    """The interval from half its width in logarithms; a share is at most 1. None if it is not known."""
    factor = float(factor_of(half))
    if math.isnan(factor):
        return None
    return Interval(lower=value / factor, upper=min(value * factor, 1.0) if name == SHARE.name else value * factor)


def _values(table: pd.DataFrame) -> dict[str, float]:
    """The observables of the one condition of a table."""
    row = with_power(table.iloc[0])
    return {name: float(row[name]) for name in ON_CARD}


def build_card(
    experiment: Experiment, mill: MillConfig, contact: ContactConfig, runs: Runs, settings: CardSettings, known: Known
) -> MillingCard:
    """The card. contact: the contact set as simulated, with the ball density of the experiment.

    Raises ConfigError, in one line, for a run without collisions and if the material differs from the simulated one.
    """
    for summary, path in zip(runs.summaries, runs.paths, strict=True):
        check_summary(summary, str(Path(path).with_name("summary.json")))
    first = runs.summaries[0]
    rule = recorded_count(first, settings.counting_rule)
    descriptors, missing, motion, of_one_motion = describe_runs(runs, settings, known.fingerprint)
    balls = _balls(experiment, first)
    powder = _powder(experiment, balls)
    programme = _programme(experiment)
    not_known = dict(known.why)
    spectra, why = spectra_part(of_one_motion.summaries, of_one_motion.paths, settings)
    not_known |= {"spectra": why} if why else {}
    if powder is None or programme is None:
        lacking = "powder" if powder is None else "programme"
        not_known |= {"dose": f"no {lacking} is given"}
    dose = dose_part(descriptors, balls, powder, programme) if powder and programme else None
    jar = jar_section(experiment, settings)
    heat = heat_part(experiment, jar, powder, of_one_motion, settings)
    wear, why = wear_part(balls, powder, programme, of_one_motion, settings, known)
    not_known |= {"wear": why} if why else {}
    card = MillingCard(
        format=FORMAT,
        schema_version=SCHEMA_VERSION,
        name=experiment.name,
        title=experiment.title or mill.title,
        **{name: getattr(experiment, name) for name in ("authors", "reference", "atmosphere", "note")},
        machine=Machine(
            name=mill.name, title=mill.title, source=mill.source, motion=mill.motion.kind,
            amplitude_mm=1e3 * first["amplitude_m"] or None, speed_rpm=experiment.rpm, speed_unit=mill.speed_unit,
        ),
        jar=Jar(
            volume_ml=mill.volume_ml, shape=mill.geometry.kind, cooling=jar.cooling,
            wall=walls_in_words(build_bodies(mill)),
            material=experiment.jar.material if experiment.jar else "",
        ),
        balls=balls,
        powder=powder,
        programme=programme,
        contact_set=_contact_set(contact),
        fingerprint=CardFingerprint(
            counting_rule=settings.counting_rule,
            collisions_by=rule["by"],
            collision_gap_turns=rule["gap_turns"],
            probability=settings.interval,
            descriptors=descriptors,
            seeds=[summary["case"]["seed"] for summary in runs.summaries],
            window_s=sum(summary["window_s"] for summary in runs.summaries),
            revolutions=sum(summary["revolutions"] for summary in runs.summaries),
            closure=max(abs(summary["closure"]) for summary in runs.summaries),
            missing=missing,
            motion=motion,
        ),
        spectra=spectra,
        dose=dose,
        heat=heat,
        wear=wear,
        not_known=not_known,
        software=software(),
        digests={
            "mill": _digest(mill),
            "contact_set": _digest(contact),
            "experiment": _digest(experiment),
            "simulation": simulation_digest(),
        },
    )  # fmt: skip
    return card.model_copy(update={"methods": methods_paragraph(card)})


def jar_section(experiment: Experiment, settings: CardSettings) -> JarSection:
    """The jar's properties for its heat balance, from the experiment, or else from the mill."""
    if experiment.jar is not None:
        return JarSection(**experiment.jar.model_dump(include=set(JarSection.model_fields)))
    return settings.dose.heat.jar_of(experiment.mill)


def _digest(section: BaseModel) -> str:
    """SHA-256 of the plain values of a section."""
    return hashlib.sha256(json.dumps(section.model_dump(mode="json"), sort_keys=True).encode()).hexdigest()


def _balls(experiment: Experiment, summary: dict) -> Balls:
    pairs = zip(summary["ball_sizes_m"], summary["ball_counts"], strict=True)
    return Balls(
        sizes=[BallGroup(diameter_mm=round(1e3 * size, 9), number=count) for size, count in pairs],
        mass_g=1e3 * summary["balls"] * summary["ball_mass_kg"],
        density_kg_m3=summary["density_kg_m3"],
        fill_ratio=summary["case"]["fill_ratio"],
        material=experiment.balls.material or "",
    )


def _powder(experiment: Experiment, balls: Balls) -> Powder | None:
    own = experiment.powder
    if own is None:
        return None
    mass = own.mass_g if own.mass_g is not None else balls.mass_g / (own.bpr or 1.0)
    return Powder(name=own.name, mass_g=mass, ball_to_powder_ratio=balls.mass_g / mass)


def _programme(experiment: Experiment) -> Programme | None:
    own = experiment.programme
    if own is None:
        return None
    return Programme(
        duration_h=own.duration_h,
        milling_h=own.milling_h,
        cycle_min=own.cycle_min if own.pause_min else None,
        pause_min=own.pause_min,
        reversal=own.reversal,
    )


def _contact_set(contact: ContactConfig) -> ContactSet:
    nominal = contact.at_speed(NOMINAL_SPEED_M_S)
    over_speed = [
        OverSpeed(coefficient=name, speeds_m_s=list(table.speeds_m_s), values=list(table.values))
        for name, table in contact.speed_tables.items()
    ]
    return ContactSet(
        **{name: value for name, value in nominal if name in ContactSet.model_fields and name != "cohesion"},
        over_speed=over_speed,
        cohesion=contact.cohesion.model_dump(exclude_none=True) if contact.cohesion else {},
    )
