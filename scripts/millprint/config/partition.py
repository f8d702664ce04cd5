"""Settings of the partition stage."""

from millprint.config.section import Section


class PartitionConfig(Section):
    """Settings of the partition stage."""
