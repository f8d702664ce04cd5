"""A mill of the explorer from the files of its own sweep: fingerprint, spectra and temperatures."""

from typing import TypedDict

from millprint.config.dose import HeatConfig
from millprint.config.fingerprint import DescriptorSet
from millprint.config.mill import MillConfig
from millprint.explorer.condition_tables import Heat, Spectra
from millprint.explorer.content import Machine, mill_content
from millprint.fingerprint.condition_search import simulated_request
from millprint.fingerprint.model import Fingerprint

# The files of a mill, as the inputs of the rules name them.
EXPLORED = ("fingerprint", "spectra", "summary", "temperatures", "limits")


class Settings(TypedDict):
    """Settings that the tables of a run were made with: the rule to show, heat balance and descriptors."""

    rule: str
    heat: HeatConfig
    descriptors: DescriptorSet


def simulated_content(mill: dict, files: dict[str, str], settings: Settings) -> dict:
    """The data of the page for a mill; the search covers everything that was simulated.

    mill: its section as plain values; files: the files of EXPLORED by name.
    """
    request = simulated_request(Fingerprint.read(files["fingerprint"]), settings["descriptors"])
    return mill_content(
        Machine.of_mill(MillConfig(**mill)),
        [files["fingerprint"]],
        request,
        spectra=Spectra([(files["spectra"], files["summary"])], settings["rule"]),
        heat=Heat(files["temperatures"], files["limits"], settings["heat"]),
    )
