"""How tests name the verdict on a claim by its value."""

from millprint.thesis.claims.evidence import ERRATUM, Finding, judge_value


def word_of(published: str, tolerance: str, finding: Finding) -> str:
    """The verdict, or `erratum` for one of these."""
    found = judge_value(published, tolerance, finding)
    return ERRATUM if found.reason == ERRATUM else found.word
