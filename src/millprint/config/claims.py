"""Settings of the verdicts on the claims of the thesis."""

from typing import Annotated, ClassVar

from pydantic import Field

from millprint.config.section import Section


class ClaimsConfig(Section):
    """Intervals of the claims that depend on chance."""

    draws: Annotated[int, Field(ge=2, le=100_000)] = 200
    """times that the simulations of chapter 3 are drawn again from their own windows [-]"""
    # Level of the intervals that decide the verdicts [-].
    level: ClassVar[float] = 0.95
    # Seed of the draws.
    seed: ClassVar[int] = 0
