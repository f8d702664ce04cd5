"""Lists the files in RESULTS (default: results) that have changed since their jobs wrote them, and changes none.

    python scripts/verify_results.py [RESULTS]

The exit status is 0 if there are none, else 1.
"""

import sys
from pathlib import Path

from millprint.run.output_digests import report_damaged


def main(words: list[str]) -> int:
    if len(words) > 1 or any(word.startswith("-") for word in words):
        print(__doc__)
        return 2
    results = words[0] if words else "results"
    if report_damaged(Path(results) / "logs"):
        return 1
    print(f"checked: every file in {results} is as its job wrote it")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
