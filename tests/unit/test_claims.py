"""The verdict on a claim follows from its tolerance alone."""

import pytest

from millprint.claims.compare import agrees, deviation, verdict
from millprint.claims.finding import Finding


@pytest.mark.parametrize(
    ("published", "tolerance", "value", "expected"),
    [
        ("0.153", "printed", 0.1539, True),  # truncated
        ("0.153", "printed", 0.1526, True),  # rounded
        ("0.153", "printed", 0.1541, False),
        ("-56", "printed", -56.9, True),
        ("-56", "printed", -57.0, False),
        ("400", "printed", 400.4, True),
        ("0.34", "printed", 0.333, False),
        ("C", "printed", "C", True),
        ("C", "printed", "B", False),
        ("23", "15%", 26.4, True),
        ("23", "15%", 26.5, False),
        ("0.3", "0.01", 0.309, True),
        ("0.3", "0.01", 0.311, False),
        ("small", "<=15%", 14.9, True),
        ("small", "<=15%", 15.1, False),
        ("3", ">=3", 2.9, False),
        ("0.0002", "<=2e-4", 0.00019, True),
        ("0.99", ">0.99", 0.99, False),
        ("yes", "yes", "no", False),
        ("0.30/0.045", "recover", "0.31/0.0455", True),
        ("0.30/0.045", "recover", "0.30/0.05", False),
        ("50", "report", 34.0, False),
        ("yes", "report", "yes", True),
        ("23", "15%", float("nan"), False),
    ],
)
def test_agrees(published, tolerance, value, expected):
    assert agrees(published, tolerance, value) is expected


def test_a_claim_without_a_value_was_not_run():
    assert verdict("23", "15%", Finding(None, "not run: left out")) == "not run"


def test_a_computed_reason_makes_an_erratum():
    assert verdict("6", "printed", Finding(4, erratum="4 by the rank of the design")) == "erratum"


def test_deviation_is_relative_to_the_published_number():
    assert deviation("20", 23) == pytest.approx(15)
    assert deviation("yes", "no") is None
    assert deviation("0", 3) is None
