"""Puts the library on the path, as the Snakefile does for the scripts."""

import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
