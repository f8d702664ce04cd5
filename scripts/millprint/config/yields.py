"""Settings of the yields stage."""

from millprint.config.section import Section


class YieldConfig(Section):
    """Settings of the yields stage."""
