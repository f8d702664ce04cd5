"""Settings so far from those that a mill was simulated with that a unit, or their order, is mistaken."""

from collections.abc import Mapping
from typing import Any

from millprint.config.errors import ConfigError
from millprint.config.wording import converted

# Nothing is known beyond what was simulated by this factor: energies go with the square of a speed, the cube of a size.
FAR = 10.0
# How people write a speed and a ball by mistake.
OTHER_UNITS = {"rpm": ("hz",), "mm": ("m", "cm", "µm")}


def _ranges(about: Mapping[str, Any]) -> dict[str, tuple[float, float]]:
    """What was simulated: speeds [rpm] and diameters [mm], by the key of a request."""
    ranges = about["ranges"]
    factors = {"speed_rpm": ("speed_hz", 60.0), "ball_diameter_mm": ("ball_diameter_m", 1e3)}
    return {key: (factor * ranges[name][0], factor * ranges[name][1]) for key, (name, factor) in factors.items()}


def check_near(about: Mapping[str, Any], **given: float) -> None:
    """Raise ConfigError, in one line with the likely mistake, for a setting that is far from what was simulated.

    about: of the fingerprint. given: speed_rpm or ball_diameter_mm, or both.
    """
    ranges, mill = _ranges(about), about["mill"]

    def far(key: str, value: float) -> bool:
        low, high = ranges[key]
        return not low / FAR <= value <= high * FAR

    for key, value in given.items():
        if not far(key, value):
            continue
        unit = key.rpartition("_")[2]
        meant = [text for other in OTHER_UNITS[unit] if not far(key, float(text := converted(value, other, unit)))]
        hint = f"; is it in another unit? Write {meant[0]}" if meant else ""
        if unit == "rpm" and not far(key, value / 60):
            hint = f"; is it in rpm and not in Hz? Write speed_rpm = {value / 60:g}"
        exchanged = zip(given, reversed(given.values()), strict=True)
        if len(given) > 1 and not any(far(*pair) for pair in exchanged):
            hint = "; speed and ball diameter stand in the place of each other: the speed comes first"
        low, high = ranges[key]
        raise ConfigError(
            f"{key} = {value:g}: {mill} was simulated with {low:g} to {high:g} {unit}, and nothing is known so far "
            f"from it{hint}"
        )
