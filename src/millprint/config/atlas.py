"""The atlas: how many simulations of each kind of mill it is made from."""

from typing import Annotated

from pydantic import Field

from millprint.config.section import Section

# Mills of each kind that no model sees.
HELD_OUT_MILLS = 100
Simulations = Annotated[int, Field(ge=0, le=5000)]


class AtlasConfig(Section):
    """The simulations of the atlas of mills: target `atlas`. The held-out mills, 100 of a kind, come on top.

    The defaults are those of the included atlas.
    """

    planetary: Simulations = 1600
    """rows of the design of planetary mills; those that teach something are simulated; 0 for none of the kind"""
    mixer: Simulations = 1000
    """of mixer mills"""
    drum: Simulations = 0
    """of tumbling drums"""
    spex: Simulations = 800
    """of shakers like the SPEX 8000"""

    @property
    def kinds(self) -> dict[str, int]:
        """The kinds that are made, with their simulations."""
        return {name: count for name, count in self if count}
