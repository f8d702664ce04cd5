"""Settings of the fingerprint stage."""

from millprint.config.section import Section


class FingerprintConfig(Section):
    """Settings of the fingerprint stage."""
