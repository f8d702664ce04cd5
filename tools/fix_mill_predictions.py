"""Fixes predictions for the included mills before anybody measures: python tools/fix_mill_predictions.py RELEASE.

Adds those of each included fingerprint that is not in config/data/waiting_predictions.tsv, with date and digest, as the
generation of a release, such as 0.4.0; with `--swing results/validation/leaf_spring/predictions.tsv` also those of the
box on a leaf spring. Rows that this release had before are replaced, those of earlier releases stay.
"""

import argparse
import datetime
from pathlib import Path

from millprint.config.checks import stop_on_bad_input
from millprint.config.setup_models import SETTINGS, LeafSpringConfig
from millprint.run.files import read_table
from millprint.validation.waiting import LEAF_SPRING, TABLE, digest_of_file, fix_rows, fix_waiting, swing_rows

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("release", help="version that is to be released")
    parser.add_argument("--swing", type=Path, help="predictions.tsv of the set-up leaf_spring")
    given = parser.parse_args()
    with stop_on_bad_input():
        now = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M")
        fixed = fix_waiting(TABLE, given.release, now)
        if given.swing:
            settings = SETTINGS[LEAF_SPRING]
            assert isinstance(settings, LeafSpringConfig)
            rows = swing_rows(read_table(given.swing, may_be_blank=["x", "lower", "upper", "id"]), settings)
            if fix_rows(TABLE, given.release, now, lambda: rows, LEAF_SPRING, digest_of_file(given.swing)):
                fixed.append(LEAF_SPRING)
        print(f"fixed now: {', '.join(fixed) or 'nothing'}")
