"""Powder charged for a ball-to-powder ratio and a molar ratio."""

from millprint.doe.species import BORATE, HYDRIDE, STOICHIOMETRIC_RATIO, molar_mass


def powder_mass(ball_mass: float, ball_to_powder: float) -> float:
    """Mass of powder for balls of total mass `ball_mass` [kg] at a mass ratio `ball_to_powder` [-]: [kg]."""
    return ball_mass / ball_to_powder


def reactant_masses(powder: float, molar_ratio: float) -> tuple[float, float]:
    """Masses of NaBO2.4H2O and of MgH2 in `powder` [kg] with `molar_ratio` mol of MgH2 for a mol of borate [kg]."""
    borate, hydride = molar_mass(BORATE), molar_ratio * molar_mass(HYDRIDE)
    return powder * borate / (borate + hydride), powder * hydride / (borate + hydride)


def excess(molar_ratio: float) -> float:
    """Excess of MgH2 over the stoichiometric 6 mol for a mol of borate: 10 gives 0.667, printed as 66 % [-]."""
    return molar_ratio / STOICHIOMETRIC_RATIO - 1
