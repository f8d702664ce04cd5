"""The explorer's state in the address and in a file: what is set comes back, and what cannot is told in one line."""

import json

import pytest

from tests.browser import needs_browser
from tests.refusals import refusals

WAIT = "await new Promise((done) => setTimeout(done, 500));"
READ = """
  const read = () => JSON.stringify({ mill: explorer.mill.name, state: explorer.state, axis: explorer.axis,
    units: ["energy", "speed", "dose", "frequency"].map((kind) => explorer.units.of(kind).unit),
    chosen: explorer.spectra.chosen, shown: explorer.spectra.shown, heat: explorer.heat.chosen });
  const told = () => document.getElementById("told").textContent;"""
# Something else than the first state, in every part of it.
SET = """
  explorer.useMill(explorer.mills[1]);
  const settings = { speed_hz: 13.123456789, fill_ratio: 0.0777, density_kg_m3: 7123, bpr: 12.5, time_h: 7.25 };
  Object.assign(explorer.state, settings);
  explorer.axis = "speed_hz"; Object.assign(explorer.chosenUnits, { energy: "J", speed: "g", dose: "kWh/t" });
  explorer.spectra.chosen = ["emax/calibrated-d10-f0.06-n600", ""]; explorer.spectra.shown = "above";
  explorer.heat.chosen = explorer.mill.content.heat.conditions[1].id; explorer.render();"""


@pytest.fixture(scope="module")
def tab(browser):
    with browser.page() as page:
        yield page
        assert page.errors == []


@pytest.fixture
def page(built, tab):
    tab.open(built["page"])
    return tab


def opened(page, built, fragment: str) -> dict:
    """What the page shows when it is opened with an address that ends so."""
    page.go(f"{built['page'].resolve().as_uri()}?{abs(hash(fragment))}#{fragment}")
    return page.run(f"{READ} return {{ shown: read(), told: told() }};")


@needs_browser
def test_a_link_reproduces_the_state_and_leaves_one_entry_of_the_history(page, built):
    first = page.run(f"""{READ} const before = history.length; const untouched = location.hash; {SET}
      for (let k = 0; k < 30; k += 1) {{ explorer.state.fill_ratio = 0.0777; explorer.render(); }} {WAIT}
      return {{ shown: read(), hash: location.hash, entries: history.length - before, untouched }};""")
    assert first["untouched"] == "" and first["entries"] == 0
    assert "mill=planetary" in first["hash"] and "v=1" in first["hash"]
    again = opened(page, built, first["hash"].lstrip("#"))
    assert again == {"shown": first["shown"], "told": ""}
    # Also where the address of an open page is changed by hand.
    page.open(built["page"])
    changed = page.run(f"{READ} location.hash = {first['hash']!r}; {WAIT} return {{ shown: read(), told: told() }};")
    assert changed == again


@needs_browser
def test_a_link_to_first_choices_takes_back_later_ones(page):
    """An address leaves out what is empty."""
    first, later, again = page.run(f"""{READ} explorer.render(); {WAIT}
      const fragment = location.hash, first = read(); {SET} {WAIT} const later = read();
      location.hash = fragment; {WAIT} return [first, later, read()];""")
    assert first == again != later


@needs_browser
def test_a_link_can_be_copied_without_access_to_the_clipboard(page):
    """As on a page by plain http."""
    selected, told, address = page.run(f"""{SET}
      Object.defineProperty(navigator, "clipboard", {{ value: undefined }});
      let selected; document.execCommand = () => (selected = getSelection().toString(), true);
      document.getElementById("link").click(); {WAIT}
      return [selected, document.getElementById("told").textContent, location.href];""")
    assert selected == address and "mill=planetary" in address and told == "Copied."


@needs_browser
def test_a_file_reproduces_the_state(page, built):
    saved = page.run(f"""{READ} {SET} const text = explorer.keeper.file; const shown = read();
      let name = null; const click = HTMLAnchorElement.prototype.click;
      HTMLAnchorElement.prototype.click = function () {{ name = this.download; }};
      document.getElementById("save").click(); HTMLAnchorElement.prototype.click = click;
      return {{ text, shown, name }};""")
    content = json.loads(saved["text"])
    assert content["format"] == "millprint explorer state" and content["version"] == 1
    assert saved["name"] == "planetary_explorer.json"
    page.open(built["page"])
    again = page.run(f"""{READ} const files = new DataTransfer();
      files.items.add(new File([{saved["text"]!r}], "state.json"));
      const field = document.getElementById("open"); field.files = files.files;
      field.dispatchEvent(new Event("change")); {WAIT}
      return {{ shown: read(), told: told(), hash: location.hash }};""")
    assert again["shown"] == saved["shown"] and again["told"] == "" and "mill=planetary" in again["hash"]


@needs_browser
@pytest.mark.parametrize(("fragment", "words"), refusals("what_cannot_be_taken_is_told_in_one_line"))
def test_what_cannot_be_taken_is_told_in_one_line(page, built, fragment, words):
    said = opened(page, built, fragment)
    assert said["told"].startswith("Not taken from the address: ") and words in said["told"]
    assert "\n" not in said["told"] and json.loads(said["shown"])["mill"] == "emax"


@needs_browser
@pytest.mark.parametrize(
    "text", ["{}", "not JSON", "[1]", '{"format": "millprint explorer state", "state": 3}', "null"]
)
def test_a_file_of_something_else_is_told_in_one_line(page, text):
    said = page.run(
        f"{READ} const before = read(); explorer.keeper.read({text!r});"
        "return { told: told(), same: read() === before };"
    )
    assert said["same"] and said["told"].startswith("The file is not a state of this page")
