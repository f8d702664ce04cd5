"""Claims of thesis chapter 3 on the master curves: values, shape and collapse."""

import pandas as pd
from scipy.stats import spearmanr

from millprint.claims.evidence import Evidence, not_run, parts, rows, yes_no
from millprint.claims.finding import Finding
from millprint.fingerprint.collapse import MACHINE
from millprint.fingerprint.descriptors import NOTHING
from millprint.fingerprint.exponents import FACTOR

MILL, CONTACT = "emax", "calibrated"


def curve_value(evidence: Evidence, name: str) -> Finding:
    """A value of the calibrated master curves at one fill ratio."""
    fill, quantity = parts(r"3\.curve\.(0\.\d+)\.(\w+)", name)
    if fill == "0.08":
        return _large_balls(evidence, quantity)
    found = rows(_curves(evidence, CONTACT), fill_ratio=float(fill))
    if found.empty:
        return not_run(f"the sweep has no calibrated case at fill {fill}")
    row = found.iloc[0]
    spread = 100 * (row[f"{quantity}_upper"] / row[quantity] - 1)
    rules = _counting_rules(evidence, float(fill)) if quantity == "f" else ""
    return Finding(float(row[quantity]), f"mean of {int(row['conditions'])} condition(s), spread {spread:.1f} %{rules}")


def _counting_rules(evidence: Evidence, fill_ratio: float) -> str:
    """The specific frequency under every recorded counting rule, in words."""
    table = rows(evidence.table("fingerprint/counting_rules.tsv"), mill=MILL, contact=CONTACT, varied=NOTHING)
    table = rows(table, fill_ratio=fill_ratio)
    if table.empty:
        return ""
    means = table.groupby("counting_rule", sort=False)["f"].mean()
    return "; by counting rule: " + ", ".join(f"{value:.0f} {name}" for name, value in means.items())


def _large_balls(evidence: Evidence, quantity: str) -> Finding:
    """Table 3.5 gives the powers of 10 mm balls at fill 0.08, over four speeds."""
    table = evidence.table("fingerprint/descriptors.tsv")
    found = rows(table, mill=MILL, contact=CONTACT, varied=NOTHING, ball_diameter_mm=10.0, fill_ratio=0.08)
    if found.empty:
        return not_run("the sweep has no calibrated case of 10 mm at fill 0.08")
    speeds = ", ".join(f"{speed:g}" for speed in sorted(found["speed_rpm"]))
    return Finding(float(found[quantity].mean()), f"mean over {speeds} rpm")


def _curves(evidence: Evidence, contact: str) -> pd.DataFrame:
    """Means of a contact set at its fill ratios, or an empty table if they are of another mill than the thesis's."""
    table = evidence.table(f"fingerprint/means_{contact}.tsv")
    about = evidence.json(f"fingerprint/fingerprint_{contact}.json").get("about", {})
    return table if about.get("mill") == MILL else table.iloc[:0]


def shape_findings(evidence: Evidence) -> dict[str, Finding]:
    """Claims on the shape of the curves over the fill ratio."""
    curves = _curves(evidence, CONTACT)
    return {
        **_ratio_findings(curves),
        **_maximum_findings(curves),
        "3.frequency.calibrated": _trend(curves, falls=True, contact="calibrated"),
        "3.frequency.steel": _trend(_curves(evidence, "steel"), falls=False, contact="steel"),
    }


def _ratio_findings(curves: pd.DataFrame) -> dict[str, Finding]:
    """Fig. 3.12 d: the largest ratio up to the elbow, at fill 0.10, and the mean over zone 3 (fill 0.20 and more)."""
    found = {}
    low = curves[curves["fill_ratio"] <= 0.10] if len(curves) else curves
    if low.empty:
        found["3.curve.ratio.low"] = not_run("the sweep has no calibrated case up to fill 0.10")
    else:
        place = low["ratio"].idxmax()
        found["3.curve.ratio.low"] = Finding(
            float(low.loc[place, "ratio"]), f"at fill {low.loc[place, 'fill_ratio']:g}"
        )
    elbow = rows(curves, fill_ratio=0.10)
    found["3.curve.ratio.elbow"] = (
        not_run("the sweep has no calibrated case at fill 0.10")
        if elbow.empty
        else Finding(
            float(elbow["ratio"].iloc[0]), f"mean of {int(elbow['conditions'].iloc[0])} condition(s) at fill 0.10"
        )
    )
    high = curves[curves["fill_ratio"] >= 0.20] if len(curves) else curves
    found["3.curve.ratio.high"] = (
        not_run("the sweep has no calibrated case at fill 0.20 or more")
        if high.empty
        else Finding(
            float(high["ratio"].mean()), f"mean over fills {high['fill_ratio'].min():g} to {high['fill_ratio'].max():g}"
        )
    )
    return found


def _maximum_findings(curves: pd.DataFrame) -> dict[str, Finding]:
    """Fig. 3.12 a and b: where the powers of one ball are largest."""
    if curves.empty or curves["fill_ratio"].max() <= 0.20 or curves["fill_ratio"].min() > 0.06:
        absent = not_run("the calibrated cases of the sweep do not span the fills 0.06 to over 0.20")
        return {"3.curve.normal_max": absent, "3.curve.zone3": absent}
    top = curves.loc[curves["Pn"].idxmax(), "fill_ratio"]
    beyond, before = curves[curves["fill_ratio"] > 0.20], curves[curves["fill_ratio"] <= 0.20]
    gains = {name: 100 * (beyond[name].max() / before[name].max() - 1) for name in ("Pn", "Pt")}
    return {
        "3.curve.normal_max": yes_no(0.10 <= top <= 0.20, f"the mean curve is largest at fill {top:g}"),
        "3.curve.zone3": yes_no(
            max(gains.values()) <= 0,
            f"largest power of a ball beyond fill 0.20 against that up to it: normal {gains['Pn']:+.1f} %, "
            f"tangential {gains['Pt']:+.1f} %",
        ),
    }


def _trend(curves: pd.DataFrame, falls: bool, contact: str) -> Finding:
    """Whether the specific frequency falls (or rises) with fill: by rank correlation, and from first to last."""
    if len(curves) < 3:
        return not_run(f"the sweep has fewer than three fill ratios with contact set {contact}")
    rank = float(spearmanr(curves["fill_ratio"], curves["f"]).statistic)
    first, last = curves["f"].iloc[[0, -1]]
    holds = (rank < 0 and last < first) if falls else (rank > 0 and last > first)
    return yes_no(
        holds,
        f"{first:.1f} at fill {curves['fill_ratio'].iloc[0]:g}, {last:.1f} at {curves['fill_ratio'].iloc[-1]:g}, "
        f"rank correlation {rank:+.2f}",
    )


def collapse_findings(evidence: Evidence) -> dict[str, Finding]:
    """Claims on the collapse: the spread over the mean at each fill ratio, before and after."""
    table = evidence.table("fingerprint/collapse.tsv")
    own = rows(table, scope=CONTACT, compared=MACHINE)
    own = own[own["quantity"] != "ratio"] if len(own) else own
    if own.empty or not len(_curves(evidence, CONTACT)):
        collapse = not_run("no fill ratio of the sweep has two calibrated conditions")
    else:
        worst = own.loc[own["spread_scaled"].idxmax()]
        collapse = Finding(
            float(100 * worst["spread_scaled"]),
            f"largest spread in per cent, of {worst['quantity']} at fill {worst['fill_ratio']:g}; the median is "
            f"{100 * own['spread_scaled'].median():.1f} % after and {100 * own['spread_dimensional'].median():.0f} % "
            f"before the normalisation{_exponents(evidence)}",
        )
    return {"3.collapse": collapse, "3.universal": _universal(evidence, table)}


def _exponents(evidence: Evidence) -> str:
    """The exponents that our runs give the powers of one ball, in words."""
    table = rows(evidence.table("fingerprint/exponents.tsv"), contact=CONTACT)
    words = []
    for name in ("normal", "tangential"):
        found = rows(table, quantity=f"{name}_power_per_ball_W").dropna(subset="exponent")
        given = [
            f"{row.variable} {row.exponent:.2f} ({row.lower:.2f} to {row.upper:.2f})" for row in found.itertuples()
        ]
        words += [f"{name} power {', '.join(given)}"] if given else []
    return f"; exponents from our runs, of the {'; of the '.join(words)}" if words else ""


def _universal(evidence: Evidence, table: pd.DataFrame) -> Finding:
    """Both contact sets collapse if the factor narrows the median spread of each quantity."""
    pooled = rows(table, scope="universal")
    if pooled.empty:
        return not_run("the sweep has no fill ratio with both contact sets")
    pooled = pooled[pooled["quantity"] != "ratio"]
    median = 100 * pooled.groupby("quantity")[["spread_scaled", "spread_universal"]].median()
    holds = bool((median["spread_universal"] < median["spread_scaled"]).all())
    words = "; ".join(
        f"{name} {row['spread_scaled']:.1f} to {row['spread_universal']:.1f} %" for name, row in median.iterrows()
    )
    found = rows(evidence.table("fingerprint/exponents.tsv"), contact="all", variable=FACTOR).dropna(subset="exponent")
    fitted = ", ".join(f"{-row.exponent:+.2f} for {row.quantity}" for row in found.itertuples())
    best = f"; the power of 1 - eps that joins the sets in our runs, not 1/2: {fitted}" if fitted else ""
    return yes_no(
        holds, f"median spread over both sets without and with (1 - eps)^(1/2): {words}{'' if holds else best}"
    )
