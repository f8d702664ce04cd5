"""What a case changes of its mill and contact set: the amplitude, the balls' density, Young's modulus."""

from pydantic import ValidationError

from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.motion import MOTIONS, MotionSection, motion_kind
from millprint.config.sweep import Case
from millprint.errors import ConfigError


def overridden(case: Case, mill: MillConfig, contact: ContactConfig) -> tuple[MillConfig, ContactConfig]:
    """The mill and the contact set as a case runs them, its own values in place of theirs.

    Raises ConfigError as `mill_of`.
    """
    given = {"density_kg_m3": case.density_kg_m3, "young_modulus_gpa": case.young_modulus_gpa}
    changed = contact.model_copy(update={name: value for name, value in given.items() if value is not None})
    return mill_of(case, mill), changed


def mill_of(case: Case, mill: MillConfig) -> MillConfig:
    """The mill as a case runs it, with the case's own amplitude if it has one.

    Raises ConfigError for an amplitude of a mill whose motion has no radius A of a circle, or one out of bounds.
    """
    if case.amplitude_mm is None:
        return mill
    return mill.model_copy(update={"motion": _with_amplitude(case.amplitude_mm, mill)})


def _with_amplitude(amplitude_mm: float, mill: MillConfig) -> MotionSection:
    law, key = mill.motion, motion_kind(mill.motion.kind).amplitude_key
    if key is None:
        kinds = ", ".join(kind for kind, record in MOTIONS.items() if record.amplitude_key)
        raise ConfigError(
            f"sweeps: amplitudes_mm = {amplitude_mm:g}: the motion of mill {mill.name} is a {law.kind}, which has no "
            f"amplitude to set; a sweep over amplitudes needs one of {kinds}"
        )
    try:
        return type(law).model_validate({**law.model_dump(), key: amplitude_mm})
    except ValidationError as error:
        raise ConfigError(
            f"sweeps: amplitudes_mm = {amplitude_mm:g} of mill {mill.name}: {error.errors()[0]['msg'].lower()}"
        ) from None
