"""The case of a mill that is varied for its intervals, and checks of the section `uncertainty`.

The Snakefile imports this, so no heavy imports here.
"""

from collections.abc import Iterator

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.config.mill_sweep import MillsConfig
from millprint.config.sweep import Case
from millprint.config.uncertainty import UncertaintyConfig
from millprint.config.workflow import WorkflowConfig
from millprint.fingerprint.cases import durations_of, mill_cases, sweep_of

# A simulation fails at this energy balance error over the wall work [-].
CLOSURE_MAX = 0.02
MOST_FILLS = 24


def varied_case(mill: MillConfig, settings: MillsConfig, uncertainty: UncertaintyConfig) -> Case:
    """The case that is varied: the first ball size and the first speed of the mill's sweep.

    It has a separate time step and, because only its samples are compared, a recorded time without the turns that the
    precision of a sweep asks for.
    """
    first, sweep = mill_cases(mill, settings)[0], sweep_of(mill)
    own = {"rayleigh_fraction": uncertainty.rayleigh_fraction, "closure_max": CLOSURE_MAX}
    return first.model_copy(update={**own, **durations_of(first.speed_rpm, sweep.discard_turns, sweep.window_turns)})


def fill_ratios_of(mill: MillConfig, uncertainty: UncertaintyConfig) -> list[float]:
    """The fill ratios at which intervals are given, from the section or from the mill's sweep, MOST_FILLS at most."""
    fills = sorted(sweep_of(mill).fills)
    return uncertainty.fill_ratios or [*fills[:: -(-len(fills) // MOST_FILLS)][:-1], fills[-1]]


def samples_of_job(mill: MillConfig, settings: MillsConfig, uncertainty: UncertaintyConfig) -> list[Case]:
    """A case of mean size and stiffness for each sample of a job; the samples spread evenly between the ends."""
    fills, (softest, stiffest) = fill_ratios_of(mill, uncertainty), uncertainty.parameters.young_modulus_gpa.given_range
    change = {"fill_ratio": (min(fills) + max(fills)) / 2}
    if softest is not None and stiffest is not None:
        change["young_modulus_gpa"] = (softest + stiffest) / 2
    mean = varied_case(mill, settings, uncertainty).model_copy(update=change)
    return [mean] * -(-uncertainty.samples // uncertainty.jobs)


def uncertainty_faults(
    config: WorkflowConfig, mills: dict[str, MillConfig], contacts: dict[str, ContactConfig], source: str
) -> Iterator[str]:
    """A line for each fault, with file, key, value and what to write; none if everything is valid."""
    settings = config.uncertainty
    if not settings.mills:
        return
    # Imported here: slow to import, and few configurations name such a mill.
    from millprint.uncertainty.samples import check_contact, space_of

    if settings.rayleigh_fraction > config.dem.rayleigh_fraction_max:
        yield (
            f"{source}: uncertainty.rayleigh_fraction = {settings.rayleigh_fraction:g}: at most "
            f"{config.dem.rayleigh_fraction_max:g} (dem.rayleigh_fraction_max)"
        )
    for name in settings.mills:
        try:
            check_contact(space_of(mills[name], settings), contacts[config.mills.contact_set])
        except ConfigError as error:
            yield f"{source}: {error}"


def uncertainty_cases(config: WorkflowConfig, mills: dict[str, MillConfig]) -> list[Case]:
    """The smallest and the largest charge of each mill in the section, with the stiffest balls, which take longest."""
    settings = config.uncertainty
    if not settings.mills:
        return []

    _, stiffest = settings.parameters.young_modulus_gpa.given_range
    found = []
    for name in settings.mills:
        case = varied_case(mills[name], config.mills, settings)
        fills = fill_ratios_of(mills[name], settings)
        change = {"young_modulus_gpa": stiffest}
        found += [case.model_copy(update={"fill_ratio": fill, **change}) for fill in (fills[0], fills[-1])]
    return found
