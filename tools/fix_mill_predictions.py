"""Fixes predictions for the included mills before anybody measures: python tools/fix_mill_predictions.py [--why WHY].

Adds those of each included fingerprint that is not in config/data/waiting_predictions.tsv, with date and digest.
"""

import argparse
import datetime

from millprint.config.checks import stop_on_bad_input
from millprint.validation.waiting import TABLE, fix_waiting

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--why", default="", help="why a fingerprint that had been fixed has changed")
    with stop_on_bad_input():
        now = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M")
        print(f"fixed now: {', '.join(fix_waiting(TABLE, now, parser.parse_args().why)) or 'nothing'}")
