"""Settings of the verdicts on the claims of the thesis."""

from typing import Annotated

from pydantic import Field

from millprint.config.section import Section, Seed


class ClaimsConfig(Section):
    """Intervals of the claims that depend on chance."""

    draws: Annotated[int, Field(ge=2, le=100_000)] = 200
    """times that the simulations of chapter 3 are drawn again from their own windows [-]"""
    level: Annotated[float, Field(gt=0, lt=1)] = 0.95
    """level of the intervals that decide the verdicts [-]"""
    seed: Seed = 0
    """seed of the draws"""
