"""Chapter 2 against its claims: the screening design, the analysis of variance, half-life and wear."""

from pathlib import Path

import pandas as pd
from scipy.stats import f as f_distribution

from millprint.claims.finding import Finding
from millprint.files import read_json, read_table

TERMS = {"A": "A", "B": "B", "C": "C", "D": "D", "AB": "A:B", "AC": "A:C", "BC": "B:C"}
CONTRASTS = [f"{factor}{shape}" for factor in "ABCD" for shape in "LQ"]


def _anova(results: Path) -> pd.DataFrame:
    table = read_table(results / "doe/anova_printed.tsv", numeric=["sum_of_squares"], text=["term"])
    return table.set_index("term")


def _departures(results: Path) -> str:
    """The audit's departures from the generator, in words."""
    audit = read_table(results / "doe/audit.tsv", text=["check", "subject", "found", "wanted", "departs"])
    rows = audit[audit["check"].str.startswith("generator") & (audit["departs"] == "yes")]
    return "; ".join(f"{row.subject} was run at {row.found}, wanted {row.wanted}" for row in rows.itertuples())


def _design(results: Path) -> dict[str, Finding]:
    fraction = read_json(results / "doe/fraction.json")
    generators = ", ".join(fraction["generators"])
    words = ", ".join(fraction["defining_words"])
    return {
        "2.full_factorial": Finding(fraction["full_factorial_runs"], "m^x with three levels and four factors"),
        "2.screening_runs": Finding(
            fraction["runs"],
            f"{generators} (mod 3), defining relation I = {words}, resolution {fraction['resolution']}; "
            f"{_departures(results) or 'every run is as designed'}",
        ),
    }


def _sums_and_p(anova: pd.DataFrame) -> dict[str, Finding]:
    findings: dict[str, Finding] = {}
    for name, term in TERMS.items():
        if term not in anova.index:
            absent = Finding(None, f"not run: {term} is not in the model of this configuration")
            findings |= {f"2.anova.{name}.ss": absent, f"2.anova.{name}.p": absent}
            continue
        row = anova.loc[term]
        findings[f"2.anova.{name}.ss"] = Finding(
            row["sum_of_squares"],
            f"type I, yield as a fraction, factors as run; the designed level of D in every run would give "
            f"{row['sum_of_squares_as_designed']:.4f}",
        )
        findings[f"2.anova.{name}.p"] = Finding(
            row["p_value"],
            f"F = {row['F']:.3f} on {row['degrees_of_freedom']:.0f} and "
            f"{anova.loc['Residual', 'degrees_of_freedom']:.0f} degrees of freedom",
        )
    for name in CONTRASTS:
        findings[f"2.anova.{name}.ss"] = (
            Finding(anova.loc[name, "sum_of_squares"], "type I, model of the linear and quadratic contrasts alone")
            if name in anova.index
            else Finding(None, f"not run: this configuration has no contrast {name}")
        )
    return findings


def _interaction_freedom(anova: pd.DataFrame) -> Finding:
    """The printed six degrees of freedom for an interaction, against those that its printed p-value stands for."""
    if not set(TERMS.values()) <= set(anova.index):
        return Finding(None, "not run: the model of this configuration is not that of Table 2.5")
    own = int(anova.loc["A:B", "degrees_of_freedom"])
    residual = int(anova.loc["Residual", "degrees_of_freedom"])
    terms = [term for term in TERMS.values() if ":" not in term]
    total = int(anova.loc[[*TERMS.values(), "Residual"], "degrees_of_freedom"].sum())
    left = total - int(anova.loc[terms, "degrees_of_freedom"].sum()) - 3 * 6
    p_value = anova.loc["A:B", "p_value"]
    mean_square = anova.loc["Residual", "mean_square"]
    with_six = f_distribution.sf(anova.loc["A:B", "sum_of_squares"] / 6 / mean_square, 6, residual)
    reason = (
        f"The printed p = 0.011 follows from {own} and {residual} degrees of freedom (p = {p_value:.4f}); 6 for each "
        f"of the three interactions would leave {left} of {total} for the residual, and even with {residual} there p "
        f"would be {with_six:.4f}. Six is the union of the components of A:B and C:D (AB = CD2, AB2, CD), but the sum "
        "of squares is that of A:B alone."
    )
    return Finding(own, "contrasts of A:B in the fitted model", reason if own != 6 else "")


def _wear(results: Path) -> dict[str, Finding]:
    columns = ["speed_rpm", "iron_percent", "iron_by_difference_percent", "iron_of_mixture_percent", "powder_mass_g"]
    columns += ["weight_loss_percent", "weight_loss_by_difference_percent", "reading_error_percent", "wear_g"]
    table = read_table(results / "doe/wear.tsv", numeric=columns).set_index("speed_rpm")
    findings = {}
    for speed in (1200, 1000):
        if speed not in table.index:
            findings[f"2.wear.{speed}"] = Finding(None, f"not run: no weighing at {speed} rpm")
            continue
        row = table.loc[speed]
        findings[f"2.wear.{speed}"] = Finding(
            row["iron_percent"],
            f"{row['wear_g']:.3f} g of wear in {row['powder_mass_g']:.3f} g of powder charged (balls / BPR); "
            f"{row['iron_of_mixture_percent']:.1f} % of powder and wear together",
        )
    if 1200 not in table.index:
        return findings | {"2.wear.1200.loss": Finding(None, "not run: no weighing at 1200 rpm")}
    row = table.loc[1200]
    value, rounded = row["weight_loss_percent"], row["weight_loss_by_difference_percent"]
    erratum = (
        f"The row's own wear, {row['wear_g']:.3f} g of {row['unused_mass_g']:.2f} g, is {value:.3f} %; 0.34 % "
        f"follows only from the difference of the masses rounded to 0.01 g ({rounded:.3f} +- "
        f"{row['reading_error_percent']:.3f} %)."
    )
    findings["2.wear.1200.loss"] = Finding(
        value, "wear over the unused mass", erratum if f"{value:.2f}" != f"{rounded:.2f}" else ""
    )
    return findings


def _half_life(results: Path) -> Finding:
    table = read_table(results / "doe/half_life.tsv", numeric=["ph", "temperature_k", "half_life_h"])
    own, exact = table.iloc[0], table.iloc[1]
    return Finding(
        own["half_life_h"],
        f"pH {own['ph']:g} and {own['temperature_k']:g} K; {exact['temperature_k']:g} K gives "
        f"{exact['half_life_h']:.1f} h",
    )


def findings(results: Path, data: Path) -> dict[str, Finding]:
    """A finding for every claim of chapter 2, from the tables in `results`/doe.

    `data` is the folder of the measured tables, which this chapter reads through its results only.
    """
    anova = _anova(results)
    pareto = read_table(results / "doe/pareto.tsv", numeric=["F"], text=["source"])
    runs = read_table(results / "doe/residuals.tsv", numeric=["yield_percent"], text=["case"])
    best = runs.loc[runs["yield_percent"].idxmax()]
    ranking = ", ".join(f"{row.source} {row.F:.1f}" for row in pareto.itertuples())
    return {
        **_design(results),
        **_sums_and_p(anova),
        **_wear(results),
        "2.half_life": _half_life(results),
        "2.anova.AB.df": _interaction_freedom(anova),
        "2.pareto.first": Finding(pareto["source"].iloc[0], f"F of each term, largest first: {ranking}"),
        "2.best_yield": Finding(best["yield_percent"], f"measured, case {best['case']}"),
    }
