"""What a longer step before the averages, and the number of discarded turns, change: means over starting positions.

    python tools/measure_run_up.py --mills planetary mixer --seeds 12

Each mill runs in one condition of its own sweep, the first speed and balls and the middle fill ratio, as long as
precision `quick` does. A line `step` is the change of each descriptor, in per cent, by the step of
`dem.run_up_fraction` until the averages begin, with the standard error of the mean over pairs of runs from the same
seed, and the processor time over that with the recorded step. A line `turns` is by how much the powers of the turns
after N discarded ones differ from those of the second half of a run of `--turns` turns.
"""

import argparse
from pathlib import Path

import numpy as np

from millprint.cases.of_mill import reference_case
from millprint.config.contact_set import ContactConfig
from millprint.config.load import load_named
from millprint.config.mill import MillConfig
from millprint.config.mill_sweep import MillsConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.run import simulate

CONFIG = Path(__file__).parents[1] / "config"
POWERS = ("wall", "normal", "tangential")
DISCARDED, AVERAGED = (1, 2, 3, 5, 8, 10), 8


def descriptors(summary: dict) -> np.ndarray:
    """P, P_n, P_t, E*n, f*n, E*t, f*t of a run, in SI."""
    weighted = [summary["weighted"][channel] for channel in ("normal", "tangential")]
    named = [own[key] for own in weighted for key in ("energy_J", "specific_frequency_hz")]
    return np.array([*(summary["power_W"][power] for power in POWERS), *named])


def in_words(changes: np.ndarray) -> list[str]:
    """Mean changes and their standard errors over the seeds (seeds, values), of 1, in per cent."""
    errors = changes.std(axis=0, ddof=1) / len(changes) ** 0.5
    return [f"{100 * mean:+.1f}±{100 * error:.1f}" for mean, error in zip(changes.mean(axis=0), errors, strict=True)]


def main() -> None:
    """Print the lines of each mill."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--mills", nargs="+", default=["spex", "mixer", "emax", "vibratory", "planetary", "attritor", "drum"]
    )
    parser.add_argument("--contact", default="calibrated")
    parser.add_argument("--diameter", type=float, help="of the balls, instead of the first of the sweep [mm]")
    parser.add_argument("--fill", type=float, help="fill ratio, instead of the middle one of the sweep [-]")
    parser.add_argument("--seeds", type=int, default=12)
    parser.add_argument("--turns", type=int, default=40)
    given = parser.parse_args()
    contact = load_named(CONFIG / "contacts", given.contact, ContactConfig, "contact set")
    print("mill", "what", "processor", *POWERS, "E*n", "f*n", "E*t", "f*t", sep="\t")
    for name in given.mills:
        mill = load_named(CONFIG / "mills", name, MillConfig, "mill")
        own = reference_case(mill, MillsConfig(contact=given.contact))
        fixed = {"power_error_max": None, "window_max_s": None, "fill_ratio": given.fill or own.fill_ratio}
        diameter_m = given.diameter / 1e3 if given.diameter else own.ball_diameter_m
        case = own.model_copy(update=fixed | {"ball_diameter_m": diameter_m})

        def runs(case: Case, fraction: float, mill: MillConfig = mill) -> list[dict]:
            dem = DemConfig(closure_max=0.99, run_up_fraction=fraction)
            seeds = (case.model_copy(update={"seed": seed}) for seed in range(given.seeds))
            return [simulate(each, mill, contact, dem) for each in seeds]

        before, after = runs(case, 0), runs(case, DemConfig().run_up_fraction)
        took = [sum(each["processor_s"] for each in found) for found in (after, before)]
        old, new = (np.array([descriptors(each) for each in found]) for found in (before, after))
        print(name, "step", f"{took[0] / took[1]:.2f}", *in_words((new - old) / old.mean(axis=0)), sep="\t", flush=True)
        long = runs(case.model_copy(update={"discard_s": 0.0, "window_s": given.turns / case.speed_hz}), 0)
        turns = np.array([[each["per_revolution"][f"{power}_J"] for power in POWERS] for each in long])
        late = turns[..., turns.shape[-1] // 2 :].mean(axis=-1)
        for number in DISCARDED:
            first = turns[..., number : number + AVERAGED].mean(axis=-1)
            print(name, f"{number} turns", "", *in_words((first - late) / late.mean(axis=0)), sep="\t", flush=True)


if __name__ == "__main__":
    main()
