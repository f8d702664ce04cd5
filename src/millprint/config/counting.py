"""Counting rules: what counts as one collision."""

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from millprint.config.errors import ConfigError
from millprint.config.section import NonNegative, Section, first_repeated

RuleName = Annotated[str, Field(pattern=r"^[a-z][A-Za-z0-9_]*$", max_length=60)]


class CountingRule(Section):
    """Contacts of a pair within the gap are one collision; it counts if its peak force and its time are large enough.

    A pair is two balls, or a ball and one surface of the wall. First contacts are merged by the gap, then collisions
    under a threshold are dropped.
    """

    name: RuleName
    """name of the rule"""
    by: Literal["surface", "facet"] = "surface"
    """wall part of a pair: a surface, however finely it is meshed, or a facet of it, as the thesis counted"""
    gap_turns: NonNegative = 0.0
    """if over 0, contacts of a pair within this time are one collision [turns of the mill]; without effect at rest"""
    peak_force_min_N: NonNegative = 0.0
    """smallest normal force at the peak that counts [N]"""
    duration_min_s: NonNegative = 0.0
    """shortest time in contact that counts [s]"""

    @model_validator(mode="before")
    @classmethod
    def _no_gap_in_seconds(cls, content: Any) -> Any:
        if isinstance(content, dict) and "gap_s" in content:
            raise ValueError(f"gap_s = {content['gap_s']}: write gap_turns = gap_s * rpm / 60, so that it scales")
        return content

    @property
    def has_threshold(self) -> bool:
        """Whether the rule drops collisions, so that those that count do not hold all of the dissipation."""
        return bool(self.peak_force_min_N or self.duration_min_s)

    def gap_s(self, frequency_hz: float) -> float:
        """The gap [s] of a mill that turns at a frequency [Hz]; 0 for one at rest."""
        return self.gap_turns / frequency_hz if frequency_hz else 0.0

    @classmethod
    def of_count(cls, count: dict) -> "CountingRule":
        """The rule of an entry of `collisions` in a run's summary."""
        return cls(**{name: count[name] for name in cls.model_fields})


DEFAULT_RULES = [
    CountingRule(name="lifetimes"),
    *(CountingRule(name=f"gap_0_0{hundredths}", gap_turns=hundredths / 100) for hundredths in (1, 2, 3, 4)),
]
DEFAULT_RULE = "gap_0_02"


def recorded_count(summary: dict, rule_name: str) -> dict:
    """The collisions of a run by the counting rule of that name; raises ConfigError for a rule that it lacks."""
    counts = {count["name"]: count for count in summary["collisions"]}
    if rule_name not in counts:
        raise ConfigError(
            f"counting_rule = {rule_name}: not among the rules that the simulations recorded ({', '.join(counts)}); "
            "add it to dem.counting_rules"
        )
    return counts[rule_name]


def check_names(rules: list[CountingRule]) -> list[CountingRule]:
    """Raise ValueError if two rules have the same name."""
    if twice := first_repeated(rule.name for rule in rules):
        raise ValueError(f"two counting rules have the name {twice}; names must differ")
    return rules
