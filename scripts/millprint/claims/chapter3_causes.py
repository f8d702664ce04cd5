"""What our runs say of why a value of chapter 3 deviates: single conditions, the jar's sensitivity, counting rules."""

import re

import numpy as np
import pandas as pd
from scipy import stats

from millprint.claims.evidence import Evidence, rows
from millprint.fingerprint.descriptors import NOTHING

MILL, CONTACT = "emax", "calibrated"
CHANNELS = {"n": "normal", "t": "tangential"}
POWERS = ("Pn", "Pt", "normal", "tangential")
TOLERANCE_PERCENT = 15.0  # of the published powers and frequencies


def cause(evidence: Evidence, name: str) -> str:
    """A measured reason for the deviation of the claim `name`, in words; empty where the tables hold none."""
    for pattern, finder in _FINDERS:
        found = re.fullmatch(pattern, name)
        if found:
            return finder(evidence, *found.groups())
    return ""


def _descriptors(evidence: Evidence, contact: str = CONTACT) -> pd.DataFrame:
    return rows(evidence.table("fingerprint/descriptors.tsv"), mill=MILL, contact=contact, varied=NOTHING)


def _conditions(evidence: Evidence, fill: float, quantity: str, contact: str = CONTACT) -> str:
    """The single conditions behind a mean over ball sizes and speeds."""
    found = rows(_descriptors(evidence, contact), fill_ratio=fill)
    if found.empty:
        return ""
    single = found.sort_values(["ball_diameter_mm", "speed_rpm"], ascending=[False, True])
    words = [
        f"{row[quantity]:.3g} at {row['ball_diameter_mm']:g} mm {row['speed_rpm']:g} rpm"
        for _, row in single.iterrows()
    ]
    return f"single conditions {', '.join(words)}"


def _jar(evidence: Evidence, name: str) -> str:
    """What steps of the jar's parameters do to a value, and to the others where a step mends the value."""
    fit = evidence.table("fingerprint/fit.tsv")
    own = rows(fit, record="value", name=name)
    steps = rows(fit, record="sensitivity", name=name)
    if own.empty or steps.empty:
        return ""
    change = steps["change_percent"]
    words = (
        "the jar's shape is not published: one step of a fitted parameter moves it by "
        f"{change.min():+.0f} to {change.max():+.0f} %"
    )
    mending = steps[np.sign(change) == -np.sign(own["error_percent"].iloc[0])]
    if mending.empty:
        return f"{words}, and no step mends it"
    best = mending.loc[mending["change_percent"].abs().idxmax()]
    told = f"{best['parameter']} {best['parameter_value']:g} mends it most, by {best['change_percent']:+.0f} %"
    return _join(words, told + _price(fit, name, best))


def _price(fit: pd.DataFrame, name: str, step: pd.Series) -> str:
    """The other powers that a step takes further from the published ones, in words."""
    place = {"parameter": step["parameter"], "parameter_value": float(step["parameter_value"])}
    changed = rows(fit, record="sensitivity", **place).set_index("name")
    errors = rows(fit, record="value").set_index("name")["error_percent"]
    changed = changed[changed["quantity"].isin(POWERS) & (changed.index != name)]["change_percent"]
    harmed = changed[np.sign(changed) == np.sign(errors.reindex(changed.index))]
    words = [f"{other} by {value:+.0f} % (off by {errors[other]:+.0f} %)" for other, value in harmed.items()]
    return f", and takes further off {', '.join(words)}" if words else ""


def _power(evidence: Evidence, fill: str, quantity: str) -> str:
    value = f"{quantity}_f{fill}"
    if fill == "0.08":
        value = f"{'normal' if quantity == 'Pn' else 'tangential'}_d10_n1200"
    return _join(_conditions(evidence, float(fill), quantity), _jar(evidence, value))


def _ratio(evidence: Evidence, fill: str) -> str:
    fit = rows(evidence.table("fingerprint/fit.tsv"), record="value")
    errors = {q: rows(fit, name=f"{q}_f{fill}")["error_percent"] for q in ("Pn", "Pt")} if len(fit) else {}
    words = [f"{name} is off by {error.iloc[0]:+.0f} %" for name, error in errors.items() if len(error)]
    return _join(" and ".join(words), _conditions(evidence, float(fill), "ratio"))


def _frequency(evidence: Evidence, fill: str) -> str:
    """The frequency by ball size, and the counting rules that come within the tolerance at all published fills."""
    published = rows(evidence.table("fingerprint/fit.tsv"), record="value", quantity="f")
    table = rows(evidence.table("fingerprint/counting_rules.tsv"), mill=MILL, contact=CONTACT, varied=NOTHING)
    if published.empty or table.empty:
        return _conditions(evidence, float(fill), "f")
    worst = {}
    for rule, group in table.groupby("counting_rule"):
        means = group.groupby("fill_ratio")["f"].mean()
        off = [100 * (means.get(row.fill_ratio, np.nan) / row.published - 1) for row in published.itertuples()]
        worst[rule] = max(off, key=abs)
    best = min(worst, key=lambda rule: abs(worst[rule]))
    within = [rule for rule, off in worst.items() if abs(off) <= TOLERANCE_PERCENT]
    told = f"rules within {TOLERANCE_PERCENT:g} % at all published fills: {', '.join(within) or 'none'}"
    fills = f"the best at its worst fill is {best}, off by {worst[best]:+.0f} %"
    return _join(_conditions(evidence, float(fill), "f"), f"of {len(worst)} counting rules, {told}; {fills}")


def _cycle(evidence: Evidence, diameter: str, speed: str, letter: str) -> str:
    """The mean per revolution over the square of the speed, which scaling keeps: whether one speed or all are off."""
    channel = CHANNELS[letter]
    fit = rows(
        evidence.table("fingerprint/fit.tsv"), record="value", quantity=channel, ball_diameter_mm=float(diameter)
    )
    if fit.empty:
        return ""
    words = ", ".join(
        f"{row.error_percent:+.0f} % at {row.speed_rpm:g} rpm" for row in fit.sort_values("speed_rpm").itertuples()
    )
    return _join(
        f"{channel} dissipation of {diameter} mm balls is off by {words}",
        _jar(evidence, f"{channel}_d{diameter}_n1200"),
    )


def _variation(evidence: Evidence, diameter: str, speed: str, letter: str) -> str:
    """The interval of a coefficient of variation from so many revolutions, as if they were independent and normal."""
    column = f"{CHANNELS[letter]}_cv_percent"
    table = rows(evidence.table("fingerprint/table_3_5.tsv"), contact=CONTACT, ball_diameter_mm=float(diameter))
    here = rows(table, speed_rpm=float(speed))
    if here.empty:
        return ""
    value, printed = here[column].iloc[0], here[f"{column}_published"].iloc[0]
    freedom = here["revolutions"].iloc[0] - 1
    low, high = (value * np.sqrt(freedom / stats.chi2.ppf(part, freedom)) for part in (0.975, 0.025))
    chance = "chance may explain it" if low <= printed <= high else "more than chance"
    others = ", ".join(f"{row[column]:.1f} at {row['speed_rpm']:g} rpm" for _, row in table.iterrows())
    return f"95 % interval {low:.1f} to {high:.1f} %: {chance}; at all speeds {others}"


def _reference(evidence: Evidence, letter: str) -> str:
    """An energy is a power over a frequency: which of them is off."""
    fit = rows(evidence.table("fingerprint/fit.tsv"), record="value")
    found = rows(_descriptors(evidence), fill_ratio=0.10, ball_diameter_mm=10.0, speed_rpm=600.0)
    if fit.empty or found.empty:
        return ""
    published = fit.set_index("name")["published"]
    words = [
        f"{name} is off by {100 * (found[name].iloc[0] / published[f'{name}_f0.10'] - 1):+.0f} %"
        for name in ("Pn", "Pt", "f")
    ]
    return f"an energy is a power over a frequency, and in this condition {', '.join(words)} from the printed curves"


def _high_ratio(evidence: Evidence) -> str:
    table = _descriptors(evidence)
    if table.empty:
        return ""
    high = table[table["fill_ratio"] >= 0.20]
    means = high.groupby(["ball_diameter_mm", "fill_ratio"])["ratio"].mean()
    return "by ball size: " + ", ".join(f"{value:.2f} at {d:g} mm fill {f:g}" for (d, f), value in means.items())


def _low_ratio(evidence: Evidence) -> str:
    table = _descriptors(evidence)
    if table.empty:
        return ""
    low = table[table["fill_ratio"] <= 0.06].sort_values(["fill_ratio", "ball_diameter_mm"])
    words = [
        f"Pt/Pn {row.Pt:.0f}/{row.Pn:.0f} at {row.ball_diameter_mm:g} mm fill {row.fill_ratio:g} {row.speed_rpm:g} rpm"
        for row in low.itertuples()
    ]
    return f"{', '.join(words)}; {_jar(evidence, 'Pn_f0.06')}"


def _trend(evidence: Evidence, contact: str) -> str:
    """First and last fill under every counting rule and ball size."""
    table = rows(evidence.table("fingerprint/counting_rules.tsv"), mill=MILL, contact=contact, varied=NOTHING)
    if table.empty:
        return ""
    means = table.groupby(["counting_rule", "fill_ratio"])["f"].mean().unstack()
    rising = [rule for rule, row in means.iterrows() if row.iloc[-1] > row.iloc[0]]
    words = ", ".join(f"{row.iloc[0]:.0f} to {row.iloc[-1]:.0f} {rule}" for rule, row in means.iterrows())
    sizes = rows(evidence.table("fingerprint/descriptors.tsv"), mill=MILL, contact=contact, varied=NOTHING)
    size = sizes.groupby(["ball_diameter_mm", "fill_ratio"])["f"].mean().unstack()
    by_size = ", ".join(f"{row.iloc[0]:.0f} to {row.iloc[-1]:.0f} with {d:g} mm" for d, row in size.iterrows())
    return f"rules under which it rises: {', '.join(rising) or 'none'} ({words}); by ball size {by_size}"


def _collapse(evidence: Evidence) -> str:
    """How much of the spread is between ball sizes, and how much between speeds of one size."""
    table = _descriptors(evidence)
    words = []
    for quantity in ("Pn", "Pt", "f"):
        place = table.groupby(["fill_ratio", "ball_diameter_mm"])[quantity]
        speeds = (place.std(ddof=1) / place.mean()).median()
        size = place.mean().groupby("fill_ratio")
        sizes = (size.std(ddof=1) / size.mean()).median()
        words.append(f"{quantity} {100 * sizes:.0f} and {100 * speeds:.0f} %")
    return f"median spread between ball sizes, and between speeds of one size: {', '.join(words)}" if len(table) else ""


def _shape(evidence: Evidence, quantity: str) -> str:
    table = _descriptors(evidence)
    if table.empty:
        return ""
    means = table.groupby("fill_ratio")[quantity].mean()
    return f"{quantity} over fill: " + ", ".join(f"{value:.1f} at {fill:g}" for fill, value in means.items())


def _join(*words: str) -> str:
    return "; ".join(word for word in words if word)


_FINDERS = (
    (r"3\.curve\.(0\.\d+)\.(Pn|Pt)", _power),
    (r"3\.curve\.(0\.\d+)\.ratio", _ratio),
    (r"3\.curve\.(0\.\d+)\.f", _frequency),
    (r"3\.curve\.ratio\.low", _low_ratio),
    (r"3\.curve\.ratio\.elbow", lambda evidence: _ratio(evidence, "0.10")),
    (r"3\.curve\.ratio\.high", _high_ratio),
    (r"3\.curve\.normal_max", lambda evidence: _shape(evidence, "Pn")),
    (r"3\.curve\.zone3", lambda evidence: _shape(evidence, "P")),
    (r"3\.cycle\.(\d+)mm\.(\d+)\.(n|t)", _cycle),
    (r"3\.cycle_cv\.(\d+)mm\.(\d+)\.(n|t)", _variation),
    (r"3\.reference\.(\w+)", _reference),
    (r"3\.frequency\.(\w+)", _trend),
    (r"3\.collapse", _collapse),
)
