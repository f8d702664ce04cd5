"""Settings and rows of the yield stage for tests: those of the thesis, at a small search budget."""

import numpy as np
import pandas as pd

from millprint.config.load import check_model
from millprint.config.yields import SPACES, AveragingConfig, YieldConfig
from millprint.observables.condition import Condition
from millprint.thesis.regimes import read_regimes
from millprint.thesis.yields.averaging import Candidate, Member, fit_described
from millprint.thesis.yields.experiments import Mill, read_parts
from millprint.thesis.yields.features import describe
from millprint.thesis.yields.new_conditions import MillCurves
from tests.conftest import ROOT, configuration
from tests.unit.doe_settings import SCREENING
from tests.unit.doe_settings import settings as doe_settings

SPLIT = ROOT / "config/data/split.tsv"
REGIMES = ROOT / "config/data/regimes.tsv"
REFERENCE = Condition(0.10, speed_hz=10.0, ball_diameter_m=0.01, density_kg_m3=7700.0, amplitude_m=17 * 1e-3)
MILL = Mill(density=7700.0, amplitude=0.017, volume=125e-6)
CASES = read_regimes(str(REGIMES))
CURVES = MillCurves("emax", CASES, MILL.density, MILL.amplitude, (10.0,), (540.0, 1000.0))
SCALES = ("linear", "linear", "log", "log", "linear")
# A few members, so that a fit takes milliseconds.
SMALL_LIBRARY = {
    "links": ["identity", "avrami"],
    "structures": ["product"],
    "scales": {
        "bpr": ["linear"],
        "molar_ratio": ["linear"],
        "time_h": ["log"],
        "power_per_ball_mW": ["log"],
        "tangential_share": ["linear"],
    },
}
SMALL_EVALUATION = {"outer_folds": 3, "outer_repeats": 2, "orders": 2, "random_splits": 2, "conformal_folds": 3}
SMALL = {"evaluations": dict.fromkeys(SPACES, 2), "folds": 2, "repeats": 1}


def thesis_yields() -> dict:
    """The section `yields` of config/config.yaml."""
    section = configuration()["yields"]
    section["prediction"]["conditions"] = str(ROOT / section["prediction"]["conditions"])
    return section | {"out_of_domain": str(ROOT / section["out_of_domain"])}


def settings(**training) -> YieldConfig:
    """The thesis's settings with a small search, small forests, and changed keys of `training`."""
    section = thesis_yields()
    section["training"]["spaces"] = {
        name: {"n_estimators": [5, 10]} for name, space in SPACES.items() if "n_estimators" in space
    }
    section["training"] |= training
    section["training"]["kernel_starts"] = 2
    section["search"] = SMALL
    section["evaluation"] |= {**SMALL, **SMALL_EVALUATION, "resamples": 200}
    section["averaging"] |= SMALL_LIBRARY
    section["library_trial"] |= {"permutations": 19}
    section["proposals"] |= {"runs": 2, "shortlist": 40, "draws": 200}
    return check_model(section, YieldConfig, "config.yaml")


def all_runs() -> pd.DataFrame:
    """The 27 screening runs in the order of the split."""
    return pd.concat(parts(), ignore_index=True)


def parts() -> tuple[pd.DataFrame, pd.DataFrame]:
    """The training and test rows of the locked split."""
    return read_parts(str(SCREENING), str(SPLIT), doe_settings().factors)


def fit_member(candidate: Candidate, rows: pd.DataFrame, yields: np.ndarray, settings: AveragingConfig) -> Member:
    """A member of the library, fitted on rows with the six conditions."""
    return fit_described(candidate, describe(rows).to_numpy(), yields, settings)
