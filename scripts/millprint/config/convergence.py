"""Settings of the convergence study: descriptors against time step and against Young's modulus."""

from pydantic import Field

from millprint.config.counting import RuleName
from millprint.config.section import Fraction, Positive, Section


class ConvergenceConfig(Section):
    """How the sweeps over time_steps_s and over young_moduli_gpa are judged.

    Energies and frequencies are those of fingerprint.counting_rule.
    """

    counting_rules: list[RuleName] = Field(
        default=["lifetimes"], description="further rules of dem.counting_rules that the tables show"
    )
    tolerance_percent: Positive = Field(
        default=1.0, description="largest deviation of a descriptor from that at the finest step, if not chance [%]"
    )
    confidence: Fraction = Field(
        default=0.95,
        description="probability that, of all comparisons of a sweep, none is called a deviation by chance [-]",
    )
    closure_max: Fraction = Field(
        default=0.001, description="largest energy balance error over the wall work at a step that is good enough [-]"
    )
