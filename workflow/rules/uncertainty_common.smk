"""Shared by the rules of uncertainty: folders, and the files that they need and make."""

from millprint.thesis.fit import FEWEST_JARS, fitted_mill

UNCERTAINTY = f"{RESULTS}/uncertainty/{{mill}}"


def shape_of(mill: str) -> list[str]:
    """The file of a fitted jar's shape, if the search of the fit is a part of the whole run."""
    fitted = fitted_mill(CONFIG, MILLS) if CHAPTERS and CONFIG.fit.in_all else None
    if fitted is None or fitted.name != mill or CONFIG.fit.screening.jars < FEWEST_JARS:
        return []
    return [f"{RESULTS}/uncertainty/{fitted.name}/shape.json"]


def predicting_chapter(contact: str) -> str:
    """The fingerprint of chapter 3 of a contact set: with all its intervals if the whole run has their analysis."""
    analysed = CONFIG.mill in CONFIG.uncertainty.mills and contact == CONFIG.mills.contact_set
    folder = f"{RESULTS}/uncertainty/{CONFIG.mill}" if analysed else f"{RESULTS}/fingerprint"
    return f"{folder}/fingerprint_{contact}.json"


def uncertainty_of(mills) -> list[str]:
    """Every file of the uncertainty of some mills, and their fingerprints with the intervals."""
    own = expand([*rules.measure_uncertainty.output, *rules.add_uncertainty.output], mill=mills)
    # The curves of chapter 3 are those of the run's mill.
    chapter = [f"{RESULTS}/uncertainty/{CONFIG.mill}/fingerprint_{CONFIG.mills.contact_set}.json"]
    return [*own, *(chapter if CHAPTERS and CONFIG.mill in mills else [])]
