"""Molar masses and stoichiometry of the regeneration NaBO2.4H2O + 6 MgH2 -> NaBH4 + 6 MgO + 8 H2."""

from types import MappingProxyType

# Standard atomic weights, abridged (IUPAC 2021) [kg/mol].
ATOMIC_MASS = MappingProxyType({"H": 1.008e-3, "B": 10.81e-3, "O": 15.999e-3, "Na": 22.990e-3, "Mg": 24.305e-3})

BORATE = MappingProxyType({"Na": 1, "B": 1, "O": 6, "H": 8})
HYDRIDE = MappingProxyType({"Mg": 1, "H": 2})
BOROHYDRIDE = MappingProxyType({"Na": 1, "B": 1, "H": 4})

# mol of MgH2 that a mol of NaBO2.4H2O takes up: one for each of its six oxygen atoms.
STOICHIOMETRIC_RATIO = 6

# mol of H2 from a mol of NaBH4: NaBH4 + 2 H2O -> NaBO2 + 4 H2.
HYDROGEN_PER_BOROHYDRIDE = 4


def molar_mass(formula: dict[str, int]) -> float:
    """Molar mass of a formula given as atoms of each element [kg/mol]."""
    return sum(ATOMIC_MASS[element] * count for element, count in formula.items())
