"""Shared by the rules of the explorer: what a page takes from each mill, and which mills have been run."""

from os.path import exists

from millprint.config.checks import MILL_FOLDER
from millprint.config.load import load_named
from millprint.config.mill import MillConfig
from millprint.records import digest

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


def further_mills(wildcards) -> list[dict]:
    """Every other mill that has been run in these results: its section, its files, and a digest of each.

    No inputs, because a whole run would then simulate these mills again whenever something of theirs changes. The
    digests make the page again once they have changed.
    """
    found = []
    for path in sorted(Path(RESULTS).glob("mills/*/fingerprint.json")):
        mill = described_mill(path.parent.name)
        if mill is None or mill.name == CONFIG.mill:
            continue
        files = {key: paths[0] for key, paths in explored([mill.name]).items()}
        # Without the analysis of its uncertainty, or before it, a mill has the fingerprint of its own sweep.
        files["fingerprint"] = next(filter(exists, [files["fingerprint"], str(path)]))
        known = {key: file for key, file in files.items() if exists(file)}
        found.append({"mill": dumped(mill), "files": known, "digests": [digest(file) for file in known.values()]})
    return found


def described_mill(name: str):
    """A mill of this run or in a file; None for results of a mill whose file is gone or is no mill any more."""
    try:
        return MILLS.get(name) or load_named(MILL_FOLDER, name, MillConfig, "mill", Sources(shipped))
    except ConfigError:
        return None
