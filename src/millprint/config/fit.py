"""The section `fit`: jar shape and counting rule, fitted to some published values and checked with the others."""

from typing import Annotated, ClassVar

from pydantic import Field

from millprint.config.section import Name, Positive, Section

# Published values are named quantity_fFILL or quantity_dDIAMETER_nSPEED, such as Pn_f0.06 and normal_d10_n1200.
ValueName = Annotated[str, Field(pattern=r"^(Pn|Pt|f)_f0\.\d+$|^(normal|tangential)_d[\d.]+_n\d+$")]
Count = Annotated[int, Field(ge=1)]


class StageConfig(Section):
    """One stage of the search: how many jars, and how long each is simulated."""

    jars: Count
    """jars that are simulated, or kept from the stage before"""
    revolutions: int = Field(ge=2)
    """revolutions of the mill that are recorded"""
    # Starting positions of each jar, the same for all: seeds from 0 on.
    seeds: ClassVar[int] = 1


class TrialConfig(Section):
    """The values that a jar is compared with, and the simulations for it."""

    contact: Name
    """contact set of the published values"""
    fitted: list[ValueName] = Field(min_length=1)
    """fitted values, at most half of each kind"""
    # Rules to choose from, without thresholds: those of the thesis, which count collisions with single facets.
    counting_rules: ClassVar[list[str]] = [
        "lifetimes_by_facet", "gap_0_01_by_facet", "gap_0_02_by_facet", "gap_0_03_by_facet", "gap_0_04_by_facet",
    ]  # fmt: skip
    ball_diameters_mm: list[Positive] = Field(min_length=1)
    """ball diameters that curves average over [mm]"""
    # Speeds that curves average over [rpm].
    speeds_rpm: ClassVar[list[float]] = [1200.0]
    # Integration step of the search [s].
    time_step_s: ClassVar[float] = 4e-6
    # Time for the balls to come to rest [s].
    settle_s: ClassVar[float] = 0.2
    discard_revolutions: int = Field(default=6, ge=0)
    """first revolutions, left out of the averages"""
    # In place of dem.closure_max, for the coarse step [-].
    closure_max: ClassVar[float] = 0.02
    refining: StageConfig = StageConfig(jars=5, revolutions=12)
    """simulations of the best jars, the steps from them, and the sensitivity"""


class FitConfig(TrialConfig):
    """A fit of a mill, its geometry a stadium, to values of data.published."""

    mill: Name
    """the mill that is fitted; a run of another mill fits nothing"""
    in_all: bool = False
    """whether the search is a part of `all`, and the shape of the jar, which follows from it, widens the intervals"""
    screening: StageConfig = StageConfig(jars=48, revolutions=10)
    """jars over the whole ranges, by a Sobol sequence"""
    rounds: Count = 2
    """rounds of steps up and down in every parameter, while one is better"""
    # Seed of the Sobol sequence.
    seed: ClassVar[int] = 0
