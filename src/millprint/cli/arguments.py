"""What every command needs to read its arguments."""

import argparse
import difflib
from collections.abc import Iterable


def parser_of(name: str, text: str | None) -> argparse.ArgumentParser:
    """The parser of a command, whose help is the docstring of its module."""
    return argparse.ArgumentParser(
        prog=f"millprint {name}", description=text, formatter_class=argparse.RawDescriptionHelpFormatter
    )


def close_to(word: str, known: Iterable[str]) -> str:
    """The end of a message about an unknown word: the nearest of those known, or all of them."""
    known = list(known)
    close = difflib.get_close_matches(word, known, n=1)
    return f"; did you mean {close[0]}?" if close else f"; known: {', '.join(known)}"
