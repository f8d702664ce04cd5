"""Printed values of the thesis get the factor of their quantity and fill ratio, and nothing else."""

import numpy as np
import pandas as pd
import pytest

from millprint.fingerprint.bands import ContactFactors
from millprint.run.files import write_table
from millprint.thesis.claims import tabulate as contact_intervals
from millprint.thesis.claims.evidence import Finding
from millprint.thesis.claims.tabulate import tabulate_contact_intervals
from tests.conftest import ROOT
from tests.unit.factor_samples import factors_of

CASES = {"reference": 0.10, "speed.tangential": 0.06, "speed.normal": 0.17, "power.normal": 0.17}


def test_the_interval_is_ours_times_the_factors(monkeypatch, tmp_path):
    known = {"3.curve.0.06.Pn": 30.0, "3.cycle.10mm.600.t": 0.5}

    def findings(results, claims_path, beginning) -> dict[str, Finding]:
        names = contact_intervals.read_claims(claims_path).index
        return {name: Finding(known.get(name)) for name in names if name.startswith(beginning)}

    monkeypatch.setattr(contact_intervals, "collect_findings", findings)
    columns = ["specific_frequency_hz", "power_W", "normal_energy_J", "tangential_energy_J", "ratio"]
    ours = pd.DataFrame({"curves": "ours", "case": list(CASES), "fill_ratio": list(CASES.values())})
    write_table(ours.assign(**dict.fromkeys(columns, 2e-4)), tmp_path / "partition/table_4_2.tsv")
    factors = ContactFactors(**factors_of())
    table = tabulate_contact_intervals(tmp_path, ROOT / "config/data/claims.tsv", factors, 0.08).set_index("id")
    curve = table.loc["3.curve.0.06.Pn"]
    assert (curve["published"], curve["ours"]) == (23.0, 30.0)
    low, high = factors.at(np.array([0.06]))["Pn"][:, 0]
    assert (curve["lower"], curve["upper"]) == (30 * low, 30 * high) and curve["verdict"] == "differs"
    cycle = table.loc["3.cycle.10mm.600.t"]
    assert cycle["upper"] == 0.5 * factors.at(np.array([0.08]))["Pt"][1, 0]
    # 2e-4 J in the unit of Table 4.2.
    for name, ours in {"En": 2.0, "Et": 2.0, "f": 2e-4, "P": 2e-4, "ratio": 2e-4}.items():
        assert table.loc[f"4.case.reference.{name}", "ours"] == pytest.approx(ours)
    missing = table.loc["3.curve.0.17.Pt"]
    assert np.isnan(missing["lower"]) and missing["verdict"] == "open"
