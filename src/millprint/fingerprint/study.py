"""Does a mill's sweep agree with finer settings? Descriptors of one condition, one setting changed at a time.

The change of a descriptor is judged by a tolerance that does not matter, and by the scatter between seeds.
"""

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass

import numpy as np
import pandas as pd

from millprint.cases.of_mill import FACTORS
from millprint.config.counting import recorded_count
from millprint.config.fingerprint import StudyConfig
from millprint.dem.convergence import column_of, deviations, pooled_variance
from millprint.estimate.estimates import Estimate, Interval
from millprint.estimate.judge import (
    AGREES,
    DIFFERS,
    NO_INTERVAL,
    NOT_RUN,
    OPEN,
    Allowed,
    Verdict,
    judge,
    judge_all,
)
from millprint.estimate.quantiles import (
    chi_squared_exceeded,
    chi_squared_quantile,
    normal_exceeded,
    student_exceeded,
)
from millprint.observables.counted_collisions import CHANNELS
from millprint.observables.definitions import DESCRIPTOR_SETS, DESCRIPTORS

# What is compared.
DESCRIBED = (*DESCRIPTOR_SETS["per_collision"], *(f"{name}_power_W" for name in CHANNELS))
# The first columns of a study.
FRONT = ("setting", "factor", "value", "seeds", "time_step_s", "young_modulus_gpa", "closure", "processor_s")
# Settings with what to change, and as a line names them.
ADVICE = {
    "time_step": "make mills.rayleigh_fraction smaller",
    "stiffness": "raise young_modulus_gpa of the contact set",
    "facets": "give the geometry more facets",
    "window": "raise sweep.discard_turns or sweep.window_turns",
    "seeds": "give sweep.seeds {seeds} seeds, or raise sweep.window_turns",
}
NAMES = {setting: setting.replace("_", " ") for setting in ADVICE}
# Probability that no verdict is wrong by chance [-].
CONFIDENCE = 0.95
# Never advise more seeds than this.
MOST_SEEDS = 200


def study_row(setting: str, factor: float, value: float, summaries: list[dict], rule: str) -> dict:
    """The row of a variant: means of DESCRIBED over its seeds, with standard errors, and what it cost.

    closure: the largest error of the energy balance; processor_s: the mean of a run.
    """
    runs = pd.DataFrame([_descriptors(summary, rule) for summary in summaries])
    means, errors = runs.mean(), runs.std(ddof=1) / math.sqrt(len(runs))
    first = summaries[0]
    return {
        "setting": setting,
        "factor": factor,
        "value": value,
        "seeds": len(runs),
        "time_step_s": first["time_step_s"],
        "young_modulus_gpa": (first["young_modulus_pa"] or np.nan) / 1e9,
        "closure": max(abs(summary["closure"]) for summary in summaries),
        "processor_s": float(np.mean([summary["processor_s"] for summary in summaries])),
        **{name: means[name] for name in DESCRIBED},
        **{column_of(name, "se"): errors[name] for name in DESCRIBED},
    }


def _descriptors(summary: dict, rule: str) -> dict[str, float]:
    frequency = recorded_count(summary, rule)["frequency_hz"]
    normal, tangential = (summary["power_W"][name] for name in CHANNELS)
    energies = [power / frequency if frequency else np.nan for power in (normal, tangential)]
    return dict(zip(DESCRIBED, [*energies, frequency / summary["balls"], normal, tangential], strict=True))


def tabulate_study(rows: list[dict]) -> pd.DataFrame:
    """The rows of the variants, the reference first, with changes from it [%] and their standard errors [%]."""
    table = pd.DataFrame(rows)
    for name in DESCRIBED:
        table = table.join(deviations(table, name))
    kinds = ("se", "deviation_percent", "deviation_se_percent")
    measured = [column for name in DESCRIBED for column in (name, *(column_of(name, kind) for kind in kinds))]
    return table[[*FRONT, *measured]]


def tabulate_window(summaries: list[dict]) -> pd.DataFrame:
    """How the powers settle: their mean over the first turns of the window, over that of the whole window [%].

    A row for each whole turn; means over the seeds, with standard errors.
    """
    turns = min(len(summary["per_revolution"]["normal_J"]) for summary in summaries)
    table = pd.DataFrame({"turns": np.arange(1, turns + 1)})
    for name in CHANNELS:
        energies = np.array([summary["per_revolution"][f"{name}_J"][:turns] for summary in summaries])
        means = np.cumsum(energies, axis=1) / table["turns"].to_numpy()
        change = 100 * (means / means[:, -1:] - 1)
        table[f"{name}_power_change_percent"] = change.mean(axis=0)
        table[f"{name}_power_change_se_percent"] = change.std(axis=0, ddof=1) / math.sqrt(len(change))
    return table


@dataclass(frozen=True)
class Check:
    """One comparison of a descriptor: its change or its error [%], the standard error [%] of either, and the verdict.

    factor: of the setting, over the sweep's [-]; decides: whether it counts for the verdict on the setting, as a
    refinement does; seeds: how many would decide, where more seeds can.
    """

    setting: str
    factor: float
    quantity: str
    change_percent: float
    error_percent: float
    verdict: str
    reason: str
    decides: bool = True
    seeds: int | None = None


def judge_change(change: float, error: float, freedom: int, comparisons: int, study: StudyConfig) -> Verdict:
    """Whether a change [%] with a standard error [%] agrees with none, within the tolerance.

    With Student's t of `freedom` degrees and a = 1 - confidence: it agrees where |change| + t(a) error is within the
    tolerance (two one-sided tests, Schuirmann, J. Pharmacokinet. Biopharm. 15, 657, 1987; all must pass, so none needs
    a share of a), differs where |change| - t(a / comparisons) error is beyond it (Bonferroni: one false alarm among all
    is as rare as a), and is open between, where the scatter hides it.
    """
    if freedom < 1 or not math.isfinite(change) or not math.isfinite(error):
        return Verdict(OPEN, NO_INTERVAL)
    halves = (float(student_exceeded((1 - CONFIDENCE) / shared, freedom)) * error for shared in (1, comparisons))
    return _by_either(study, *(Interval(change - half, change + half) for half in halves))


def _by_either(study: StudyConfig, narrow: Interval, wide: Interval) -> Verdict:
    """The verdict on a change [%] by two intervals: agreement by the narrow one, a difference by the wide one."""
    tolerance = Allowed(-study.tolerance_percent, study.tolerance_percent)
    found = judge(Estimate(math.nan, "%", repeats=narrow), tolerance)
    return found if found.agrees else judge(Estimate(math.nan, "%", repeats=wide), tolerance)


def seeds_to_decide(change: float, error: float, freedom: int, seeds: int, study: StudyConfig) -> int | None:
    """About how many seeds would show that a change is within the tolerance; None where no reasonable number does."""
    room = study.tolerance_percent - abs(change)
    if freedom < 1 or not room > 0 or not math.isfinite(error):
        return None
    needed = math.ceil(seeds * (student_exceeded(1 - CONFIDENCE, freedom) * error / room) ** 2)
    return max(needed, seeds + 1) if needed <= MOST_SEEDS else None


def judge_scatter(
    relative: float, freedom: int, seeds: int, comparisons: int, study: StudyConfig
) -> tuple[float, Verdict]:
    """Half-width [%] of the interval of a point of the sweep with `seeds` seeds, and whether it is small enough.

    relative: standard deviation s between seeds over the mean [-], known with `freedom` degrees of freedom. The
    half-width is z s / sqrt(seeds). It agrees where it is within the tolerance with the upper bound of s (chi square),
    and differs where it is beyond with the lower bound, shared among the comparisons.
    """
    half = 100 * float(normal_exceeded((1 - CONFIDENCE) / 2)) * relative / math.sqrt(seeds)
    if freedom < 1 or not math.isfinite(half):
        return half, Verdict(OPEN, NO_INTERVAL)
    chance = 1 - CONFIDENCE
    upper = half * math.sqrt(freedom / chi_squared_quantile(chance, freedom))
    lower = half * math.sqrt(freedom / chi_squared_exceeded(chance / comparisons, freedom))
    return half, _by_either(study, Interval(upper, upper), Interval(lower, upper))


def check_study(table: pd.DataFrame, halves: pd.DataFrame, sweep_seeds: int, study: StudyConfig) -> list[Check]:
    """Every comparison of a study; table: as of `tabulate_study`; halves: as of `changes_of_halves`.

    sweep_seeds: how many seeds each condition of the mill's sweep has.
    """
    variants, freedom = table.iloc[1:], int((table["seeds"] - 1).sum())
    # A descriptor that is zero, as the shear of balls without friction, has no relative change.
    names = [name for name in DESCRIBED if table[name].iloc[0]]
    deciding = {setting: _refinement(variants, setting) for setting in variants["setting"].unique()}
    comparisons = max(
        1, sum(factor is not None for factor in deciding.values()) * len(names) + len(names) + len(halves)
    )
    checks = []
    for row in variants.itertuples():
        for name in names:
            change, error = (getattr(row, column_of(name, f"deviation{kind}_percent")) for kind in ("", "_se"))
            verdict = judge_change(change, error, freedom, comparisons, study)
            enough = seeds_to_decide(change, error, freedom, row.seeds, study) if verdict.word == OPEN else None
            decides = row.factor == deciding[row.setting]
            checks.append(Check(row.setting, row.factor, name, change, error, *verdict, decides, enough))
    for half in halves.itertuples():
        verdict = judge_change(half.change_percent, half.error_percent, half.freedom, comparisons, study)
        checks.append(Check("window", 0.5, half.quantity, half.change_percent, half.error_percent, *verdict))
    for name in names:
        relative = math.sqrt(pooled_variance(table[name], table[column_of(name, "se")], table["seeds"]))
        half_width, verdict = judge_scatter(relative, freedom, sweep_seeds, comparisons, study)
        wanted = (
            math.ceil(sweep_seeds * (half_width / study.tolerance_percent) ** 2) if verdict.word == DIFFERS else None
        )
        checks.append(Check("seeds", sweep_seeds, name, half_width, 0.0, *verdict, seeds=wanted))
    return checks


def _refinement(variants: pd.DataFrame, setting: str) -> float | None:
    """The factor of the refinement that decides on a setting: the one nearest to 1; None without one."""
    factors = variants.loc[variants["setting"] == setting, "factor"]
    finer = factors[factors < 1] if setting == "time_step" else factors[factors > 1]
    if finer.empty:
        return None
    return float(finer.max() if setting == "time_step" else finer.min())


def changes_of_halves(summaries: list[dict]) -> pd.DataFrame:
    """Change [%] of the powers from the first to the second half of the window, averaged over all runs.

    Each run is compared with itself, so that runs of any variant count alike. error_percent: the standard error.
    """
    rows = []
    for name in CHANNELS:
        changes = []
        for summary in summaries:
            energies = np.asarray(summary["per_revolution"][f"{name}_J"])
            half = len(energies) // 2
            if half and energies.mean():
                changes.append(100 * (energies[-half:].mean() - energies[:half].mean()) / energies.mean())
        number = len(changes)
        error = float(np.std(changes, ddof=1) / math.sqrt(number)) if number > 1 else np.nan
        change = float(np.mean(changes)) if changes else np.nan
        rows.append((f"{name}_power_W", change, error, number - 1))
    return pd.DataFrame(rows, columns=["quantity", "change_percent", "error_percent", "freedom"])


def verdict_of(checks: Iterable[Check]) -> Verdict:
    """The verdict of `judge_all` on those checks that decide: open, and not run, without any."""
    return judge_all(Verdict(check.verdict, check.reason) for check in checks if check.decides)


def conclude(mill: str, checks: list[Check], study: StudyConfig) -> dict:
    """The verdict on each setting and on all, and the one line that says it: verdict.json."""
    settings = {name: verdict_of(check for check in checks if check.setting == name).word for name in NAMES}
    overall = verdict_of(checks)
    return {
        "mill": mill,
        "verdict": overall.word,
        "reason": overall.reason,
        "line": f"{mill}: {_line(overall.word, settings, checks, study)}",
        "settings": settings,
        "criteria": {
            **study.model_dump(mode="json"),
            "tolerance_percent": study.tolerance_percent,
            **FACTORS,
            "confidence": CONFIDENCE,
        },
        "checks": [asdict(check) for check in checks],
    }


SAID = {
    AGREES: "the sweep agrees with finer settings",
    DIFFERS: "the sweep differs from finer settings",
    OPEN: "whether the sweep agrees with finer settings is open",
}


def _line(overall: str, settings: dict[str, str], checks: list[Check], study: StudyConfig) -> str:
    tested = {check.setting for check in checks if check.decides}
    of = {verdict: [name for name in settings if name in tested and settings[name] == verdict] for verdict in SAID}
    parts = []
    if overall == AGREES:
        largest = max((check for check in checks if check.decides), key=lambda check: abs(check.change_percent))
        parts.append(
            f"{_listed(of[AGREES])} change no descriptor by more than {study.tolerance_percent:g} % (largest: "
            f"{_told(largest)})"
        )
    for name in of[DIFFERS]:
        failed = [check for check in checks if check.setting == name and check.decides and check.verdict == DIFFERS]
        worst = max(failed, key=lambda check: abs(check.change_percent))
        seeds = max((check.seeds or 0 for check in failed), default=0)
        parts.append(f"{_told(worst)}: {ADVICE[name].format(seeds=seeds)}")
    if of[OPEN]:
        unknown = [check for check in checks if check.setting in of[OPEN] and check.verdict == OPEN]
        needed = [check.seeds for check in unknown if check.decides and check.setting not in ("window", "seeds")]
        enough = max(filter(None, needed), default=study.seeds + 1) if all(needed) else None
        more = f"about {enough} seeds" if enough else "many more seeds, or a longer window,"
        parts.append(
            f"the scatter between seeds hides a change of {study.tolerance_percent:g} % for {_listed(of[OPEN])}; "
            f"{more} would show it (convergence.study.seeds)"
        )
    if untested := [name for name in settings if name not in tested]:
        parts.append(f"{_listed(untested)} {NOT_RUN}")
    return f"{SAID[overall]}: {'; '.join(parts)}"


def _told(check: Check) -> str:
    """A check in words: the setting, the descriptor, and its change with one standard error."""
    title = DESCRIPTORS[check.quantity].title
    if check.setting == "seeds":
        return f"seeds, {title} known to {check.change_percent:.2g} %"
    times = "" if check.setting == "window" else f"{check.factor:g} times the "
    return f"{times}{NAMES[check.setting]}, {title} {check.change_percent:+.2g} ± {check.error_percent:.1g} %"


def _listed(names: list[str]) -> str:
    words = [NAMES[name] for name in names]
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
