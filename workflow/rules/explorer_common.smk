"""Shared by the rules of the explorer: what a page takes from each mill."""

EXPLORED_WITH = {
    "name": CONFIG.name,
    "spectra": CONFIG.dose.spectra.model_dump(mode="json"),
    "rule": CONFIG.mills.rule,
    "descriptors": CONFIG.fingerprint.descriptors,
    "heat": CONFIG.dose.heat.model_dump(mode="json"),
}
# What a page takes from each mill, by the names of `millprint.explorer.simulated`.
OF_MILL = {
    "spectra": rules.describe_mill.output.spectra,
    "summary": rules.describe_mill.output.spectra_summary,
    "temperatures": rules.balance_heat.output.temperatures,
    "limits": rules.balance_heat.output.limits,
}


def explored(names) -> dict[str, list[str]]:
    """The files that the page of some mills is made from, in the order of the mills."""
    files = {key: [path.format(mill=name) for name in names] for key, path in OF_MILL.items()}
    return {"fingerprint": [predicting(name) for name in names], **files}
