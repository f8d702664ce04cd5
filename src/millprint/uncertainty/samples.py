"""The simulations behind the intervals of a mill: the varied case, its samples, and the compared contact set."""

import json
from pathlib import Path

import pandas as pd

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.config.mill_sweep import MillSweepConfig
from millprint.config.uncertainty import PARAMETERS, UncertaintyConfig
from millprint.uncertainty.space import Space, contact_space, with_fill
from millprint.uncertainty.varied import fill_ratios_of


def with_sweep(mill: dict, sweep: dict | None, derived: str | Path | None) -> MillConfig:
    """A mill from plain values, with its own sweep or the sweep from the file that was derived from it."""
    content = json.loads(Path(derived).read_text()) if derived else sweep
    return MillConfig(**mill).model_copy(update={"sweep": content and MillSweepConfig(**content)})


def contact_values(contact: ContactConfig) -> dict[str, float]:
    """The varied parameters of a contact set; if the set has no friction at walls, it is that between balls."""
    found = {name: getattr(contact, name, None) for name in PARAMETERS}
    return {name: contact.static_friction if value is None else value for name, value in found.items()}


def space_of(mill: MillConfig, uncertainty: UncertaintyConfig) -> Space:
    """Contact parameters and fill ratio. Raises ConfigError for a distribution without possible values."""
    return with_fill(contact_space(uncertainty.parameters), fill_ratios_of(mill, uncertainty))


def check_contact(space: Space, contact: ContactConfig) -> None:
    """Raise ConfigError, in one line, if the contact set of the predictions is outside the distributions.

    Likewise for one whose law has no Young's modulus, which is a variable.
    """
    contact.of_law("young_modulus_gpa")
    values = contact_values(contact)
    for variable in space.variables:
        low, high = variable.ends
        if variable.name in values and not low <= values[variable.name] <= high:
            raise ConfigError(
                f"uncertainty.parameters.{variable.name}: {low:g} to {high:g} leaves out {values[variable.name]:g} of "
                f"contact set {contact.name}, whose predictions get the intervals; widen the distribution, or set "
                "mills.contact to a set of your own values"
            )


def design_of(mill: MillConfig, uncertainty: UncertaintyConfig) -> pd.DataFrame:
    """The samples of a mill: contact parameters, fill ratio, and a seed of the starting positions for each."""
    design = space_of(mill, uncertainty).design(uncertainty.samples, uncertainty.seed)
    return design.assign(seed=range(len(design)))
