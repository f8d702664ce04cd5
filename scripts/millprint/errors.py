"""Errors that a user can mend: one line each, naming the file, the key, the value and what would be right."""

# Longer lines lose their middle: what stands there is a value of the user's, file and key come before it.
LONGEST_LINE = 600


def readable(line: str) -> str:
    """A line that a terminal shows as it is: no control characters or invisible ones, and no longer than needed."""
    shown = "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in line)
    if len(shown) <= LONGEST_LINE:
        return shown
    return f"{shown[: LONGEST_LINE * 2 // 3]} ... {shown[-LONGEST_LINE // 3 :]}"


class MillprintError(Exception):
    """Something that the user can mend; its text is a line for each fault and is shown without a traceback."""

    def __init__(self, text: str = "") -> None:
        super().__init__("\n".join(readable(line) for line in text.split("\n")))


class ConfigError(MillprintError):
    """A configuration file, a mill, a contact set or a data table that does not hold."""


class DamagedFile(ConfigError, ValueError):
    """A file of results that is not what a job wrote."""


class SimulationError(MillprintError):
    """A simulation that must not count as a result: escaped ball, excessive overlap, open energy balance."""
