"""The section `view`: how the snapshots of a run are shown."""

from millprint.config.section import Count, Positive, Section


class ViewConfig(Section):
    """Animations from the snapshots of a case."""

    revolutions: Positive = 5.0
    """revolutions of the mill in an animation [-]"""
    frames_per_revolution: Count = 50
    """frames of an animation per revolution, if there are enough snapshots [-]"""
