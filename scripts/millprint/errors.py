"""Errors that a user can mend: one line each, naming the file, the key, the value and what would be right."""


class MillprintError(Exception):
    """Something that the user can mend; its text is one line and is shown without a traceback."""


class ConfigError(MillprintError):
    """A configuration file, a mill, a contact set or a data table that does not hold."""


class SimulationError(MillprintError):
    """A simulation that must not count as a result: escaped ball, excessive overlap, open energy balance."""
