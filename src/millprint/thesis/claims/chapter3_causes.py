"""What our runs show of deviations in chapter 3: single conditions, steps of the jar's shape, counting rules.

Each text is computed from the results, and says what moves a value by how much. No text claims to name the cause.
"""

import numpy as np
import pandas as pd

from millprint.estimate.quantiles import chi_squared_quantile
from millprint.fingerprint.descriptors import NOTHING
from millprint.thesis.claims.evidence import Evidence, in_words

MILL, CONTACT = "emax", "calibrated"
# Conditions on the rows of a table: the thesis's mill and contact set, and of these the mill as built.
OWN = f"mill == '{MILL}' and contact == '{CONTACT}'"
AS_BUILT = f"{OWN} and varied == '{NOTHING}'"
DESCRIPTORS, RULES, FIT = (f"fingerprint/{name}.tsv" for name in ("descriptors", "counting_rules", "fit"))
CHANNELS = {"n": "normal", "t": "tangential"}
POWERS = ("Pn", "Pt", "normal", "tangential")
TOLERANCE_PERCENT = 15.0  # of the published powers and frequencies


def _conditions(evidence: Evidence, fill: str, quantity: str) -> str:
    """The single conditions of a mean over ball sizes and speeds."""
    found = evidence.table(DESCRIPTORS, f"{AS_BUILT} and fill_ratio == {fill}")
    if found.empty:
        return ""
    single = found.sort_values(["ball_diameter_mm", "speed_rpm"], ascending=[False, True])
    form = f"{{{quantity}:.3g}} at {{ball_diameter_mm:g}} mm {{speed_rpm:g}} rpm"
    return f"single conditions {in_words(single, form)}"


def _jar(evidence: Evidence, name: str) -> str:
    """Effect of steps of the jar's parameters on a value and, if a step corrects it, on the others."""
    own = evidence.table(FIT, f"record == 'value' and name == '{name}'")
    steps = evidence.table(FIT, f"record == 'sensitivity' and name == '{name}'")
    if own.empty or steps.empty:
        return ""
    change = steps["change_percent"]
    words = (
        "the jar's shape is not published: one step of a fitted parameter moves it by "
        f"{change.min():+.0f} to {change.max():+.0f} %"
    )
    nearer = steps[np.sign(change) == -np.sign(own["error_percent"].iloc[0])]
    if nearer.empty:
        return f"{words}, and no step brings it nearer"
    best = nearer.loc[nearer["change_percent"].abs().idxmax()]
    step = f"{best['parameter']} {best['parameter_value']:g} brings it nearest, by {best['change_percent']:+.0f} %"
    return _join(words, step + _price(evidence, name, best))


def _price(evidence: Evidence, name: str, step: pd.Series) -> str:
    """The other powers that a step moves away from the published ones, as text."""
    same_step = f"parameter == '{step['parameter']}' and parameter_value == {float(step['parameter_value'])}"
    changed = evidence.table(FIT, f"record == 'sensitivity' and {same_step}").set_index("name")
    errors = _values(evidence)["error_percent"]
    changed = changed[changed["quantity"].isin(POWERS) & (changed.index != name)]["change_percent"]
    harmed = changed[np.sign(changed) == np.sign(errors.reindex(changed.index))]
    words = [f"{other} by {value:+.0f} % (off by {errors[other]:+.0f} %)" for other, value in harmed.items()]
    return f", and takes further off {', '.join(words)}" if words else ""


def _values(evidence: Evidence) -> pd.DataFrame:
    """Published values with ours and their errors, by name; empty where nothing was fitted."""
    values = evidence.table(FIT, "record == 'value'")
    return values if values.empty else values.set_index("name")


def curve_cause(evidence: Evidence, fill: str, quantity: str) -> str:
    """What is shown of a value of the master curves."""
    causes = {"ratio": _ratio_cause, "f": _frequency_cause}
    return causes[quantity](evidence, fill) if quantity in causes else _power_cause(evidence, fill, quantity)


def _power_cause(evidence: Evidence, fill: str, quantity: str) -> str:
    return _join(_conditions(evidence, fill, quantity), _jar(evidence, f"{quantity}_f{fill}"))


def large_ball_cause(evidence: Evidence, quantity: str) -> str:
    """What is shown of the power of 10 mm balls at fill 0.08."""
    channel = {"Pn": "normal", "Pt": "tangential"}[quantity]
    return _join(_conditions(evidence, "0.08", quantity), _jar(evidence, f"{channel}_d10_n1200"))


def _ratio_cause(evidence: Evidence, fill: str) -> str:
    values = _values(evidence)
    names = [name for name in (f"Pn_f{fill}", f"Pt_f{fill}") if name in values.index]
    words = [f"{name.split('_')[0]} is off by {values['error_percent'][name]:+.0f} %" for name in names]
    return _join(" and ".join(words), _conditions(evidence, fill, "ratio"))


def elbow_cause(evidence: Evidence) -> str:
    """What is shown of the ratio at fill 0.10."""
    return _ratio_cause(evidence, "0.10")


def _frequency_cause(evidence: Evidence, fill: str) -> str:
    """The frequency by ball size, and the counting rules that come within the tolerance at all published fills."""
    published = evidence.table(FIT, "record == 'value' and quantity == 'f'")
    table = evidence.table(RULES, AS_BUILT)
    if published.empty or table.empty:
        return _conditions(evidence, fill, "f")
    worst = {}
    for rule, group in table.groupby("counting_rule"):
        means = group.groupby("fill_ratio")["f"].mean()
        off = [100 * (means.get(row.fill_ratio, np.nan) / row.published - 1) for row in published.itertuples()]
        worst[rule] = max(off, key=abs)
    best = min(worst, key=lambda rule: abs(worst[rule]))
    within = [rule for rule, off in worst.items() if abs(off) <= TOLERANCE_PERCENT]
    near = f"rules within {TOLERANCE_PERCENT:g} % at all published fills: {', '.join(within) or 'none'}"
    fills = f"the best at its worst fill is {best}, off by {worst[best]:+.0f} %"
    return _join(_conditions(evidence, fill, "f"), f"of {len(worst)} counting rules, {near}; {fills}")


def mean_cause(evidence: Evidence, diameter: str, speed: str, letter: str) -> str:
    """How far a mean per revolution is off at each speed, and what the jar's shape does to it."""
    channel = CHANNELS[letter]
    fit = evidence.table(FIT, f"record == 'value' and quantity == '{channel}' and ball_diameter_mm == {diameter}")
    if fit.empty:
        return ""
    words = in_words(fit.sort_values("speed_rpm"), "{error_percent:+.0f} % at {speed_rpm:g} rpm")
    deviations = f"{channel} dissipation of {diameter} mm balls is off by {words}"
    return _join(deviations, _jar(evidence, f"{channel}_d{diameter}_n1200"))


def spread_cause(evidence: Evidence, diameter: str, speed: str, letter: str) -> str:
    """Whether chance may explain a coefficient of variation: its interval for independent normal revolutions."""
    column = f"{CHANNELS[letter]}_cv_percent"
    where = f"contact == '{CONTACT}' and ball_diameter_mm == {diameter}"
    table = evidence.table("fingerprint/table_3_5.tsv", where)
    here = table[table["speed_rpm"] == float(speed)] if len(table) else table
    if here.empty:
        return ""
    value, printed = here[column].iloc[0], here[f"{column}_published"].iloc[0]
    degrees = here["revolutions"].iloc[0] - 1
    low, high = (value * np.sqrt(degrees / chi_squared_quantile(part, degrees)) for part in (0.975, 0.025))
    chance = "chance may explain it" if low <= printed <= high else "more than chance"
    others = in_words(table, f"{{{column}:.1f}} at {{speed_rpm:g}} rpm")
    return f"95 % interval {low:.1f} to {high:.1f} %: {chance}; at all speeds {others}"


def energy_cause(evidence: Evidence, letter: str) -> str:
    """How far powers and frequency of the reference case are off: an energy is a power over a frequency."""
    values = _values(evidence)
    where = f"{AS_BUILT} and fill_ratio == 0.10 and ball_diameter_mm == 10 and speed_rpm == 600"
    found = evidence.table(DESCRIPTORS, where)
    if values.empty or found.empty:
        return ""
    words = [
        f"{name} is off by {100 * (found[name].iloc[0] / values['published'][f'{name}_f0.10'] - 1):+.0f} %"
        for name in ("Pn", "Pt", "f")
    ]
    return f"an energy is a power over a frequency, and in this condition {', '.join(words)} from the printed curves"


def high_ratio_cause(evidence: Evidence) -> str:
    """The ratio at high fill by ball size."""
    high = evidence.table(DESCRIPTORS, f"{AS_BUILT} and fill_ratio >= 0.20")
    if high.empty:
        return ""
    means = high.groupby(["ball_diameter_mm", "fill_ratio"])["ratio"].mean()
    return "by ball size: " + ", ".join(f"{value:.2f} at {d:g} mm fill {f:g}" for (d, f), value in means.items())


def low_ratio_cause(evidence: Evidence) -> str:
    """Both powers at low fill, and what the jar's shape does to the normal one."""
    low = evidence.table(DESCRIPTORS, f"{AS_BUILT} and fill_ratio <= 0.06")
    if low.empty:
        return ""
    form = "Pt/Pn {Pt:.0f}/{Pn:.0f} at {ball_diameter_mm:g} mm fill {fill_ratio:g} {speed_rpm:g} rpm"
    words = in_words(low.sort_values(["fill_ratio", "ball_diameter_mm"]), form)
    return _join(words, _jar(evidence, "Pn_f0.06"))


def trend_cause(evidence: Evidence, contact: str) -> str:
    """The frequency at the first and the last fill under every counting rule and with every ball size."""
    where = AS_BUILT.replace(CONTACT, contact)
    table = evidence.table(RULES, where)
    if table.empty:
        return ""
    means = table.groupby(["counting_rule", "fill_ratio"])["f"].mean().unstack()
    rising = [rule for rule, row in means.iterrows() if row.iloc[-1] > row.iloc[0]]
    words = ", ".join(f"{row.iloc[0]:.0f} to {row.iloc[-1]:.0f} {rule}" for rule, row in means.iterrows())
    sizes = evidence.table(DESCRIPTORS, where).groupby(["ball_diameter_mm", "fill_ratio"])["f"].mean().unstack()
    by_size = ", ".join(f"{row.iloc[0]:.0f} to {row.iloc[-1]:.0f} with {d:g} mm" for d, row in sizes.iterrows())
    return f"rules under which it rises: {', '.join(rising) or 'none'} ({words}); by ball size {by_size}"


def collapse_cause(evidence: Evidence) -> str:
    """How much of the spread is between ball sizes, and how much between speeds of one size."""
    table = evidence.table(DESCRIPTORS, AS_BUILT)
    if table.empty:
        return ""
    words = []
    for quantity in ("Pn", "Pt", "f"):
        place = table.groupby(["fill_ratio", "ball_diameter_mm"])[quantity]
        speeds = (place.std(ddof=1) / place.mean()).median()
        size = place.mean().groupby("fill_ratio")
        sizes = (size.std(ddof=1) / size.mean()).median()
        words.append(f"{quantity} {100 * sizes:.0f} and {100 * speeds:.0f} %")
    return f"median spread between ball sizes, and between speeds of one size: {', '.join(words)}"


def _shape(evidence: Evidence, quantity: str) -> str:
    table = evidence.table(DESCRIPTORS, AS_BUILT)
    if table.empty:
        return ""
    means = table.groupby("fill_ratio")[quantity].mean()
    return f"{quantity} over fill: " + ", ".join(f"{value:.1f} at {fill:g}" for fill, value in means.items())


def normal_power_cause(evidence: Evidence) -> str:
    """The normal power over the fill ratio."""
    return _shape(evidence, "Pn")


def power_cause(evidence: Evidence) -> str:
    """The power over the fill ratio."""
    return _shape(evidence, "P")


def _join(*words: str) -> str:
    return "; ".join(word for word in words if word)
