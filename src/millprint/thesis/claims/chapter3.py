"""Claims of thesis chapter 3: calibration, numbers of balls, single revolutions, the reference case, the modulus."""

import numpy as np
import pandas as pd

from millprint.config.contact_set import ContactConfig
from millprint.config.load import load_named
from millprint.config.mill import MillConfig
from millprint.config.sweep import ball_count
from millprint.fingerprint.condition import effective_restitution
from millprint.thesis.calibration.names import FRICTION_PAIR, SIMULATED
from millprint.thesis.claims.chapter3_causes import (
    AS_BUILT,
    CHANNELS,
    CONTACT,
    MILL,
    OWN,
    energy_cause,
    mean_cause,
    spread_cause,
)
from millprint.thesis.claims.evidence import CLAIMS, Evidence, Finding, Interval, NotRun, claim, interval_of, yes_no

# Origin of the interval of the fitted pair.
FIT = "profile of the fit"
INVERSE = "target == 'thesis_reference' and kept == 'normal energy' and fill_ratio == 0.10 and ball_diameter_mm == 5"


@claim("3.restitution")
def restitution(evidence: Evidence) -> Finding:
    """Eq. 3.19: the mean restitution of the virtual drop tests, as the thesis takes the mean of its 32."""
    absent = f"contact set {CONTACT} is not in the run"
    drops = evidence.rows("calibration/drop_test.tsv", "restitution", f"contact == '{CONTACT}'", absent)
    given, found = drops["restitution_given"].iloc[0], drops["restitution"]
    return Finding(
        float(found.mean()),
        f"mean of {len(drops)} simulated drops with {given:g} put in; from {found.min():.4f} to {found.max():.4f}",
        interval=interval_of(found.tolist(), "drops from several heights"),
    )


@claim("3.friction_fit")
def friction_fit(evidence: Evidence) -> Finding:
    """Fig. 3.3: the pair fitted to a simulated track of the calibrated set, as the thesis prints no track to fit."""
    path = "calibration/*/friction_fit.tsv"
    simulated = f"source == '{SIMULATED}' and contact == '{CONTACT}' and mill == '{MILL}'"
    same = evidence.rows(
        path,
        "estimate",
        f"{simulated} and track_mill == '{MILL}'",
        f"calibration.oscillation has no simulated experiment of contact set {CONTACT} in mill {MILL}",
    )
    pair = same[same["experiment"] == same["experiment"].iloc[0]].set_index("parameter").loc[list(FRICTION_PAIR)]
    lower, upper = ("/".join(f"{end:.4g}" for end in pair[name]) for name in ("lower", "upper"))
    intervals = " and ".join(f"{row.lower:.4g} to {row.upper:.4g}" for row in pair.itertuples())
    told = [
        f"; a track made in {name} gives {'/'.join(f'{value:.3g}' for value in other['estimate'])} here"
        for name, other in evidence.table(path, f"{simulated} and track_mill != '{MILL}'").groupby("track_mill")
    ]
    return Finding(
        "/".join(f"{value:.4g}" for value in pair["estimate"]),
        f"fitted to a simulated track of {pair['frames'].iloc[0]:.0f} frames that misses it by "
        f"{pair['rms_mm'].iloc[0]:.2g} mm; intervals {intervals}; the thesis prints no track{''.join(told)}",
        interval=Interval(lower, upper, FIT, int(pair["frames"].iloc[0])),
    )


@claim(
    "3.balls.{diameter}mm.{fill}",
    """
    3.balls.10mm.0.04 3.balls.10mm.0.06 3.balls.10mm.0.08 3.balls.10mm.0.10 3.balls.10mm.0.12 3.balls.10mm.0.16
    3.balls.10mm.0.20 3.balls.10mm.0.30 3.balls.10mm.0.40
    3.balls.5mm.0.04 3.balls.5mm.0.06 3.balls.5mm.0.08 3.balls.5mm.0.10 3.balls.5mm.0.12 3.balls.5mm.0.16
    3.balls.5mm.0.20 3.balls.5mm.0.30 3.balls.5mm.0.40
    """,
)
def number_of_balls(evidence: Evidence, diameter: str, fill: str) -> Finding:
    """Table 3.4: rounded volume ratios, with the volumes of a jar that give every number as printed."""
    evidence.cite(f"config/mills/{MILL}.yaml", "volume_ml", ball_count)
    volume_m3 = load_named(evidence.data.parent / "mills", MILL, MillConfig, "mill").volume_ml * 1e-6
    diameter_m, fill_ratio = float(diameter) * 1e-3, float(fill)
    count, exact = ball_count(fill_ratio, volume_m3, diameter_m), fill_ratio * volume_m3 / (np.pi / 6 * diameter_m**3)
    low, high = _volumes_of_the_table(evidence)
    every = f"a jar of {low:.2f} to {high:.2f} mL gives every number of Table 3.4" if low < high else "no jar does"
    return Finding(count, f"volume of balls over volume of one ball = {exact:.2f} in {1e6 * volume_m3:g} mL; {every}")


def _volumes_of_the_table(evidence: Evidence) -> tuple[float, float]:
    """The least and the largest volume of a jar [mL] with which every number of Table 3.4 is as printed."""
    bounds = []
    for own in CLAIMS.values():
        if own.find is number_of_balls:
            ball_ml = np.pi / 6 * (0.1 * float(own.parts["diameter"])) ** 3 / float(own.parts["fill"])
            bounds.append([(int(evidence.printed[own.id]) + half) * ball_ml for half in (-0.5, 0.5)])
    lower, upper = zip(*bounds, strict=True)
    return max(lower), min(upper)


@claim("3.eps.{contact}", "3.eps.calibrated 3.eps.steel")
def restitution_of_a_contact_set(evidence: Evidence, contact: str) -> Finding:
    """Eq. 3.30."""
    evidence.cite(f"config/contacts/{contact}.yaml", "restitution, static_friction", effective_restitution)
    values = load_named(evidence.data.parent / "contacts", contact, ContactConfig, "contact set")
    return Finding(
        effective_restitution(values.restitution, values.static_friction),
        f"Eq. 3.30 with e = {values.restitution:g} and mu = {values.static_friction:g}",
    )


def _revolutions(evidence: Evidence, diameter: str, speed: str, column: str) -> pd.Series:
    """Revolutions of a condition of Table 3.5, all at fill 0.08."""
    where = f"{AS_BUILT} and fill_ratio == 0.08 and ball_diameter_mm == {diameter} and speed_rpm == {speed}"
    absent = f"the sweep has no calibrated case of {diameter} mm at {speed} rpm and fill 0.08"
    return evidence.row("fingerprint/cycles.tsv", column, where, absent)


@claim(
    "3.cycle.{diameter}mm.{speed}.{letter}",
    """
    3.cycle.5mm.600.n 3.cycle.5mm.800.n 3.cycle.5mm.1000.n 3.cycle.5mm.1200.n
    3.cycle.5mm.600.t 3.cycle.5mm.800.t 3.cycle.5mm.1000.t 3.cycle.5mm.1200.t
    3.cycle.10mm.600.n 3.cycle.10mm.800.n 3.cycle.10mm.1000.n 3.cycle.10mm.1200.n
    3.cycle.10mm.600.t 3.cycle.10mm.800.t 3.cycle.10mm.1000.t 3.cycle.10mm.1200.t
    """,
    mean_cause,
)
def mean_of_revolutions(evidence: Evidence, diameter: str, speed: str, letter: str) -> Finding:
    """Table 3.5: the mean dissipation in one revolution [J]."""
    column = f"{CHANNELS[letter]}_mean_J"
    row = _revolutions(evidence, diameter, speed, column)
    error = row[f"{CHANNELS[letter]}_cv_percent"] / row["revolutions"] ** 0.5
    return Finding(float(row[column]), f"mean of {int(row['revolutions'])} revolutions; standard error {error:.1f} %")


@claim(
    "3.cycle_cv.{diameter}mm.{speed}.{letter}",
    """
    3.cycle_cv.5mm.600.n 3.cycle_cv.5mm.800.n 3.cycle_cv.5mm.1000.n 3.cycle_cv.5mm.1200.n
    3.cycle_cv.5mm.600.t 3.cycle_cv.5mm.800.t 3.cycle_cv.5mm.1000.t 3.cycle_cv.5mm.1200.t
    3.cycle_cv.10mm.600.n 3.cycle_cv.10mm.800.n 3.cycle_cv.10mm.1000.n 3.cycle_cv.10mm.1200.n
    3.cycle_cv.10mm.600.t 3.cycle_cv.10mm.800.t 3.cycle_cv.10mm.1000.t 3.cycle_cv.10mm.1200.t
    """,
    spread_cause,
)
def spread_of_revolutions(evidence: Evidence, diameter: str, speed: str, letter: str) -> Finding:
    """Table 3.5: the coefficient of variation of the dissipation in one revolution [%]."""
    column = f"{CHANNELS[letter]}_cv_percent"
    row = _revolutions(evidence, diameter, speed, column)
    return Finding(float(row[column]), f"standard deviation over mean of {int(row['revolutions'])} revolutions")


@claim("3.reference.{letter}", "3.reference.En 3.reference.Et 3.reference.f", energy_cause)
def reference_case(evidence: Evidence, letter: str) -> Finding:
    """The reference case of Sec. 3.3.4: 10 mm, 600 rpm, fill 0.10."""
    column = {"En": "normal_energy_J", "Et": "tangential_energy_J", "f": "specific_frequency_hz"}[letter]
    row = evidence.row(
        "fingerprint/descriptors.tsv",
        column,
        f"{AS_BUILT} and ball_diameter_mm == 10 and speed_rpm == 600 and fill_ratio == 0.10",
        "the sweep has no calibrated case of 10 mm at 600 rpm and fill 0.10",
    )
    return Finding(
        float(row[column]),
        f"{int(row['seeds'])} seed(s); re-contacts within {row['collision_gap_turns']:g} turns are one collision",
    )


@claim("3.inverse.speed")
def speed_of_smaller_balls(evidence: Evidence) -> Finding:
    """Sec. 3.3.4: the speed at which 5 mm balls have the energies of the reference case."""
    path = "fingerprint/inverse.tsv"
    absent = "fingerprint.inverse does not ask for thesis_reference at fill 0.10 with 5 mm balls"
    row = evidence.row(path, "speed_rpm", f"{INVERSE} and curves == 'published'", absent)
    ours = evidence.table(path, f"{INVERSE} and curves == 'ours'")
    note = "" if ours.empty else f"; our curves give {ours['speed_rpm'].iloc[0]:.0f} rpm"
    return Finding(
        float(row["speed_rpm"]),
        "speed that keeps the printed normal energy on the published curves; the specific frequency is then "
        f"{row['specific_frequency_hz']:.0f} 1/s ({row['specific_frequency_hz_residual_percent']:+.0f} %), not kept as "
        f"Sec. 3.3.4 says{note}",
    )


def _stiff_and_soft(evidence: Evidence, columns: str) -> tuple[pd.Series, pd.Series]:
    """The rows of steel, and of a ball a hundred times softer, each at its own time step (Fig. 3.4)."""
    absent = "the sweep has no pair of cases at 205 and 2.05 GPa"
    where = f"{OWN} and young_modulus_gpa in (205, 2.05)"
    rows = evidence.rows("convergence/modulus.tsv", columns, where, absent)
    rows = rows.drop_duplicates("young_modulus_gpa").set_index("young_modulus_gpa")
    if len(rows) < 2:
        raise NotRun(absent)
    return rows.loc[205.0], rows.loc[2.05]


@claim("3.young.speedup")
def speed_up_of_soft_balls(evidence: Evidence) -> Finding:
    """Fig. 3.4: what the larger time step of a softer ball saves."""
    stiff, soft = _stiff_and_soft(evidence, "processor_s")
    return Finding(
        float(stiff["processor_s"] / soft["processor_s"]),
        f"{stiff['processor_s']:.1f} s of processor time at 205 GPa over {soft['processor_s']:.1f} s at 2.05 GPa; "
        f"{stiff['steps'] / soft['steps']:.1f} times the steps",
    )


@claim("3.young.power")
def power_of_soft_balls(evidence: Evidence) -> Finding:
    """Fig. 3.4: whether a softer ball keeps the power."""
    stiff, soft = _stiff_and_soft(evidence, "power_W, power_two_sigma_W")
    error = soft["power_deviation_se_percent"]
    spread = f"standard error {error:.1f} % over {soft['seeds']:.0f} seeds" if error > 0 else "one seed"
    return yes_no(
        abs(soft["power_W"] - stiff["power_W"]) <= stiff["power_two_sigma_W"],
        f"{soft['power_W']:.2f} W at 2.05 GPa, {stiff['power_W']:.2f} W at 205 GPa with two standard deviations "
        f"between revolutions of {stiff['power_two_sigma_W']:.2f} W; they differ by "
        f"{soft['power_deviation_percent']:+.1f} % ({spread})",
    )
