"""Errors that a user can correct: one line each, with the file, the key, the value and what to write."""

# Longer lines are shortened in the middle, where the user's value is; file and key come before it.
LONGEST_LINE = 600


def readable(line: str) -> str:
    """A line without control or invisible characters, shortened to LONGEST_LINE."""
    shown = "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in line)
    if len(shown) <= LONGEST_LINE:
        return shown
    return f"{shown[: LONGEST_LINE * 2 // 3]} ... {shown[-LONGEST_LINE // 3 :]}"


class MillprintError(Exception):
    """An error that the user can correct. Its text has a line for each fault and is shown without a traceback."""

    def __init__(self, text: str = "") -> None:
        super().__init__("\n".join(readable(line) for line in text.split("\n")))


class ConfigError(MillprintError):
    """A configuration file, a mill, a contact set or a data table is not valid."""


class DamagedFile(ConfigError, ValueError):
    """A result file is not as its job wrote it."""


class TrainingError(MillprintError):
    """The data or the loss of a training is not finite."""


class SimulationError(MillprintError):
    """A simulation's result is invalid: escaped ball, excessive overlap, or an energy balance that does not close."""
