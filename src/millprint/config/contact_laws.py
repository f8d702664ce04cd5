"""Contact laws of a contact set: the keys of each kind, and its words in texts.

To add a law, write its keys, add a record to CONTACT_LAWS, and write the rest in a file of its name in
`millprint/dem/laws`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, get_type_hints

from pydantic import Field

from millprint.config.over_speed import Restitution, RestitutionOverSpeed
from millprint.config.section import Section


class LawKeys(Section):
    """The keys of a contact set that its law takes. One whose name begins with wall_ is that of a ball at a wall."""


class DampedKeys(LawKeys):
    """The keys of a law that is damped by a restitution."""

    restitution: RestitutionOverSpeed = Field(
        description="coefficient of restitution e [-], thesis Eq. 3.19; or over the speed of the hit, a table or a form"
    )
    wall_restitution: RestitutionOverSpeed | None = Field(
        None, description="restitution of a ball at a wall [-]; if left out, as between two balls"
    )


class HertzKeys(DampedKeys):
    """Springs of two elastic bodies."""

    young_modulus_gpa: Annotated[float, Field(ge=1e-6, le=1e5)] = Field(
        description="Young's modulus of balls and walls [GPa]"
    )
    poisson_ratio: Annotated[float, Field(gt=-1, lt=0.5)] = Field(description="Poisson's ratio of balls and walls [-]")


class LinearKeys(DampedKeys):
    """Springs of constant stiffness."""

    normal_stiffness_n_m: Annotated[float, Field(ge=1e-3, le=1e12)] = Field(
        description="normal stiffness k_n of every contact [N/m]"
    )
    tangential_stiffness_ratio: Annotated[float, Field(gt=0, le=10)] = Field(
        description="tangential over normal stiffness, k_t / k_n [-]; 2/7 gives both the same period"
    )


@dataclass(frozen=True)
class LawKind:
    """A contact law in a contact set.

    title: its name in texts; told: what texts say about a set of this law, words and unit by key, its stiffness last.
    """

    keys: type[LawKeys]
    title: str
    told: Mapping[str, tuple[str, str]]

    @property
    def names(self) -> tuple[str, ...]:
        """Its keys."""
        return tuple(self.keys.model_fields)


# By `kind`.
CONTACT_LAWS = {
    "hertz": LawKind(
        HertzKeys,
        "Hertz-Mindlin contact",
        {"restitution": ("restitution", ""), "young_modulus_gpa": ("Young's modulus", "GPa")},
    ),
    "linear": LawKind(
        LinearKeys,
        "linear spring-dashpot contact",
        {"restitution": ("restitution", ""), "normal_stiffness_n_m": ("normal stiffness", "N/m")},
    ),
}


def law_fields(plain: bool = False) -> dict[str, Any]:
    """The fields of the keys of all laws, None in a set whose law does not take them, with the kinds that do.

    plain: of one number, also where a key may depend on the speed of the hit.
    """
    fields: dict[str, Any] = {}
    for law in CONTACT_LAWS.values():
        types = get_type_hints(law.keys, include_extras=True)
        for key, own in law.keys.model_fields.items():
            kinds = ", ".join(kind for kind, each in CONTACT_LAWS.items() if key in each.names)
            over_speed = types[key] in (RestitutionOverSpeed, RestitutionOverSpeed | None)
            taken = Restitution if plain and over_speed else types[key]
            fields[key] = (taken | None, Field(default=None, description=f"of {kinds}: {own.description}"))
    return fields
