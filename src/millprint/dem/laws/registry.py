"""The contact laws that there are, by the `kind` of a contact set: each is in the file of this folder with its name."""

from importlib import import_module

from millprint.config import contact_set
from millprint.config.contact_set import ContactConfig
from millprint.dem.laws.record import ContactLaw

LAWS: dict[str, ContactLaw] = {
    kind: import_module(f"millprint.dem.laws.{kind}").LAW for kind in contact_set.CONTACT_LAWS
}


def law_of(contact: ContactConfig) -> ContactLaw:
    """The law of a contact set."""
    return LAWS[contact.kind]


def mark_of(contact: ContactConfig) -> tuple:
    """The mark by whose type the kernels are compiled for a contact set: its law, with cohesion or without it."""
    law = law_of(contact)
    return law.cohesive_mark() if contact.cohesion else law.mark()


def step_scale(contact: ContactConfig, radius_m: float) -> float:
    """The time of which a step is a fraction, for balls of this radius [s]."""
    return law_of(contact).step_scale(contact, radius_m)
