"""The simulations that show whether the settings of a mill's sweep are good enough: one condition, varied.

The Snakefile asks for them, so nothing that takes long is imported here.
"""

from collections.abc import Mapping
from itertools import count, islice
from typing import NamedTuple

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.fingerprint import StudyConfig
from millprint.config.mill import MillConfig
from millprint.config.mill_sweep import MillsConfig
from millprint.config.sweep import Case, DemConfig, mill_of
from millprint.dem.laws.registry import step_scale
from millprint.fingerprint.cases import mill_cases, sweep_of

# Factors on the time step (the largest under 1 decides), on Young's modulus, and on the number of facets around the
# vessel (the smallest over 1 decides) [-].
FACTORS = {"step_factors": (0.5, 2.0), "modulus_factors": (0.3, 3.0), "facet_factors": (0.5, 2.0)}
# The largest balance error of a variant: large, so that a coarse variant is compared and not refused.
CLOSURE_MAX = 0.5


class Variant(NamedTuple):
    """Runs that differ from the sweep in one setting: `reference`, `time_step`, `stiffness` or `facets`.

    factor: of the setting, over the sweep's [-]; value: the setting itself, in the unit of its key.
    """

    setting: str
    factor: float
    value: float
    cases: list[Case]


def study_variants(
    mill: MillConfig,
    contact: ContactConfig,
    mills: MillsConfig,
    dem: DemConfig,
    study: StudyConfig,
    taken: Mapping[str, Case],
) -> list[Variant]:
    """The reference and its variants at the first speed, the first balls and the middle fill ratio of the sweep.

    taken: cases of other sweeps by path, which run with their own settings; their seeds are not used again. A step
    over dem.rayleigh_fraction_max and a number of facets that the shape cannot have are left out as well.
    Raises ConfigError as `sweep_of`.
    """
    first = reference_case(mill, mills)
    changes = [("reference", 1.0, 0.0, {}), *_changes(first, mill, contact, dem, study)]
    wanted = [first.model_copy(update=changed) for *_, changed in changes]

    def is_free(seed: int) -> bool:
        cases = [case.model_copy(update={"seed": seed}) for case in wanted]
        return all(taken.get(case.path, case) == case for case in cases)

    own = sweep_of(mill).seeds
    seeds = list(islice(filter(is_free, [*own, *_others(own)]), study.seeds))
    return [
        Variant(setting, factor, value, [case.model_copy(update={"seed": seed}) for seed in seeds])
        for (setting, factor, value, _), case in zip(changes, wanted, strict=True)
    ]


def _others(seeds: list[int]) -> list[int]:
    """As many further seeds as could be needed."""
    return list(islice((seed for seed in count() if seed not in seeds), 1000))


def reference_case(mill: MillConfig, mills: MillsConfig) -> Case:
    """The first case of a mill's sweep, at the middle fill ratio; of an even number of them the lower one."""
    sweep = sweep_of(mill)
    fills = sorted(sweep.fills)
    middle = fills[(len(fills) - 1) // 2]
    return next(case for case in mill_cases(mill, mills) if case.fill_ratio == middle)


def _changes(
    case: Case, mill: MillConfig, contact: ContactConfig, dem: DemConfig, study: StudyConfig
) -> list[tuple[str, float, float, dict[str, float]]]:
    """Setting, factor and value of each variant, and the keys of the case that it changes."""
    stiffness = contact.young_modulus_gpa or 0.0
    scale = step_scale(contact, min(case.sizes_mm) / 2000)
    fraction = case.rayleigh_fraction or 0.0
    loose = {"closure_max": CLOSURE_MAX}
    changes: list[tuple[str, float, float, dict[str, float]]] = []
    for factor in FACTORS["step_factors"]:
        if factor * fraction <= dem.rayleigh_fraction_max:
            # Few digits, for the name of the case.
            step = float(f"{factor * fraction * scale:.4g}")
            changes.append(("time_step", factor, step, loose | {"time_step_s": step}))
    # A law without this modulus has no such variant.
    for factor in FACTORS["modulus_factors"] if stiffness else []:
        # Each modulus has its own stable step, the same fraction of its scale.
        modulus = float(f"{factor * stiffness:.6g}")
        changes.append(("stiffness", factor, modulus, loose | {"young_modulus_gpa": modulus}))
    own = facets_of(mill)
    for factor in FACTORS["facet_factors"] if own else []:
        facets = round(factor * own)
        try:
            mill_of(case.model_copy(update={"facets": facets}), mill)
        except ConfigError:
            continue
        if facets != own:
            changes.append(("facets", factor, facets, {"facets": facets}))
    return changes


def facets_of(mill: MillConfig) -> int:
    """The number of flat facets around a vessel; 0 for one that is not round, or comes from a file."""
    key = mill.geometry.facets_key
    return getattr(mill.geometry, key) if key else 0
