"""Counting rules: what is one collision."""

from typing import Annotated

from pydantic import Field

from millprint.config.section import NonNegative, Section, first_repeated

RuleName = Annotated[str, Field(pattern=r"^[a-z][A-Za-z0-9_]*$", max_length=60)]


class CountingRule(Section):
    """Contacts of a pair within the gap are one collision; it counts if its peak force and its time are large enough.

    A pair is two balls, or a ball and one feature of the wall. First contacts are merged by the gap, then collisions
    under a threshold are dropped.
    """

    name: RuleName = Field(description="name of the rule")
    gap_s: NonNegative = Field(
        default=0.0, description="re-contacts of a pair within it are one collision; 0 counts single contacts [s]"
    )
    peak_force_min_N: NonNegative = Field(
        default=0.0, description="a collision whose largest normal force is smaller does not count [N]"
    )
    duration_min_s: NonNegative = Field(
        default=0.0, description="a collision that is in contact for a shorter time does not count [s]"
    )


DEFAULT_RULES = [
    CountingRule(name="lifetimes"),
    *(CountingRule(name=f"gap_{gap}ms", gap_s=gap / 1e3) for gap in (1, 2, 3, 4)),
]


def check_names(rules: list[CountingRule]) -> list[CountingRule]:
    """Refuse two rules of one name."""
    if twice := first_repeated(rule.name for rule in rules):
        raise ValueError(f"two counting rules are called {twice}; every rule needs a name of its own")
    return rules
