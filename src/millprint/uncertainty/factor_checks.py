"""Checks the section `uncertainty` before a job starts, for the mills that are part of the whole run."""

from collections.abc import Iterator

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case
from millprint.config.workflow import WorkflowConfig


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
    from millprint.uncertainty.varied import fill_ratios_of, varied_case

    _, stiffest = settings.parameters.young_modulus_gpa.given_range
    found = []
    for name in settings.mills:
        case = varied_case(mills[name], config.mills, settings)
        fills = fill_ratios_of(mills[name], settings)
        change = {"young_modulus_gpa": stiffest}
        found += [case.model_copy(update={"fill_ratio": fill, **change}) for fill in (fills[0], fills[-1])]
    return found
