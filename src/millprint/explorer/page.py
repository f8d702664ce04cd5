"""The explorer: one HTML file with the fingerprints of mills, which computes in the browser and fetches nothing."""

from pathlib import Path
from typing import TypedDict

from millprint.config.dose import HeatConfig
from millprint.config.fingerprint import DescriptorSet
from millprint.config.mill import MillConfig
from millprint.explorer.content import Heat, Machine, Spectra, mill_content
from millprint.fingerprint.condition_search import simulated_request
from millprint.fingerprint.model import Fingerprint
from millprint.run.html_pages import embed_files, embed_json, render_page

FOLDER = Path(__file__).parent
# In the order of their dependencies.
SCRIPTS = (
    *("numerics.js", "fingerprint.js", "yields.js", "match.js", "search.js", "units.js", "mill.js", "conditions.js"),
    *("elements.js", "charts.js", "logcharts.js", "controls.js", "results.js", "finder.js", "spectra.js", "heat.js"),
    *("intro.js", "advice.js", "methods.js", "state.js", "page.js"),
)


def explorer_page(content: dict) -> str:
    """The page with `content` from `millprint.explorer.content.explorer_content`, from which it computes."""
    return render_page(
        FOLDER / "page.html",
        name=content["name"],
        title=content["mills"][0]["title"],
        near=f"{content['mills'][0]['search']['near_percent']:g}",
        style=embed_files(FOLDER, "page.css"),
        scripts=embed_files(FOLDER, *SCRIPTS),
        content=embed_json(content),
    )


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
