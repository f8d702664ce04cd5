"""Claims in the text of thesis chapter 3: ball sizes, zones of the fill ratio, and the test of the master curves."""

import pandas as pd

from millprint.fingerprint.descriptors import NOTHING
from millprint.run.files import read_table
from millprint.thesis.claims.chapter2_text import change_percent
from millprint.thesis.claims.chapter3 import INVERSE
from millprint.thesis.claims.chapter3_causes import CHANNELS, CONTACT, MILL
from millprint.thesis.claims.evidence import Contradiction, Evidence, Finding, NotRun, as_printed, claim
from millprint.thesis.claims.tolerances import agrees

# Between the zones of Sec. 3.3.2.
ELBOW, END_OF_ZONE_2 = 0.10, 0.20
SIZES_MM, CYCLE_SPEEDS = (10, 5), (600, 800, 1000, 1200)
OUT_OF_DOMAIN = "config/data/out_of_domain.tsv"
# The run of Sec. 3.3.4 in that table.
EXPERIMENT, REFERENCE_YIELD = 29, "4.case.reference.yield"


@claim(
    "3.cycle_sd.{diameter}mm.{speed}.{letter}",
    """
    3.cycle_sd.5mm.600.n 3.cycle_sd.5mm.800.n 3.cycle_sd.5mm.1000.n 3.cycle_sd.5mm.1200.n
    3.cycle_sd.5mm.600.t 3.cycle_sd.5mm.800.t 3.cycle_sd.5mm.1000.t 3.cycle_sd.5mm.1200.t
    3.cycle_sd.10mm.600.n 3.cycle_sd.10mm.800.n 3.cycle_sd.10mm.1000.n 3.cycle_sd.10mm.1200.n
    3.cycle_sd.10mm.600.t 3.cycle_sd.10mm.800.t 3.cycle_sd.10mm.1000.t 3.cycle_sd.10mm.1200.t
    """,
)
def deviation_of_revolutions(evidence: Evidence, diameter: str, speed: str, letter: str) -> Finding:
    """Table 3.5: the standard deviation of the dissipation in one revolution [J]."""
    column = f"{CHANNELS[letter]}_sd_J"
    row = _cycles(evidence, CONTACT, column, f" and ball_diameter_mm == {diameter} and speed_rpm == {speed}").iloc[0]
    return Finding(float(row[column]), f"of {int(row['revolutions'])} revolutions")


# Revolutions at the fill ratio of Table 3.5, of the mill as built.
CYCLES = f"mill == '{MILL}' and varied == '{NOTHING}' and fill_ratio == 0.08"


def _cycles(evidence: Evidence, contact: str, columns: str, where: str = "") -> pd.DataFrame:
    """Dissipation per revolution at the fill ratio of Table 3.5, of the mill as built."""
    absent = f"the sweep has no such revolutions of contact set {contact} at fill 0.08"
    return evidence.rows("fingerprint/cycles.tsv", columns, f"{CYCLES} and contact == '{contact}'{where}", absent)


def size_cause(evidence: Evidence, contact: str, letter: str) -> str:
    """The difference in both directions with every contact set, and what Table 3.5 implies."""
    table = evidence.table("fingerprint/cycles.tsv", CYCLES)
    words = []
    for name, own in table.groupby("contact"):
        means = {CHANNELS[each]: _over_small(own, each).mean() for each in CHANNELS}
        words.append(f"with {name} {', '.join(f'{channel} {value:+.0f} %' for channel, value in means.items())}")
    implied = ", ".join(f"{CHANNELS[each]} {implied_difference(evidence.printed, each):+.0f} %" for each in CHANNELS)
    return (
        f"in both directions {'; '.join(words)}; the means that Table 3.5 implies: {implied}. No counting rule enters "
        "a dissipation per revolution. Not explained"
    )


def _over_small(table: pd.DataFrame, letter: str) -> pd.Series:
    """By how much the mean dissipation per revolution of 10 mm balls exceeds that of 5 mm balls, by speed [%].

    Empty where a size is missing.
    """
    values = f"{CHANNELS[letter]}_mean_J"
    means = table.pivot_table(index="speed_rpm", columns="ball_diameter_mm", values=values).reindex(columns=SIZES_MM)
    return (100 * (means[SIZES_MM[0]] / means[SIZES_MM[1]] - 1)).dropna()


@claim("3.size.{contact}.{letter}", "3.size.steel.t 3.size.calibrated.n", size_cause)
def difference_between_sizes(evidence: Evidence, contact: str, letter: str) -> Finding:
    """Sec. 3.3.1: by how much the mean dissipation per revolution of 10 and of 5 mm balls differ, over four speeds."""
    apart = _over_small(_cycles(evidence, contact, f"{CHANNELS[letter]}_mean_J"), letter)
    if len(apart) < len(CYCLE_SPEEDS):
        raise NotRun(f"the sweep lacks a ball size or a speed of contact set {contact} at fill 0.08")
    told = ", ".join(f"{value:+.0f} % at {speed:.0f} rpm" for speed, value in apart.items())
    return Finding(abs(float(apart.mean())), f"10 mm over 5 mm: {told}")


def implied_difference(printed: pd.Series, letter: str) -> float:
    """By how much the means that Table 3.5 implies differ, 10 over 5 mm, mean over the speeds [%]."""
    large, small = (
        printed[[f"3.cycle.{size}mm.{speed}.{letter}" for speed in CYCLE_SPEEDS]].astype(float).to_numpy()
        for size in SIZES_MM
    )
    return 100 * float((large / small - 1).mean())


def _energies(evidence: Evidence, contact: str, diameter: int, letter: str) -> pd.DataFrame:
    """Energies of a collision by fill ratio (rows) and speed (columns)."""
    column = f"{CHANNELS[letter]}_energy_J"
    where = f"mill == '{MILL}' and contact == '{contact}' and varied == '{NOTHING}' and ball_diameter_mm == {diameter}"
    absent = f"the sweep does not span the zones with {diameter} mm balls of contact set {contact}"
    rows = evidence.rows("fingerprint/descriptors.tsv", column, where, absent)
    table = rows.pivot_table(index="fill_ratio", columns="speed_rpm", values=column).dropna(axis="columns")
    in_zone_2 = (table.index > ELBOW) & (table.index <= END_OF_ZONE_2)
    if table.empty or ELBOW not in table.index or not in_zone_2.any():
        raise NotRun(absent)
    return table


@claim(
    "3.zone.{contact}.{size}.{letter}",
    "3.zone.calibrated.10.n 3.zone.steel.10.n 3.zone.steel.5.n 3.zone.steel.10.t 3.zone.calibrated.10.t",
)
def change_between_zones(evidence: Evidence, contact: str, size: str, letter: str) -> Finding:
    """Sec. 3.3.2: from the end of zone 1, at fill 0.10, to the most or the least of zone 2, over the speeds."""
    table = _energies(evidence, contact, int(size), letter)
    printed = float(evidence.printed[evidence.id])
    zone = table[(table.index > ELBOW) & (table.index <= END_OF_ZONE_2)]
    changes = 100 * ((zone.max() if printed > 0 else zone.min()) / table.loc[ELBOW] - 1)
    told = ", ".join(f"{value:+.0f} % at {speed:.0f} rpm" for speed, value in changes.items())
    value = float(changes.max() if printed > 0 else changes.min())
    contradiction = Contradiction(
        "Eq. 3.21, a mean of energies that are not negative",
        f"it cannot fall by more than 100 %, and {printed:g} % is said",
    )
    return Finding(value, told, contradiction=contradiction if printed < -100 else None)


@claim("3.optimum.{contact}", "3.optimum.calibrated 3.optimum.steel")
def fill_of_the_largest_energy(evidence: Evidence, contact: str) -> Finding:
    """Sec. 3.3.2: the fill ratio of the largest normal energy of a collision, 10 mm balls, mean over the speeds [%]."""
    table = _energies(evidence, contact, 10, "n")
    means = (table / table.max()).mean(axis="columns")
    near = means.nlargest(3)
    told = ", ".join(f"{value:.2f} at {fill:g}" for fill, value in near.items())
    return Finding(100 * float(means.idxmax()), f"energy over its largest, by fill ratio: {told}")


@claim("3.inverse.balls")
def more_balls(evidence: Evidence) -> Finding:
    """Sec. 3.3.4."""
    few, many = (float(evidence.printed[f"3.balls.{size}.0.10"]) for size in ("10mm", "5mm"))
    evidence.cite("config/data/claims.tsv", "3.balls.10mm.0.10, 3.balls.5mm.0.10", change_percent)
    return Finding(change_percent(few, many), f"{many:g} after {few:g} balls")


@claim("3.inverse.increase")
def higher_speed(evidence: Evidence) -> Finding:
    """Sec. 3.3.4: the speed that keeps the energies, over the 600 rpm of the reference."""
    absent = "fingerprint.inverse does not ask for thesis_reference at fill 0.10 with 5 mm balls"
    row = evidence.row("fingerprint/inverse.tsv", "speed_rpm", f"{INVERSE} and curves == 'published'", absent)
    reference = 60 * float(evidence.printed["4.case.reference.speed"])
    return Finding(
        change_percent(reference, float(row["speed_rpm"])), f"{row['speed_rpm']:.0f} after {reference:g} rpm"
    )


@claim("3.experiment.measured")
def yield_of_the_experiment(evidence: Evidence) -> Finding:
    """Sec. 3.3.4: the yield of the run that was chosen by the master curves."""
    return Finding(_measured_yield(evidence), "measured, twice")


def _measured_yield(evidence: Evidence) -> float:
    evidence.cite(OUT_OF_DOMAIN, f"yield_percent of case {EXPERIMENT}", read_table)
    runs = read_table(evidence.data / "out_of_domain.tsv", numeric=["yield_percent"], text=["case"])
    own = runs.loc[runs["case"] == str(EXPERIMENT), "yield_percent"]
    if own.empty:
        raise NotRun(f"{OUT_OF_DOMAIN} has no case {EXPERIMENT}")
    return float(own.iloc[0])


@claim("3.experiment.predicted")
def prediction_of_the_experiment(evidence: Evidence) -> Finding:
    """Sec. 3.3.4: the run as a run predicted, by the two-step GPR of chapter 5 from its descriptors."""
    path, own = "yield/out_of_domain.tsv", f"case == {EXPERIMENT} and strategy == 'two_step'"
    row = evidence.row(
        path, "predicted_percent", f"{own} and model == 'gpr'", f"results/{path} has no run of Sec. 3.3.4"
    )
    others = evidence.table(path, f"{own} and model != 'gpr'")
    words = ", ".join(f"{other.model} {other.predicted_percent:.0f} %" for other in others.itertuples())
    return Finding(
        float(row["predicted_percent"]),
        f"from the kept energies and the collisions of Eq. 3.29 at 1698 rpm; measured {row['yield_percent']:g} %"
        f"{'; other models: ' if words else ''}{words}",
    )


@claim("3.experiment.difference")
def yield_below_the_reference(evidence: Evidence) -> Finding:
    """Sec. 3.3.4: how far the run is below the reference case."""
    evidence.cite("config/data/claims.tsv", REFERENCE_YIELD, change_percent)
    measured, rests = _measured_yield(evidence), f"{REFERENCE_YIELD} 3.experiment.measured"
    printed = [float(evidence.printed[name]) for name in rests.split()]
    below = -change_percent(*printed)
    stands = not agrees(evidence.printed[evidence.id], "printed", below) and as_printed(evidence, rests)
    contradiction = Contradiction(
        "the yields in the same sentence",
        f"from {printed[0]:g} to {printed[1]:g} % is {printed[0] - printed[1]:g} points, and {below:.1f} % less",
    )
    value = -change_percent(printed[0], measured)
    return Finding(value, f"{measured:g} after {printed[0]:g} %", contradiction=contradiction if stands else None)
