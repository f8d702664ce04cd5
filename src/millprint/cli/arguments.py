"""What every command needs to read its arguments."""

import argparse


def parser_of(name: str, text: str | None) -> argparse.ArgumentParser:
    """The parser of a command, whose help is the docstring of its module."""
    return argparse.ArgumentParser(
        prog=f"millprint {name}", description=text, formatter_class=argparse.RawDescriptionHelpFormatter
    )
