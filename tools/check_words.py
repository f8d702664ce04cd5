"""Finds words that readers had to read twice, in comments, texts and pages, and says what to write instead.

python tools/check_words.py
"""

import io
import re
import subprocess
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path

WORDS = {
    r"(?<![Tt]here )\b(is|are) no (?!longer\b|more\b|less\b|\w+er\b|other\b)\w+": "is not a",
    r"(?<!stand )(?<!stands )\balone\b": "only",
    r"\bso many\b": "the number, or n",
    r"\b(told|said|says|say|tell|tells) of\b": "reported for; says for",
    r"\bheld? (against|to)\b": "compared with",
    r"\bmend(s|ed)?\b": "fix",
    r"\bbeside\b": "next to, in addition to",
}
# The label of a row in tables of earlier runs too.
ALLOWED = ("power alone",)
PLACES = ("src", "scripts", "tools", "benchmarks", "workflow", "config", "docs", "*.md")
ENDINGS = (".py", ".smk", ".md", ".rst", ".yaml", ".html", ".js", ".ipynb")


def texts(path: Path) -> Iterator[tuple[int, str]]:
    """The lines of a file that people read, with their numbers: of Python the comments and strings."""
    content = path.read_text()
    if path.suffix != ".py":
        yield from enumerate(content.splitlines(), 1)
        return
    for token in tokenize.generate_tokens(io.StringIO(content).readline):
        if token.type in (tokenize.COMMENT, tokenize.STRING):
            yield from enumerate(token.string.splitlines(), token.start[0])


def main() -> int:
    listed = subprocess.run(["git", "ls-files", *PLACES], capture_output=True, text=True, check=True).stdout
    own, found = Path(__file__).resolve(), 0
    for path in map(Path, listed.splitlines()):
        if path.suffix not in ENDINGS or path.resolve() == own or path.name == "CHANGELOG.md" or not path.is_file():
            continue
        for number, line in texts(path):
            for pattern, better in WORDS.items():
                if (match := re.search(pattern, line)) and not any(words in line for words in ALLOWED):
                    print(f"{path}:{number}: {match[0]!r}: {better}: {line.strip()[:120]}")
                    found += 1
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
