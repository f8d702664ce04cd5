"""Claims of thesis chapter 3: calibration, single revolutions, the reference case, the modulus; and of its text.

Claims of thesis chapter 3 on the master curves: values, shape and collapse.
"""

import itertools
import re

import numpy as np
import pandas as pd

from millprint.config.calibration import FRICTION_PAIR, SIMULATED
from millprint.config.contact_set import ContactConfig
from millprint.config.load import load_named
from millprint.config.mill import MillConfig
from millprint.config.sweep import ball_count
from millprint.fingerprint.descriptors import NOTHING
from millprint.observables.condition import effective_restitution
from millprint.thesis.claims.evidence import (
    Contradiction,
    Evidence,
    Finding,
    NotRun,
    Repeats,
    change_percent,
    claim,
    datum,
    in_points,
    in_words,
    look_up,
    repeats_of,
    yes_no,
)
from millprint.thesis.scaling import MACHINE

MILL, CONTACT = "emax", "calibrated"
# Conditions on the rows of a table: the thesis's mill and contact set, and of these the mill as built.
OWN = f"mill == '{MILL}' and contact == '{CONTACT}'"
AS_BUILT = f"{OWN} and varied == '{NOTHING}'"
CHANNELS = {"n": "normal", "t": "tangential"}
TURNS = "fingerprint/cycles.tsv"
# Origin of the interval of the fitted pair.
FIT = "profile of the fit"
INVERSE = "target == 'thesis_reference' and kept == 'normal energy' and fill_ratio == 0.10 and ball_diameter_mm == 5"


@claim("3.restitution")
def restitution(evidence: Evidence) -> Finding:
    """Eq. 3.19: the mean restitution of the virtual drop tests, as the thesis takes the mean of its 32."""
    drops = evidence.rows("calibration/drop_test.tsv", "restitution", f"contact == '{CONTACT}'")
    given, found = drops["restitution_given"].iloc[0], drops["restitution"]
    return Finding(
        float(found.mean()),
        f"mean of {len(drops)} simulated drops with {given:g} put in; from {found.min():.4f} to {found.max():.4f}",
        repeats=repeats_of(found.tolist(), "drops from several heights"),
    )


@claim("3.friction_fit")
def friction_fit(evidence: Evidence) -> Finding:
    """Fig. 3.3: the pair fitted to a simulated track of the calibrated set, as the thesis prints no track to fit."""
    where = f"source == '{SIMULATED}' and contact == '{CONTACT}' and mill == '{MILL}' and track_mill == '{MILL}'"
    same = evidence.rows("calibration/*/friction_fit.tsv", "estimate", where)
    pair = same[same["experiment"] == same["experiment"].iloc[0]].set_index("parameter").loc[list(FRICTION_PAIR)]
    value, lower, upper = ("/".join(f"{end:.4g}" for end in pair[name]) for name in ("estimate", "lower", "upper"))
    return Finding(value, f"{lower} to {upper}", repeats=Repeats(lower, upper, FIT, int(pair["frames"].iloc[0])))


@claim("3.balls.{diameter}mm.{fill}")
def number_of_balls(evidence: Evidence, diameter: str, fill: str) -> Finding:
    """Table 3.4: rounded volume ratios, with the volumes of a jar that give every number as printed."""
    evidence.cite(f"config/mills/{MILL}.yaml", "volume_ml", ball_count)
    printed_ml = load_named(evidence.data.parent / "mills", MILL, MillConfig, "mill").volume_ml
    low, high = _volumes_of_the_table(evidence)
    # The volume is printed in whole millilitres.
    one_jar = low < high and printed_ml - 0.5 < low and high < printed_ml + 0.5
    volume_ml = float(np.clip(printed_ml, low + 1e-6, high - 1e-6)) if one_jar else printed_ml
    diameter_m, fill_ratio = float(diameter) * 1e-3, float(fill)
    exact = fill_ratio * printed_ml * 1e-6 / (np.pi / 6 * diameter_m**3)
    every = f"a jar of {low:.2f} to {high:.2f} mL gives every number of Table 3.4" if low < high else "no jar does"
    told = f"volume of balls over volume of one ball = {exact:.2f} in {printed_ml:g} mL; {every}"
    return Finding(ball_count(fill_ratio, volume_ml * 1e-6, diameter_m), told)


def _volumes_of_the_table(evidence: Evidence) -> tuple[float, float]:
    """The least and the largest volume of a jar [mL] with which every number of Table 3.4 is as printed."""
    bounds = []
    for name, printed in evidence.printed.items():
        if entry := re.fullmatch(r"3\.balls\.(\d+)mm\.(.+)", str(name)):
            ball_ml = np.pi / 6 * (0.1 * float(entry[1])) ** 3 / float(entry[2])
            bounds.append([(int(printed) + half) * ball_ml for half in (-0.5, 0.5)])
    lower, upper = zip(*bounds, strict=True)
    return max(lower), min(upper)


@claim("3.eps.{contact}")
def restitution_of_a_contact_set(evidence: Evidence, contact: str) -> Finding:
    """Eq. 3.30."""
    evidence.cite(f"config/contacts/{contact}.yaml", "restitution, static_friction", effective_restitution)
    values = load_named(evidence.data.parent / "contacts", contact, ContactConfig, "contact set")
    restitution, friction = values.value_of("restitution"), values.value_of("static_friction")
    return Finding(
        effective_restitution(restitution, friction), f"Eq. 3.30 with e = {restitution:g} and mu = {friction:g}"
    )


# Table 3.5, all at fill 0.08: mean dissipation in a revolution [J], and its coefficient of variation [%].
REVOLUTIONS = f"{AS_BUILT} and fill_ratio == 0.08 and ball_diameter_mm == {{diameter}} and speed_rpm == {{speed}}"
for _name, _column in (("cycle", "{letter}_mean_J"), ("cycle_cv", "{letter}_cv_percent")):
    _told = "of {revolutions:.0f} revolutions"
    look_up(f"3.{_name}.{{diameter}}mm.{{speed}}.{{letter}}", TURNS, _column, REVOLUTIONS, _told, letter=CHANNELS)
# The reference case of Sec. 3.3.4.
look_up(
    "3.reference.{letter}",
    "fingerprint/descriptors.tsv",
    "{letter}",
    f"{AS_BUILT} and ball_diameter_mm == 10 and speed_rpm == 600 and fill_ratio == 0.10",
    "{seeds:.0f} seed(s); re-contacts within {collision_gap_turns:g} turns are one collision",
    letter={"En": "normal_energy_J", "Et": "tangential_energy_J", "f": "specific_frequency_hz"},
)
# Sec. 3.3.4: the speed at which 5 mm balls have the energies of the reference case.
look_up(
    "3.inverse.speed",
    "fingerprint/inverse.tsv",
    "speed_rpm",
    f"{INVERSE} and curves == 'published'",
    "keeps the printed normal energy; the specific frequency is then {specific_frequency_hz:.0f} 1/s "
    "({specific_frequency_hz_residual_percent:+.0f} %)",
)


def _stiff_and_soft(evidence: Evidence, columns: str) -> tuple[pd.Series, pd.Series]:
    """The rows of steel, and of a ball a hundred times softer, each at its own time step (Fig. 3.4)."""
    where = f"{OWN} and young_modulus_gpa in (205, 2.05)"
    rows = evidence.rows("convergence/modulus.tsv", columns, where)
    rows = rows.drop_duplicates("young_modulus_gpa").set_index("young_modulus_gpa")
    if len(rows) < 2:
        raise NotRun("the sweep has no pair of cases at 205 and 2.05 GPa")
    return rows.loc[205.0], rows.loc[2.05]


@claim("3.young.speedup")
def speed_up_of_soft_balls(evidence: Evidence) -> Finding:
    """Fig. 3.4: what the larger time step of a softer ball saves."""
    stiff, soft = _stiff_and_soft(evidence, "processor_s")
    told = f"{stiff['processor_s']:.1f} s of processor time at 205 GPa, {soft['processor_s']:.1f} s at 2.05 GPa"
    return Finding(float(stiff["processor_s"] / soft["processor_s"]), told)


@claim("3.young.power")
def power_of_soft_balls(evidence: Evidence) -> Finding:
    """Fig. 3.4: whether a softer ball keeps the power."""
    stiff, soft = _stiff_and_soft(evidence, "power_W, power_two_sigma_W")
    return yes_no(
        abs(soft["power_W"] - stiff["power_W"]) <= stiff["power_two_sigma_W"],
        f"{soft['power_W']:.2f} W at 2.05 GPa, {stiff['power_W']:.2f} +- {stiff['power_two_sigma_W']:.2f} at 205 GPa; "
        f"they differ by {soft['power_deviation_percent']:+.1f} %",
    )


# Between the zones of Sec. 3.3.2.
ELBOW, END_OF_ZONE_2 = 0.10, 0.20
SIZES_MM, CYCLE_SPEEDS = (10, 5), (600, 800, 1000, 1200)
OUT_OF_DOMAIN = "config/data/out_of_domain.tsv"
# The conditions of Table 3.5, with the mill as built.
OF_THE_TABLE = f"mill == '{MILL}' and varied == '{NOTHING}' and fill_ratio == 0.08"
# The run of Sec. 3.3.4 in the table of experiments outside the domain.
EXPERIMENT, REFERENCE_YIELD = 29, "4.case.reference.yield"


def _cycles(evidence: Evidence, contact: str, columns: str) -> pd.DataFrame:
    """Dissipation per revolution at the fill ratio of Table 3.5, of the mill as built."""
    return evidence.rows(TURNS, columns, f"{OF_THE_TABLE} and contact == '{contact}'")


def _over_small(table: pd.DataFrame, letter: str) -> pd.Series:
    """By how much the mean dissipation per revolution of 10 mm balls exceeds that of 5 mm balls, by speed [%].

    Empty where a size is missing.
    """
    values = f"{CHANNELS[letter]}_mean_J"
    means = table.pivot_table(index="speed_rpm", columns="ball_diameter_mm", values=values).reindex(columns=SIZES_MM)
    return (100 * (means[SIZES_MM[0]] / means[SIZES_MM[1]] - 1)).dropna()


@claim("3.size.{contact}.{letter}")
def difference_between_sizes(evidence: Evidence, contact: str, letter: str) -> Finding:
    """Sec. 3.3.1: by how much the mean dissipation per revolution of 10 and of 5 mm balls differ, over four speeds."""
    apart = _over_small(_cycles(evidence, contact, f"{CHANNELS[letter]}_mean_J"), letter)
    if len(apart) < len(CYCLE_SPEEDS):
        raise NotRun(f"the sweep lacks a ball size or a speed of contact set {contact} at fill 0.08")
    told = ", ".join(f"{value:+.0f} % at {speed:.0f} rpm" for speed, value in apart.items())
    return Finding(abs(float(apart.mean())), f"10 mm over 5 mm: {told}")


def _by_size(evidence: Evidence, columns: str) -> pd.DataFrame:
    """Dissipation per revolution by ball size and speed, calibrated; not run unless every one of Table 3.5 is there."""
    table = _cycles(evidence, CONTACT, columns).set_index(["ball_diameter_mm", "speed_rpm"]).sort_index()
    if not set(itertools.product(SIZES_MM, CYCLE_SPEEDS)) <= set(table.index):
        raise NotRun(f"the sweep lacks a ball size or a speed of contact set {CONTACT} at fill 0.08")
    return table


def _over_speeds(evidence: Evidence) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Means per revolution at the least and the largest speed [J]: ball sizes in rows, a column for each channel."""
    columns = [f"{channel}_mean_J" for channel in CHANNELS.values()]
    means = _by_size(evidence, ", ".join(columns))[columns].set_axis(list(CHANNELS.values()), axis="columns")
    slow, fast = (means.xs(speed, level="speed_rpm") for speed in (CYCLE_SPEEDS[0], CYCLE_SPEEDS[-1]))
    return slow, fast


@claim("3.speed.rise")
def rise_with_the_speed(evidence: Evidence) -> Finding:
    """Sec. 3.3.1, Fig. 3.6: that the tangential dissipation rises by more joules than the normal, 600 to 1200 rpm."""
    slow, fast = _over_speeds(evidence)
    rise = (fast - slow).reset_index()
    told = in_words(rise, "tangential {tangential:+.2f} J, normal {normal:+.2f} J with {ball_diameter_mm:g} mm", "; ")
    return yes_no(bool((rise["tangential"] > rise["normal"]).all()), told)


@claim("3.speed.ratio")
def ratio_over_the_speeds(evidence: Evidence) -> Finding:
    """Sec. 3.3.1: the same as a ratio of the dissipation at 1200 to that at 600 rpm, for both ball sizes.

    Of the means that Table 3.5 implies, this ratio is larger for the tangential dissipation only with 10 mm balls.
    """
    slow, fast = _over_speeds(evidence)
    ratio = (fast / slow).reset_index()
    told = in_words(ratio, "tangential {tangential:.1f}, normal {normal:.1f} times with {ball_diameter_mm:g} mm", "; ")
    return yes_no(bool((ratio["tangential"] > ratio["normal"]).all()), told)


@claim("3.scatter.size")
def scatter_of_smaller_balls(evidence: Evidence) -> Finding:
    """Sec. 3.3.1: that deviation and coefficient of variation are smaller with 5 than with 10 mm balls.

    In both directions, in the mean over the speeds: one speed has too few revolutions.
    """
    columns = [f"{channel}_{part}" for channel in CHANNELS.values() for part in ("sd_J", "cv_percent")]
    means = _by_size(evidence, ", ".join(columns))[columns].groupby("ball_diameter_mm").mean()
    small, large = means.loc[SIZES_MM[1]], means.loc[SIZES_MM[0]]
    told = ", ".join(f"{name} {small[name]:.3g} for {large[name]:.3g}" for name in columns)
    return yes_no(bool((small < large).all()), f"means over the speeds, 5 for 10 mm: {told}")


@claim("3.centre.empty")
def empty_centre(evidence: Evidence) -> Finding:
    """Sec. 3.3.2, Fig. 3.9: that at fill 0.10 nothing collides in the centre of the jar with calibrated contacts."""
    evidence.cite("config/config.yaml", "fingerprint.maps", empty_centre)
    raise NotRun("no table has where balls collide; the heat maps of the report show where they are")


def implied_difference(printed: pd.Series, letter: str) -> float:
    """By how much the means that Table 3.5 implies differ, 10 over 5 mm, mean over the speeds [%]."""
    large, small = (
        printed[[f"3.cycle.{size}mm.{speed}.{letter}" for speed in CYCLE_SPEEDS]].astype(float).to_numpy()
        for size in SIZES_MM
    )
    return 100 * float((large / small - 1).mean())


def misfit_of_the_revolutions(evidence: Evidence, contact: str) -> float | None:
    """Root mean square of log(ours / those of Table 3.5) over its 16 means [%]; None where the sweep lacks one."""
    columns = [f"{channel}_mean_J" for channel in CHANNELS.values()]
    table = evidence.table(TURNS, f"{OF_THE_TABLE} and contact == '{contact}'")
    logs = [
        np.log(
            row[column] / float(evidence.printed[f"3.cycle.{row['ball_diameter_mm']:g}mm.{row['speed_rpm']:g}.{own}"])
        )
        for row in table.to_dict("records")
        if row["ball_diameter_mm"] in SIZES_MM and row["speed_rpm"] in CYCLE_SPEEDS
        for own, column in zip(CHANNELS, columns, strict=True)
    ]
    needed = len(SIZES_MM) * len(CYCLE_SPEEDS) * len(CHANNELS)
    return 100 * float(np.sqrt(np.mean(np.square(logs)))) if len(logs) == needed else None


def _energies(evidence: Evidence, contact: str, diameter: int, letter: str) -> pd.DataFrame:
    """Energies of a collision by fill ratio (rows) and speed (columns)."""
    column = f"{CHANNELS[letter]}_energy_J"
    where = f"mill == '{MILL}' and contact == '{contact}' and varied == '{NOTHING}' and ball_diameter_mm == {diameter}"
    rows = evidence.rows("fingerprint/descriptors.tsv", column, where)
    table = rows.pivot_table(index="fill_ratio", columns="speed_rpm", values=column).dropna(axis="columns")
    in_zone_2 = (table.index > ELBOW) & (table.index <= END_OF_ZONE_2)
    if table.empty or ELBOW not in table.index or not in_zone_2.any():
        raise NotRun(f"the sweep does not span the zones with {diameter} mm balls of contact set {contact}")
    return table


@claim("3.zone.{contact}.{size}.{letter}")
def change_between_zones(evidence: Evidence, contact: str, size: str, letter: str) -> Finding:
    """Sec. 3.3.2: from the end of zone 1, at fill 0.10, to the most or the least of zone 2, over the speeds.

    Where energies are said to be stable, the larger of both changes.
    """
    table = _energies(evidence, contact, int(size), letter)
    printed = float(evidence.printed[evidence.id])
    zone = table[(table.index > ELBOW) & (table.index <= END_OF_ZONE_2)]
    rise, fall = (100 * (extreme / table.loc[ELBOW] - 1) for extreme in (zone.max(), zone.min()))
    is_rise = printed > 0 or (printed == 0 and rise.max() > -fall.min())
    changes = rise if is_rise else fall
    told = ", ".join(f"{value:+.0f} % at {speed:.0f} rpm" for speed, value in changes.items())
    value = float(changes.max() if is_rise else changes.min())
    if printed < -100:
        told += f"; over what is left of it, {change_percent(1 + value / 100, 1):.0f} %"
    contradiction = Contradiction(
        "Eq. 3.21, a mean of energies that are not negative",
        f"it cannot fall by more than 100 %, and {printed:g} % is said",
    )
    return Finding(value, told, contradiction=contradiction if printed < -100 else None)


@claim("3.optimum.{contact}")
def fill_of_the_largest_energy(evidence: Evidence, contact: str) -> Finding:
    """Sec. 3.3.2: the fill ratio of the largest normal energy of a collision, 10 mm balls, mean over the speeds [%]."""
    table = _energies(evidence, contact, 10, "n")
    means = (table / table.max()).mean(axis="columns")
    told = ", ".join(f"{value:.2f} at {fill:g}" for fill, value in means.nlargest(3).items())
    return Finding(100 * float(means.idxmax()), f"energy over its largest, by fill ratio: {told}")


@claim("3.inverse.balls")
def more_balls(evidence: Evidence) -> Finding:
    """Sec. 3.3.4."""
    few, many = (float(evidence.printed[f"3.balls.{size}.0.10"]) for size in ("10mm", "5mm"))
    evidence.cite("config/data/claims.tsv", "3.balls.10mm.0.10, 3.balls.5mm.0.10", change_percent)
    return Finding(change_percent(few, many), f"{many:g} after {few:g} balls")


@claim("3.inverse.frequency")
def frequency_at_the_higher_speed(evidence: Evidence) -> Finding:
    """Sec. 3.3.4: the specific collision frequency at that speed over that of the reference, which is said to be kept.

    An erratum: by Eq. 3.29 it goes with the speed, and the speed is another one.
    """
    off = "specific_frequency_hz_residual_percent"
    row = evidence.row("fingerprint/inverse.tsv", off, f"{INVERSE} and curves == 'published'")
    value, frequency = 1 + row[off] / 100, row["specific_frequency_hz"]
    return Finding(
        float(value),
        f"{frequency / value:.0f} 1/s before, {frequency:.0f} 1/s at {row['speed_rpm']:.0f} rpm",
        contradiction=Contradiction(
            "Eq. 3.29", f"at one fill ratio the frequency goes with the speed: {value:.2f} times"
        ),
    )


@claim("3.inverse.increase")
def higher_speed(evidence: Evidence) -> Finding:
    """Sec. 3.3.4: the speed that keeps the energies, over the 600 rpm of the reference."""
    row = evidence.row("fingerprint/inverse.tsv", "speed_rpm", f"{INVERSE} and curves == 'published'")
    reference = 60 * float(evidence.printed["4.case.reference.speed"])
    speed = float(row["speed_rpm"])
    return Finding(change_percent(reference, speed), f"{speed:.0f} after {reference:g} rpm")


@claim("3.experiment.measured")
def yield_of_the_experiment(evidence: Evidence) -> Finding:
    """Sec. 3.3.4: the yield of the run that was chosen by the master curves."""
    return Finding(_measured_yield(evidence), "measured, twice")


def _measured_yield(evidence: Evidence) -> float:
    return datum(evidence, OUT_OF_DOMAIN, "case", EXPERIMENT, "yield_percent")


# Sec. 3.3.4: the same yield as that of the reference is predicted; ours is by the two-step GPR of chapter 5.
look_up(
    "3.experiment.predicted",
    "yield/out_of_domain.tsv",
    "predicted_percent",
    f"case == {EXPERIMENT} and strategy == 'two_step' and model == 'gpr'",
    "from the kept energies and the collisions of Eq. 3.29 at 1698 rpm; measured {yield_percent:g} %",
)


@claim("3.experiment.difference")
def yield_below_the_reference(evidence: Evidence) -> Finding:
    """Sec. 3.3.4: how far the run is below the reference case; a difference of yields is one in points."""
    evidence.cite("config/data/claims.tsv", REFERENCE_YIELD, in_points)
    measured, first = _measured_yield(evidence), float(evidence.printed[REFERENCE_YIELD])
    return Finding(first - measured, in_points(first, measured))


def curves_of(evidence: Evidence, columns: str, where: str = "", contact: str = CONTACT) -> pd.DataFrame:
    """Means over the conditions of a contact set, a row a fill ratio; not run if they are of another mill."""
    found = evidence.rows(f"fingerprint/means_{contact}.tsv", columns, where)
    _check_mill(evidence, contact)
    return found


def _check_mill(evidence: Evidence, contact: str) -> None:
    if evidence.table(f"fingerprint/fingerprint_{contact}.json")["about"].iloc[0].get("mill") != MILL:
        raise NotRun(f"the master curves are not of mill {MILL}")


@claim("3.curve.{fill}.{quantity}")
def curve_value(evidence: Evidence, fill: str, quantity: str) -> Finding:
    """Fig. 3.12 and Table 4.2: a value of the calibrated master curves at one fill ratio."""
    row = curves_of(evidence, quantity, f"fill_ratio == {fill}").iloc[0]
    spread = 100 * (row[f"{quantity}_upper"] / row[quantity] - 1)
    return Finding(float(row[quantity]), f"mean of {int(row['conditions'])} condition(s), spread {spread:.1f} %")


@claim("3.curve.ratio.low")
@claim("3.curve.ratio.elbow")
@claim("3.curve.ratio.high")
def ratio_of_the_curves(evidence: Evidence) -> Finding:
    """Fig. 3.12 d: the largest ratio up to the elbow at fill 0.10, that at the elbow, and the mean over zone 3."""
    part = evidence.id.rpartition(".")[2]
    where = {"low": "fill_ratio <= 0.10", "elbow": "fill_ratio == 0.10", "high": "fill_ratio >= 0.20"}[part]
    curves = curves_of(evidence, "ratio", where)
    value = curves["ratio"].mean() if part == "high" else curves["ratio"].max()
    return Finding(float(value), in_words(curves, "{ratio:.2f} at fill {fill_ratio:g}"))


def _whole_curves(evidence: Evidence, columns: str) -> pd.DataFrame:
    """The curves, if they show on which side of fill 0.20 the powers of one ball are largest."""
    curves = curves_of(evidence, columns)
    if curves["fill_ratio"].max() <= 0.20 or curves["fill_ratio"].min() > 0.06:
        raise NotRun("the calibrated cases of the sweep do not span the fills 0.06 to over 0.20")
    return curves


@claim("3.curve.normal_max")
def fill_of_largest_normal_power(evidence: Evidence) -> Finding:
    """Fig. 3.12 a."""
    curves = _whole_curves(evidence, "Pn")
    top = curves.loc[curves["Pn"].idxmax(), "fill_ratio"]
    return yes_no(0.10 <= top <= 0.20, f"the mean curve is largest at fill {top:g}")


@claim("3.curve.tangential_max")
def fill_of_largest_tangential_power(evidence: Evidence) -> Finding:
    """Sec. 3.3.3, Fig. 3.12 b."""
    curves = _whole_curves(evidence, "Pt")
    top = curves.loc[curves["Pt"].idxmax(), "fill_ratio"]
    return yes_no(bool(top <= 0.08), f"the mean curve is largest at fill {top:g}")


@claim("3.curve.zone3")
def gain_beyond_zone_2(evidence: Evidence) -> Finding:
    """Fig. 3.12 a and b."""
    curves = _whole_curves(evidence, "Pn, Pt")
    beyond, before = (own[["Pn", "Pt"]].max() for _, own in curves.groupby(curves["fill_ratio"] <= 0.20))
    gains = 100 * (beyond / before - 1)
    told = f"Pn {gains['Pn']:+.1f} %, Pt {gains['Pt']:+.1f} % beyond fill 0.20 against the largest up to it"
    return yes_no(bool(gains.max() <= 0), told)


@claim("3.curve.tangential")
def larger_channel(evidence: Evidence) -> Finding:
    """Sec. 3.4: that the tangential dissipation is larger than the normal one, at every fill ratio."""
    curves = _whole_curves(evidence, "ratio")
    told = in_words(curves, "{ratio:.2f} at {fill_ratio:g}")
    return yes_no(bool((curves["ratio"] > 1).all()), f"tangential over normal power by fill: {told}")


@claim("3.level.{contact}")
def frequency_in_zone_3(evidence: Evidence, contact: str) -> Finding:
    """Sec. 3.3.2: the change of the specific collision frequency from fill 0.20 to the last of zone 3 [%]."""
    curves = curves_of(evidence, "f", "fill_ratio >= 0.20", contact)
    if len(curves) < 2:
        raise NotRun(f"the sweep has no fills of 0.20 and more with contact set {contact}")
    told = in_words(curves, "{f:.1f} at {fill_ratio:g}")
    return Finding(change_percent(curves["f"].iloc[0], curves["f"].iloc[-1]), f"by fill: {told}")


def rank_correlation(first: pd.Series, second: pd.Series) -> float:
    """Spearman's rank correlation: that of the ranks, the mean rank where values are equal.

    scipy.stats gives the same, but to import it takes as long as all claims.
    """
    return float(np.corrcoef(first.rank(), second.rank())[1, 0])


@claim("3.frequency.{contact}")
def trend_of_the_frequency(evidence: Evidence, contact: str) -> Finding:
    """Figs 3.7 d and 3.8 d: falling with fill for calibrated contacts, rising for steel, by rank and by its ends."""
    curves = curves_of(evidence, "f", contact=contact)
    if len(curves) < 3:
        raise NotRun(f"the sweep has fewer than three fill ratios with contact set {contact}")
    rank = rank_correlation(curves["fill_ratio"], curves["f"])
    first, last = curves.iloc[0], curves.iloc[-1]
    sign = {"calibrated": -1, "steel": 1}[contact]
    return yes_no(
        sign * rank > 0 and sign * (last["f"] - first["f"]) > 0,
        f"{first['f']:.1f} at fill {first['fill_ratio']:g}, {last['f']:.1f} at {last['fill_ratio']:g}; {rank:+.2f}",
    )


@claim("3.growth")
def growth_of_the_collisions(evidence: Evidence) -> Finding:
    """Sec. 3.3.2: that all collisions become more with the fill ratio in both contact sets, and less so calibrated."""
    grown, words = {}, []
    for contact in (CONTACT, "steel"):
        curves = curves_of(evidence, "f", contact=contact)
        if len(curves) < 3:
            raise NotRun(f"the sweep has fewer than three fill ratios with contact set {contact}")
        collisions = curves["f"] * curves["fill_ratio"]
        grown[contact] = float(collisions.iloc[-1] / collisions.iloc[0])
        ends = f"{curves['fill_ratio'].iloc[0]:g} to {curves['fill_ratio'].iloc[-1]:g}"
        words.append(f"{contact} {grown[contact]:.1f} times from fill {ends}")
    return yes_no(1 < grown[CONTACT] < grown["steel"], ", ".join(words))


@claim("3.collapse")
def collapse(evidence: Evidence) -> Finding:
    """Fig. 3.12: the spread over the mean at each fill ratio, before and after the normalisation."""
    where = f"scope == '{CONTACT}' and compared == '{MACHINE}' and quantity in ('Pn', 'Pt', 'f')"
    own = evidence.rows("fingerprint/collapse.tsv", "spread_scaled", where)
    _check_mill(evidence, CONTACT)
    worst = own.loc[own["spread_scaled"].idxmax()]
    told = f"the largest, of {worst['quantity']} at fill {worst['fill_ratio']:g}; the median over quantities and fills "
    told += f"is {100 * own['spread_scaled'].median():.1f} %"
    return Finding(float(100 * worst["spread_scaled"]), told)


@claim("3.universal")
def universal_collapse(evidence: Evidence) -> Finding:
    """Fig. 3.14: both contact sets collapse if the factor narrows the median spread of each quantity."""
    columns, where = "spread_scaled, spread_universal", "scope == 'universal' and quantity in ('Pn', 'Pt', 'f')"
    pooled = evidence.rows("fingerprint/collapse.tsv", columns, where)
    median = 100 * pooled.groupby("quantity")[["spread_scaled", "spread_universal"]].median()
    told = in_words(median.reset_index(), "{quantity} {spread_scaled:.1f} to {spread_universal:.1f} %", "; ")
    return yes_no(bool((median["spread_universal"] < median["spread_scaled"]).all()), f"median spreads: {told}")
