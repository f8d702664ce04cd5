"""Puts the library on the path, as the Snakefile does for the scripts."""

import csv
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

# What the thesis prints, as text, by the id of the claim.
with open(ROOT / "config/data/claims.tsv") as file:
    PRINTED = {row["id"]: row["value"] for row in csv.DictReader(file, delimiter="\t")}
