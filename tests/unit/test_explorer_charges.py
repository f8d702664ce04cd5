"""The explorer of a mill with charges of several ball sizes: a choice by name, with the numbers of the library."""

import numpy as np
import pytest

from millprint.config.charge import BallMixture
from millprint.explorer.content import Machine, explorer_content, explorer_page, mill_content
from millprint.fingerprint.condition_search import rank_conditions, simulated_request
from millprint.fingerprint.descriptors import tabulate_descriptors
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.readers import charges_of
from millprint.observables.definitions import DESCRIPTOR_SETS, TARGET_DESCRIPTORS
from tests.browser import needs_browser
from tests.unit.explorer_pages import heat_of
from tests.unit.synthetic_mill import FILLS, VOLUME, summaries, summary

THREE = BallMixture(name="three", sizes_mm=(12, 10, 6), numbers=(1, 1, 2))
TWICE = BallMixture(name="twice", sizes_mm=(14, 8), numbers=(1, 3))
BANDS = (*TARGET_DESCRIPTORS, "normal_power_W", "tangential_power_W", "wall_power_W", "tangential_share")


def _charged(charges: dict[BallMixture, float]) -> list[dict]:
    """Runs of charges that dissipate more than the scaling has it, each by its factor."""
    return [
        summary(fill, speed_rpm=speed, mixture=charge, factor=factor)
        for charge, factor in charges.items()
        for fill in FILLS[::2]
        for speed in (600.0, 1200.0)
    ]


@pytest.fixture(scope="module")
def mills(tmp_path_factory) -> dict:
    """Fingerprints of balls of two sizes and two charges, and of only one charge, with their pages."""
    folder, found = tmp_path_factory.mktemp("charges"), {}
    for name, runs in {
        "both": summaries(fills=FILLS[::2]) + _charged({THREE: 1.5, TWICE: 3.0}),
        "alone": _charged({THREE: 1.0}),
    }.items():
        file, page = folder / f"{name}.json", folder / f"{name}.html"
        Fingerprint.fit(tabulate_descriptors(runs, "gap_0_03"), VOLUME, 0.95, charges_of(runs)).write(file)
        own = Fingerprint.read(file)
        charged = [summary(0.12, speed_rpm=900.0, mixture=charge) for charge in (THREE, TWICE)]
        heat = heat_of(folder, name, [*charged, summary(0.12, speed_rpm=900.0)])
        content = mill_content(Machine("emax", "A mill"), [file], simulated_request(own, "weighted"), heat=heat)
        page.write_text(explorer_page(explorer_content("a_run", [content])))
        found[name] = {"file": file, "page": page, "fingerprint": own}
    return found


@pytest.fixture
def page(browser):
    with browser.page() as page:
        yield page
        assert page.errors == []


@pytest.mark.slow
@needs_browser
@pytest.mark.parametrize("name", ["both", "alone"])
def test_the_page_computes_what_the_library_computes_of_charges(mills, page, name):
    own, generator = mills[name]["fingerprint"], np.random.default_rng(3)
    states, theirs = [], []
    for choice in (*own.choices(), *own.choices()):
        diameter, charge = own.balls(choice)
        speed, fill = generator.uniform(8, 22), generator.uniform(0.03, 0.45)
        condition = own.condition(speed_hz=speed, ball_diameter_m=diameter, fill_ratio=fill)
        states.append({**vars(condition), "charge": charge})
        found = own.predict(condition, charge=charge)
        bands = [[getattr(getattr(found, band), end) for end in ("value", "lower", "upper")] for band in BANDS]
        counts = own.charges[charge].counts(found.balls) if charge else []
        theirs.append({"bands": bands, "outside": sorted(found.outside), "counts": counts})
    # Balls that were not simulated.
    states.append(states[0] | {"charge": "other"})
    found = own.predict(own.condition(**{k: states[0][k] for k in CONDITION}), charge="other")
    bands = [[getattr(getattr(found, band), end) for end in ("value", "lower", "upper")] for band in BANDS]
    theirs.append({"bands": bands, "outside": sorted(found.outside), "counts": []})
    page.open(mills[name]["page"])
    ours = page.run(f"""return {states!r}.map((state) => {{
      const found = explorer.answer(state);
      const own = explorer.fingerprint;
      return {{ bands: {list(BANDS)!r}.map((name) => [found[name].value, found[name].lower, found[name].upper]),
        outside: [...found.outside].sort(),
        counts: own.about.charges[state.charge] ? own.counts(state.charge, found.balls) : [] }};
    }});""")
    np.testing.assert_allclose([each["bands"] for each in ours], [each["bands"] for each in theirs], rtol=1e-6)
    for key in ("outside", "counts"):
        assert [each[key] for each in ours] == [each[key] for each in theirs]
    assert ours[-1]["outside"][0] == "charge"


CONDITION = ("speed_hz", "ball_diameter_m", "fill_ratio")


@needs_browser
def test_a_charge_is_chosen_by_its_name(mills, page):
    page.open(mills["both"]["page"])
    said = page.run("""
      const shown = (id) => document.getElementById(id).closest(".slider").checkVisibility();
      const labels = [...document.querySelectorAll("#media label")].map((e) => e.textContent);
      const start = { diameter: explorer.state.ball_diameter_m, slider: shown("ball_diameter_m"),
        text: document.getElementById("charge-said").textContent };
      explorer.axis = "ball_diameter_m"; explorer.render();
      const radio = document.querySelector("#media input[value=twice]"); radio.checked = true;
      radio.dispatchEvent(new Event("change"));
      const chosen = { diameter: explorer.state.ball_diameter_m, slider: shown("ball_diameter_m"), axis: explorer.axis,
        shown: document.getElementById("axis").value, text: document.getElementById("charge-said").textContent,
        balls: explorer.answer(explorer.state).balls, outside: document.getElementById("outside").textContent };
      document.querySelector("#media input[value='']").dispatchEvent(new Event("change"));
      return { labels, start, chosen, back: explorer.state.ball_diameter_m, again: shown("ball_diameter_m"),
        yields: document.body.innerText.includes("yield"),
        charts: document.querySelectorAll("#charts svg").length };""")
    mean = f"{TWICE.mean_diameter_mm:.3g}"
    assert said["labels"][0] == "balls of one size" and said["labels"][2] == f"twice (d30 = {mean} mm)"
    assert said["start"] == {"diameter": pytest.approx(0.01), "slider": True, "text": ""}
    chosen = said["chosen"]
    assert chosen["diameter"] == pytest.approx(TWICE.mean_diameter_mm / 1e3) and not chosen["slider"]
    assert chosen["axis"] == chosen["shown"] == "fill_ratio" and chosen["outside"] == ""
    assert chosen["text"].startswith(TWICE.in_words(chosen["balls"]) + ".")
    assert "between two of them nothing is calculated" in chosen["text"]
    assert said["back"] == pytest.approx(0.01) and said["again"]
    # A mill without measured yields has the four charts of its dissipation.
    assert said["charts"] == 6 and not said["yields"]


@needs_browser
def test_temperatures_are_of_the_simulated_charge(mills, page):
    own = mills["both"]["fingerprint"]
    page.open(mills["both"]["page"])
    said = page.run("""
      explorer.take("twice"); Object.assign(explorer.state, { fill_ratio: 0.1, speed_hz: 14 }); explorer.render();
      const { near, factor } = explorer.heat.shown();
      const powers = explorer.heat.conditions.map((each) => [each.charge, each.words, explorer.heat.powerOf(each)]);
      return { near: near.charge, factor, powers };""")
    expected = []
    for charge in ("three", "twice", ""):
        diameter = own.charge_diameter_m(charge) if charge else 0.01
        condition = own.condition(speed_hz=15.0, ball_diameter_m=diameter, fill_ratio=0.12)
        expected.append(own.predict(condition, charge=charge).wall_power_W.value)
    assert [power for *_, power in said["powers"]] == pytest.approx(expected, rel=1e-6)
    assert [charge for charge, *_ in said["powers"]] == ["three", "twice", ""]
    assert all(charge in words for charge, words, _ in said["powers"])
    here = own.condition(speed_hz=14.0, ball_diameter_m=own.charge_diameter_m("twice"), fill_ratio=0.1)
    assert said["near"] == "twice"
    assert said["factor"] == pytest.approx(own.predict(here, charge="twice").wall_power_W.value / expected[1], rel=1e-6)


@needs_browser
def test_the_search_of_the_page_finds_the_charges_that_the_library_finds(mills, page):
    own = mills["both"]["fingerprint"]
    condition = own.condition(speed_hz=13.0, ball_diameter_m=own.charge_diameter_m("twice"), fill_ratio=0.12)
    found = own.predict(condition, charge="twice")
    target = {name: getattr(found, name).value for name in DESCRIPTOR_SETS["weighted"]}
    table = rank_conditions(target, [own], simulated_request(own, "weighted"))
    page.open(mills["both"]["page"])
    ours = page.run(f"""const rows = await explorer.mill.search({target!r});
      return rows.map(({{ condition, distance }}) =>
        [condition.charge, distance, condition.fill_ratio, condition.speed_hz * 60]);
    """)
    assert [row[0] for row in ours] == table["charge"].tolist() and ours[0][0] == "twice"
    theirs = table[["distance", "fill_ratio", "speed_rpm"]].to_numpy(float)
    np.testing.assert_allclose([row[1:] for row in ours[1:]], theirs[1:], rtol=2e-3, atol=1e-6)
    used = page.run("""
      document.querySelector("#media input[value=twice]").dispatchEvent(new Event("change"));
      document.getElementById("take").click(); explorer.take(""); await explorer.finder.show();
      const row = document.querySelector("#found tbody tr"); row.querySelector("button").click();
      return { cells: [...row.querySelectorAll("td")].map((e) => e.textContent), charge: explorer.state.charge };""")
    assert used["cells"][0] == "twice" and used["charge"] == "twice"
