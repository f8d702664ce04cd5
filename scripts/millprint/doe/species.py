"""Molar masses, by the atomic weights and the grammar of formulas of the library molmass."""

from molmass import Formula, FormulaError

from millprint.config.wet_lab import ChemistryConfig
from millprint.errors import ConfigError

# The products of the thesis's reaction, NaBO2.4H2O + 6 MgH2 -> NaBH4 + 6 MgO + 8 H2.
BOROHYDRIDE = "NaBH4"


def molar_mass(formula: str) -> float:
    """Molar mass of a formula such as NaBO2.4H2O [kg/mol]."""
    return 1e-3 * Formula(formula).mass


def check_formulas(chemistry: ChemistryConfig, place: str) -> None:
    """Raise ConfigError, in one line, for the first reactant whose formula is none; place: file and section."""
    for key in ("limiting", "reductant"):
        text = getattr(chemistry, key)
        try:
            mass, why = molar_mass(text), "it has no mass"
        except FormulaError as error:
            mass, why = 0.0, str(error).splitlines()[0]
        if not mass > 0:
            raise ConfigError(f"{place}.{key}: formula {text!r}: {why}; one such as NaBO2.4H2O would be right")
