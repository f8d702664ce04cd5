"""Compares the included fingerprints with those of another commit: python tools/compare_fingerprints.py fd50e33c.

Prints a row for each mill: how many conditions both have, and of each quantity the median of now over then, with the
number of conditions in which the two differ by more than twice the error of their ratio.
"""

import argparse
import json
import subprocess
from pathlib import Path

import numpy as np

from millprint.fingerprint.readers import FOLDER

QUANTITIES = {"Pn": "$P_n$", "Pt": "$P_t$", "f": "$f$", "En_star": "$E^*_n$", "Et_star": "$E^*_t$"}


def conditions_of(fingerprint: dict) -> np.ndarray:
    """The simulated conditions (n, k)."""
    return np.array([fingerprint["inputs"][name] for name in sorted(fingerprint["inputs"])]).T


def row_of(then: dict, now: dict) -> str:
    """The cells of a mill."""
    same = np.isclose(conditions_of(then)[:, None], conditions_of(now)).all(axis=2)
    old, new = np.nonzero(same)
    cells = [str(len(old))]
    for name in QUANTITIES:
        before, after = then["processes"][name], now["processes"][name]
        ratios = np.array(after["values"])[new] / np.array(before["values"])[old]
        errors = np.hypot(np.array(after["relative_errors"])[new], np.array(before["relative_errors"])[old])
        cells.append(f"{np.median(ratios):.2f} ({(np.abs(np.log(ratios)) > 2 * errors).sum()})")
    return " | ".join(cells)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("commit")
    commit = parser.parse_args().commit
    print("| mill | conditions | " + " | ".join(QUANTITIES.values()) + " |\n" + "|---" * (2 + len(QUANTITIES)) + "|")
    for path in sorted(Path(FOLDER).glob("*.json")):
        stored = subprocess.run(["git", "show", f"{commit}:./{path.name}"], cwd=path.parent, capture_output=True,
                                text=True, check=True)  # fmt: skip
        print(f"| {path.stem} | {row_of(json.loads(stored.stdout), json.loads(path.read_text()))} |")


if __name__ == "__main__":
    main()
