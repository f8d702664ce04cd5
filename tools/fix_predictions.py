"""Records that the settings of the set-ups are fixed now: python tools/fix_predictions.py [SETUP ...] [--why WHY].

Adds date, time and a digest of the settings to the table config/data/fixed_predictions.tsv. Do this before a
prediction is compared with what was measured. A set-up whose settings have not changed gets no new row.
"""

import argparse
import datetime

from millprint.config.checks import CONFIGURATION, load_workflow, stop_on_bad_input
from millprint.config.errors import ConfigError
from millprint.config.strict_yaml import read_yaml
from millprint.validation.fixed import fix, settings_digest

CONFIG = "config/config.yaml"


def main(names: list[str], config_file: str, why: str = "") -> list[str]:
    """Record the set-ups of these names, or all, with the reason for fixing again; return a line for each."""
    config, mills, contacts, _ = load_workflow(read_yaml(config_file), [config_file])
    known = config.validation.chosen
    for name in names:
        if name not in known:
            raise ConfigError(f"{CONFIGURATION}: unknown set-up {name!r}; known: {', '.join(known)}")
    digests = {
        name: settings_digest(
            setup,
            mills[setup.mill_name] if setup.mill_name else None,
            {each: contacts[each] for each in setup.contact_names},
            config.dem,
        )
        for name, setup in known.items()
        if not names or name in names
    }
    now = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M")
    changed = fix(config.validation.fixed, digests, now, why)
    return [f"{name}: {'fixed now' if name in changed else 'unchanged'}" for name in digests]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("setups", nargs="*", help="set-ups; all if left out")
    parser.add_argument("--configfile", default=CONFIG, help="the configuration (default: %(default)s)")
    parser.add_argument("--why", default="", help="why settings that had been fixed have changed")
    given = parser.parse_args()
    with stop_on_bad_input():
        print("\n".join(main(given.setups, given.configfile, given.why)))
