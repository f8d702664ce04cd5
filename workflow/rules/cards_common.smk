"""Shared by the rules of milling cards: their folder, and what each is made from."""

CARD = f"{RESULTS}/cards/{{card}}"


def contact_of_card(name: str) -> str:
    """The contact set of an experiment."""
    return CARD_EXPERIMENTS[name].contact or CONFIG.mills.contact_set


def carded(name: str, file: str) -> list[str]:
    """A file of every simulation of an experiment."""
    return [f"{RESULTS}/dem/{case.path}/{file}" for case in cases_of_card(name)]


def card_intervals(name: str) -> list[str]:
    """The fingerprint with intervals by contact parameters, if the whole run has their analysis for the mill."""
    mill = CARD_EXPERIMENTS[name].mill
    return [predicting(mill)] if mill in CONFIG.uncertainty.mills else []
