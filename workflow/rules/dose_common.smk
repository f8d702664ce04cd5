"""Shared by the rules of what a chemist reads off a mill: folder, counting rules, and the records of simulations."""

DOSE = f"{RESULTS}/dose"


def spectra_rules(own: str) -> list[str]:
    """The counting rules of spectra: that of the descriptors first, which the figures show."""
    return list(dict.fromkeys([own, *CONFIG.dose.spectra.counting_rules]))


def records_of(summaries) -> list[str]:
    """The records, run.h5, beside these summaries."""
    return [str(Path(path).with_name("run.h5")) for path in summaries]


def swept_summaries(contact: str) -> list[str]:
    """The summaries of the sweeps' conditions with a contact set, as the descriptors have them."""
    return [f"{RESULTS}/dem/{path}/summary.json" for path, case in DESCRIBED_CASES.items() if case.contact == contact]


def sliding_summaries() -> list[str]:
    """The summaries of the runs whose sliding work is measured: of the weighings, and of the mills of the section."""
    return WEAR_SUMMARIES + [path for name in WEAR.mills for path in mill_summaries(name)]
