"""What a chapter's module says of a claim: the reproduced value and, where needed, why it differs."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Finding:
    """What was computed for one claim.

    value: the computed number or word, in the unit of the claim; None if it was not run.
    explanation: one sentence: how it was computed, over what, or why it was not run.
    erratum: a computed reason why the printed value cannot be right; the verdict is then `erratum`.
    """

    value: float | str | None
    explanation: str = ""
    erratum: str = ""
