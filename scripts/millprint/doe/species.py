"""Molar masses, by the atomic weights and the grammar of formulas of the library molmass."""

from molmass import Formula

# The products of the thesis's reaction, NaBO2.4H2O + 6 MgH2 -> NaBH4 + 6 MgO + 8 H2.
BOROHYDRIDE = "NaBH4"


def molar_mass(formula: str) -> float:
    """Molar mass of a formula such as NaBO2.4H2O [kg/mol]."""
    return 1e-3 * Formula(formula).mass
