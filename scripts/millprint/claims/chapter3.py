"""Claims of thesis chapter 3 against the tables of the fingerprint stage."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pandas as pd

from millprint.claims import chapter3_calibration as calibration
from millprint.claims import chapter3_curves as curves3
from millprint.claims.chapter3_causes import cause
from millprint.claims.compare import DEVIATES, verdict
from millprint.claims.evidence import Evidence, not_run, parts, rows, yes_no
from millprint.claims.finding import Finding
from millprint.config.contact import ContactConfig
from millprint.config.load import load_named
from millprint.config.sweep import ball_count
from millprint.files import read_table
from millprint.fingerprint.condition import effective_restitution
from millprint.fingerprint.descriptors import NOTHING

JAR_VOLUME_ML = 125.0
CHANNELS = {"n": "normal", "t": "tangential"}


def _balls(claims: pd.DataFrame) -> dict[str, Finding]:
    """Table 3.4: rounded volume ratios; a count that breaks the rule which gives all others is an erratum."""
    counts = {}
    for claim in claims[claims["id"].str.startswith("3.balls.")].itertuples():
        diameter, fill = parts(r"3\.balls\.(\d+)mm\.([\d.]+)", claim.id)
        diameter_m, fill_ratio = float(diameter) * 1e-3, float(fill)
        exact = fill_ratio * JAR_VOLUME_ML * 1e-6 / (3.141592653589793 / 6 * diameter_m**3)
        counts[claim.id] = (ball_count(fill_ratio, JAR_VOLUME_ML * 1e-6, diameter_m), exact, int(claim.value))
    odd = [name for name, (count, _, printed) in counts.items() if count != printed]
    found = {}
    for name, (count, exact, printed) in counts.items():
        explanation = f"volume of balls over volume of one ball = {exact:.2f}, rounded"
        # One or two odd entries among many contradict the table's own rule; more would mean that the rule is wrong.
        reason = ""
        if name in odd and len(odd) <= len(counts) // 6:
            reason = (
                f"rounding gives {count} and not {printed}, and {len(counts) - len(odd)} of {len(counts)} counts of "
                "Table 3.4 as printed;"
            )
        found[name] = Finding(count, explanation, erratum=reason)
    return found


def _effective_restitution(data: Path) -> dict[str, Finding]:
    found = {}
    for contact in ("calibrated", "steel"):
        values = load_named(data.parent / "contacts", contact, ContactConfig, "contact set")
        found[f"3.eps.{contact}"] = Finding(
            effective_restitution(values.restitution, values.static_friction),
            f"Eq. 3.30 with e = {values.restitution:g} and mu = {values.static_friction:g}",
        )
    return found


def _cycle(evidence: Evidence, name: str) -> Finding:
    """A mean or a coefficient of variation of Table 3.5."""
    kind, diameter, speed, letter = parts(r"3\.(cycle|cycle_cv)\.(\d+)mm\.(\d+)\.(n|t)", name)
    wanted = {"ball_diameter_mm": float(diameter), "speed_rpm": float(speed), "fill_ratio": 0.08}
    table = rows(evidence.table("fingerprint/cycles.tsv"), mill=curves3.MILL, contact=curves3.CONTACT, varied=NOTHING)
    found = rows(table, **wanted)
    if found.empty:
        return not_run(f"the sweep has no calibrated case of {diameter} mm at {speed} rpm and fill 0.08")
    row = found.iloc[0]
    column = f"{CHANNELS[letter]}_{'mean_J' if kind == 'cycle' else 'cv_percent'}"
    what = "mean" if kind == "cycle" else "standard deviation over mean"
    error = row[f"{CHANNELS[letter]}_cv_percent"] / row["revolutions"] ** 0.5
    note = f"; standard error {error:.1f} %" if kind == "cycle" else ""
    return Finding(float(row[column]), f"{what} of {int(row['revolutions'])} revolutions{note}")


def _reference(evidence: Evidence, name: str) -> Finding:
    """The reference case of Sec. 3.3.4: 10 mm, 600 rpm, fill 0.10."""
    columns = {"En": "normal_energy_J", "Et": "tangential_energy_J", "f": "frequency_per_ball_hz"}
    wanted = {"ball_diameter_mm": 10.0, "speed_rpm": 600.0, "fill_ratio": 0.10}
    table = rows(evidence.table("fingerprint/descriptors.tsv"), mill=curves3.MILL, contact=curves3.CONTACT)
    found = rows(table, varied=NOTHING, **wanted)
    if found.empty:
        return not_run("the sweep has no calibrated case of 10 mm at 600 rpm and fill 0.10")
    row = found.iloc[0]
    return Finding(
        float(row[columns[name.rsplit(".", 1)[1]]]),
        f"{int(row['seeds'])} seed(s); re-contacts within {1e3 * row['collision_gap_s']:g} ms are one collision",
    )


def _inverse(evidence: Evidence) -> Finding:
    table = rows(evidence.table("fingerprint/inverse.tsv"), target="thesis_reference", kept="normal energy")
    table = rows(table, fill_ratio=0.10, ball_diameter_mm=5.0)
    printed, ours = rows(table, curves="published"), rows(table, curves="ours")
    if printed.empty:
        return not_run("fingerprint.inverse does not ask for thesis_reference at fill 0.10 with 5 mm balls")
    row = printed.iloc[0]
    note = "" if ours.empty else f"; our curves give {ours['speed_rpm'].iloc[0]:.0f} rpm"
    return Finding(
        float(row["speed_rpm"]),
        "speed that keeps the printed normal energy on the published curves; the frequency per ball is then "
        f"{row['frequency_per_ball_hz']:.0f} 1/s ({row['frequency_per_ball_hz_residual_percent']:+.0f} %), not kept as "
        f"Sec. 3.3.4 says{note}",
    )


def _modulus(evidence: Evidence) -> dict[str, Finding]:
    """Fig. 3.4 from results/convergence/modulus.tsv: a hundredfold softer ball against steel, each at its own step."""
    table = rows(evidence.table("convergence/modulus.tsv"), mill=curves3.MILL, contact=curves3.CONTACT)
    hard, soft = rows(table, young_modulus_gpa=205.0), rows(table, young_modulus_gpa=2.05)
    if hard.empty or soft.empty:
        absent = not_run("the sweep has no pair of cases at 205 and 2.05 GPa")
        return {"3.young.speedup": absent, "3.young.power": absent}
    hard, soft = hard.iloc[0], soft.iloc[0]
    chance = soft["power_deviation_se_percent"]
    spread = f"standard error {chance:.1f} % over {soft['seeds']:.0f} seeds" if chance > 0 else "one seed"
    return {
        "3.young.speedup": Finding(
            float(hard["processor_s"] / soft["processor_s"]),
            f"{hard['processor_s']:.1f} s of processor time at 205 GPa over {soft['processor_s']:.1f} s at 2.05 GPa; "
            f"{hard['steps'] / soft['steps']:.1f} times the steps",
        ),
        "3.young.power": yes_no(
            abs(soft["power_W"] - hard["power_W"]) <= hard["power_two_sigma_W"],
            f"{soft['power_W']:.2f} W at 2.05 GPa, {hard['power_W']:.2f} W at 205 GPa with two standard deviations "
            f"between revolutions of {hard['power_two_sigma_W']:.2f} W; they differ by "
            f"{soft['power_deviation_percent']:+.1f} % ({spread})",
        ),
    }


# What a claim's id begins with, and what finds it.
BY_ID: dict[str, Callable[[Evidence, str], Finding]] = {
    "3.cycle": _cycle,
    "3.reference.": _reference,
    "3.curve.0": curves3.curve_value,
}


def findings(results: Path, data: Path) -> dict[str, Finding]:
    """A finding for every claim of chapter 3; `results` is the run's folder, `data` that of claims.tsv."""
    evidence = Evidence(Path(results))
    claims = read_table(Path(data) / "claims.tsv", text=["id", "value", "tolerance"])
    claims = claims[claims["id"].str.startswith("3.")]
    found = _balls(claims) | _effective_restitution(Path(data)) | _modulus(evidence)
    found |= curves3.shape_findings(evidence) | curves3.collapse_findings(evidence)
    found["3.inverse.speed"] = _inverse(evidence)
    for name in claims["id"]:
        for beginning, finder in BY_ID.items():
            if name.startswith(beginning):
                found[name] = finder(evidence, name)
    found["3.restitution"] = calibration.restitution(evidence)
    found["3.friction_fit"] = calibration.friction_fit(evidence, curves3.MILL)
    return _with_causes(evidence, claims, found)


def _with_causes(evidence: Evidence, claims: pd.DataFrame, found: dict[str, Finding]) -> dict[str, Finding]:
    """The findings, those that deviate with what our runs say of why."""
    for claim in claims.itertuples():
        finding = found[claim.id]
        if verdict(claim.value, claim.tolerance, finding) == DEVIATES:
            words = "; ".join(part for part in (finding.explanation, cause(evidence, claim.id)) if part)
            found[claim.id] = replace(finding, explanation=words)
    return found
