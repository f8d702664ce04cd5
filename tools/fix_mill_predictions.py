"""Fixes predictions for the included mills before anybody measures: python tools/fix_mill_predictions.py [--why WHY].

Adds those of each included fingerprint that is not in config/data/waiting_predictions.tsv, with date and digest; with
`--swing results/validation/leaf_spring/predictions.tsv` also those of the box on a leaf spring.
"""

import argparse
import datetime

from millprint.config.checks import stop_on_bad_input
from millprint.config.included import load_contact
from millprint.config.setup_models import SETTINGS
from millprint.config.shaken_models import LeafSpringConfig
from millprint.config.sweep import DemConfig
from millprint.run.files import read_table
from millprint.validation.fixed import settings_digest
from millprint.validation.waiting import LEAF_SPRING, TABLE, fix_swing, fix_waiting, swing_rows


def fix_leaf_spring(predictions: str, now: str, why: str) -> list[str]:
    """Add what a run predicts of the leaf spring; returns its name if that is new."""
    settings = SETTINGS[LEAF_SPRING]
    assert isinstance(settings, LeafSpringConfig)
    contacts = {settings.contact: load_contact(settings.contact)}
    digest = settings_digest(settings, None, contacts, DemConfig())
    rows = swing_rows(read_table(predictions, may_be_blank=["x", "lower", "upper", "id"]), settings)
    return [LEAF_SPRING] if fix_swing(TABLE, now, rows, digest, why) else []


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--why", default="", help="why a fingerprint that had been fixed has changed")
    parser.add_argument("--swing", default="", help="predictions.tsv of the set-up leaf_spring")
    given = parser.parse_args()
    with stop_on_bad_input():
        now = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M")
        fixed = fix_waiting(TABLE, now, given.why)
        fixed += fix_leaf_spring(given.swing, now, given.why) if given.swing else []
        print(f"fixed now: {', '.join(fixed) or 'nothing'}")
