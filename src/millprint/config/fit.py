"""The section `fit`: jar shape and counting rule, fitted to some published values and checked with the others."""

from typing import NamedTuple

from millprint.config.section import Name, ProjectFile, Section


class Stage(NamedTuple):
    """One stage of the search: jars that are simulated or kept, recorded turns of the mill, and seeds, from 0 on."""

    jars: int
    revolutions: int
    seeds: int = 1


class Whole(NamedTuple):
    """Conditions of chapter 3: sizes, fill ratios at the first and the last speed, and every speed at one fill ratio.

    revolutions: recorded turns, by the ball diameter.
    """

    fill_ratios: tuple[float, ...] = (0.04, 0.06, 0.08, 0.10, 0.12, 0.16, 0.17, 0.20, 0.30, 0.40)
    speeds_rpm: tuple[float, ...] = (600.0, 800.0, 1000.0, 1200.0)
    every_speed_at: float = 0.08
    revolutions: tuple[tuple[float, int], ...] = ((10.0, 30), (5.0, 12))


class JarSearch(Section):
    """The values that a jar is compared with, and the simulations of the search."""

    contact: str = "calibrated"
    """contact set of the published values"""
    fitted: list[str] = ["Pt_f0.06", "Pn_f0.10", "Pn_f0.17", "normal_d10_n1200", "tangential_d10_n1200", "f_f0.17"]
    """fitted values, at most half of each kind; all were known when the jar of emax.yaml was chosen, see there"""
    counting_rules: list[str] = [
        "lifetimes_by_facet", "gap_0_01_by_facet", "gap_0_02_by_facet", "gap_0_03_by_facet", "gap_0_04_by_facet",
    ]  # fmt: skip
    """rules of dem.counting_rules to choose from, without thresholds"""
    ball_diameters_mm: list[float] = [10.0, 5.0]
    """ball diameters that curves average over, fewer than in the sweeps [mm]"""
    speeds_rpm: list[float] = [1200.0]
    """speeds that curves average over [rpm]"""
    time_step_s: float = 4e-6
    """integration step [s]"""
    settle_s: float = 0.2
    """time for the balls to come to rest [s]"""
    discard_revolutions: int = 6
    """first revolutions, left out of the averages"""
    closure_max: float = 0.02
    """in place of dem.closure_max, for the coarse step [-]"""
    screening: Stage = Stage(jars=48, revolutions=10)
    """jars over the whole ranges, by a Sobol sequence"""
    refining: Stage = Stage(jars=5, revolutions=12)
    """the best jars again, the steps from them, and the sensitivity"""
    rounds: int = 2
    """rounds of steps up and down in every parameter, while one is better"""
    seed: int = 0
    """seed of the Sobol sequence"""
    equal_jars: int = 4
    """jars of those that fit equally well that are simulated at every condition of `whole`: the first of the table"""
    whole: Whole = Whole()
    """conditions of chapter 3 for each jar of that set"""


QUICK = JarSearch(
    fitted=["normal_d10_n1200"],
    counting_rules=["lifetimes_by_facet", "gap_0_03_by_facet"],
    ball_diameters_mm=[10.0],
    settle_s=0.1,
    discard_revolutions=2,
    screening=Stage(jars=2, revolutions=2),
    refining=Stage(jars=1, revolutions=2),
    rounds=1,
    equal_jars=2,
    whole=Whole(fill_ratios=(0.08,), speeds_rpm=(1200.0,), revolutions=((10.0, 2),)),
)


class FitConfig(Section):
    """A fit of a mill, its geometry a stadium, to values of data.published; `millprint.config.fit` has its settings."""

    mill: Name
    """the mill that is fitted; a run of another mill fits nothing"""
    equal_jars: ProjectFile | None = None
    """table of jars and counting rules that fit equally well, as the target `fit` writes it; claims of chapter 3 are
    judged by all of them
    """
    in_all: bool = False
    """whether the search is a part of `all`, and the shape of the jar, which follows from it, widens the intervals"""
    quick: bool = False
    """whether two jars are enough, for a test of the workflow"""

    @property
    def search(self) -> JarSearch:
        """The settings of the search."""
        return QUICK if self.quick else JarSearch()
