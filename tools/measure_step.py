"""What the step changes: the energy balance and the powers of mills at several steps, means over starting positions.

    python tools/measure_step.py --mills spex mixer --fractions 0.04 0.11 0.2 --seeds 24

Each mill runs in one condition of its own sweep, the first speed and balls and the middle fill ratio, as long as
precision `quick` does. A fraction is the step over the Rayleigh time; the first one is what the others are compared
with, in per cent and standard errors of both means.
"""

import argparse
from pathlib import Path

import numpy as np

from millprint.cases.of_mill import reference_case
from millprint.config.contact_set import ContactConfig
from millprint.config.load import load_named
from millprint.config.mill import MillConfig
from millprint.config.mill_sweep import MillsConfig
from millprint.config.sweep import DemConfig
from millprint.dem.run import simulate

CONFIG = Path(__file__).parents[1] / "config"
POWERS = ("wall", "normal", "tangential")


def main() -> None:
    """Print a line for each mill and step."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mills", nargs="+", default=["spex", "mixer", "emax", "vibratory", "planetary"])
    parser.add_argument("--fractions", nargs="+", type=float, default=[0.04, 0.11, 0.2, 0.3, 0.4])
    parser.add_argument("--contact", default="calibrated")
    parser.add_argument("--seeds", type=int, default=24)
    given = parser.parse_args()
    contact = load_named(CONFIG / "contacts", given.contact, ContactConfig, "contact set")
    # Bounds that no run exceeds, so that each takes the step that is asked for.
    dem = DemConfig(closure_max=0.99, rayleigh_fraction_max=0.99)
    print(
        "mill", "step/t_R", "closure_%", "largest_%", *(f"{name}_W (spread_%, change_%)" for name in POWERS), sep="\t"
    )
    for name in given.mills:
        mill = load_named(CONFIG / "mills", name, MillConfig, "mill")
        case = reference_case(mill, MillsConfig(contact=given.contact))
        first = None
        for fraction in given.fractions:
            own = [case.model_copy(update={"rayleigh_fraction": fraction, "seed": seed}) for seed in range(given.seeds)]
            found = [simulate(each, mill, contact, dem) for each in own]
            closures = 100 * np.array([each["closure"] for each in found])
            powers = np.array([[each["power_W"][power] for power in POWERS] for each in found])
            mean, spread = powers.mean(axis=0), powers.std(axis=0, ddof=1)
            first = first or (mean, spread)
            errors = np.hypot(spread, first[1]) / given.seeds**0.5 / first[0]
            changes = zip(mean, spread / mean, mean / first[0] - 1, errors, strict=True)
            told = (f"{a:.4g} ({100 * b:.1f}, {100 * c:+.1f}±{100 * d:.1f})" for a, b, c, d in changes)
            print(name, fraction, f"{closures.mean():.3f}", f"{closures.max():.3f}", *told, sep="\t", flush=True)


if __name__ == "__main__":
    main()
