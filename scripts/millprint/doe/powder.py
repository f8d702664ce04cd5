"""Powder charged for a ball-to-powder ratio and a molar ratio."""

import numpy as np

from millprint.config.wet_lab import ChemistryConfig
from millprint.doe.species import molar_mass


def powder_mass(ball_mass: np.ndarray | float, ball_to_powder: np.ndarray | float) -> np.ndarray | float:
    """Mass of powder for balls of total mass `ball_mass` [kg] at a mass ratio `ball_to_powder` [-]: [kg]."""
    return ball_mass / ball_to_powder


def ball_mass(balls: np.ndarray | float, diameter: np.ndarray | float, density: np.ndarray | float) -> np.ndarray:
    """Mass of `balls` spheres of `diameter` [m] and `density` [kg/m3], all together [kg]."""
    return balls * density * np.pi / 6 * np.asarray(diameter) ** 3


def reactant_masses(
    powder: np.ndarray | float, molar_ratio: np.ndarray | float, chemistry: ChemistryConfig
) -> tuple[np.ndarray | float, np.ndarray | float]:
    """Masses of the limiting reactant and of the reductant to weigh in, together `powder` [kg]: a pair [kg].

    molar_ratio is mol of pure reductant for a mol of pure limiting reactant; with a purity below 1 a mass holds less
    of its own and is made the larger.
    """
    limiting = molar_mass(chemistry.limiting) / chemistry.limiting_purity
    reductant = molar_ratio * molar_mass(chemistry.reductant) / chemistry.reductant_purity
    return powder * limiting / (limiting + reductant), powder * reductant / (limiting + reductant)


def excess(molar_ratio: np.ndarray | float, chemistry: ChemistryConfig) -> np.ndarray | float:
    """Excess of the reductant over what the reaction takes up: 10 over 6 gives 0.667, printed as 66 % [-]."""
    return molar_ratio / chemistry.stoichiometric_ratio - 1
