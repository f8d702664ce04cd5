"""The explorer's spectra, temperatures, doses and units, against the tables and the library, at two widths."""

import json

import numpy as np
import pytest

from millprint.config.errors import ConfigError
from millprint.dose.kinetics import DOSE_OF, HITS, doses_of
from millprint.explorer import content as tables_of_page
from millprint.explorer.content import Spectra, spectra_content
from millprint.observables.counted_collisions import CHANNELS, PAIRS
from millprint.run.files import read_table
from millprint.run.numbers import three
from tests.browser import DESKTOP, PHONE, needs_browser
from tests.conftest import ROOT
from tests.unit.explorer_pages import ACCELERATION, CONDITIONS, HEAT

SETTING = {"speed_hz": 12.5, "fill_ratio": 0.09, "ball_diameter_m": 0.01, "density_kg_m3": 7700.0}
# A condition and powder whose dose is compared with the library's.
POWDER = {"bpr": 17.0, "time_h": 3.5}
NEXT_FRAME = "await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));"


@pytest.fixture(scope="module")
def pages(built, browser):
    """The page at both widths, by width."""
    with browser.page(DESKTOP) as wide, browser.page(PHONE) as narrow:
        found = {DESKTOP: wide, PHONE: narrow}
        for page in found.values():
            page.open(built["page"])
        yield found
        for page in found.values():
            assert page.errors == []


@needs_browser
@pytest.mark.parametrize("mill", ["emax", "planetary"])
def test_descriptors_and_doses_are_those_of_the_library(built, pages, mill):
    own = built["fingerprints"][mill]
    found = own.predict(own.condition(**{name: SETTING[name] for name in list(SETTING)[:3]}))
    mass = found.balls * 7700.0 * np.pi / 6 * 0.01**3 * 1e3 / POWDER["bpr"]
    told = doses_of(found, found.balls, POWDER["time_h"], mass)
    theirs = {name: own.value for name, own in told.items()}
    ours = pages[DESKTOP].run(f"""
      explorer.useMill(explorer.mills.find((mill) => mill.name === {mill!r}));
      Object.assign(explorer.state, {SETTING | POWDER!r});
      const found = explorer.answer(explorer.state);
      const {{ value, lower, upper }} = found.wall_power_W, names = ["normal_", "tangential_", "rolling_", ""];
      return {{ powder: found.powder_g, power: [value, lower, upper],
        doses: names.map((name) => found[`${{name}}dose_J_kg`].value * 1e-6),
        hits: found.hits_per_g.value }};""")
    assert ours["powder"] == pytest.approx(mass, rel=1e-6)
    np.testing.assert_allclose(ours["doses"], [theirs[name] for name in DOSE_OF], rtol=1e-6)
    assert ours["hits"] == pytest.approx(theirs[HITS], rel=1e-6)
    power = found.wall_power_W
    np.testing.assert_allclose(ours["power"], [power.value, power.lower, power.upper], rtol=1e-6)


@needs_browser
def test_spectra_and_their_shares_are_those_of_the_table(built, pages):
    text = ["mill", "contact", "varied", "charge", "counting_rule", "channel", "pair"]
    table = read_table(built["folder"] / "spectra.tsv", text=text)
    ours = pages[DESKTOP].run("""
      const { edges, conditions } = explorer.mills[0].content.spectra;
      const spectra = conditions.flatMap((each) => Object.keys(CHANNELS).flatMap((channel) =>
        ["ball_ball", "ball_wall"].map((pair) => [each, each.bins[channel][pair]])));
      return spectra.flatMap(([each, own]) => {
        const of = (quantity, share) => spectrumSteps(own, quantity, edges, share).map((step) => step.value);
        const bins = spectrumSteps(own, "power_W", edges, false);
        const shares = [of("collisions_hz", true), of("power_W", true)];
        return bins.map(({ low, high, value }, i) => [each.fill_ratio, each.speed_hz * 60, low, high,
          of("collisions_hz", false)[i], value, shares[0][i], shares[1][i]]);
      });""")
    names = ["fill_ratio", "speed_rpm", "energy_low_J", "energy_high_J", "collisions_hz", "power_W"]
    names += ["collisions_above_share", "power_above_share"]
    assert len(CONDITIONS) * len(CHANNELS) * len(PAIRS) * 10 < len(ours) == len(table)
    order = ["fill_ratio", "speed_rpm", "channel", "pair"]
    theirs = table.sort_values(order, kind="stable")[names].to_numpy(float)
    np.testing.assert_allclose(ours, theirs, rtol=1e-6, atol=1e-12)


@needs_browser
def test_the_panel_of_temperatures_is_at_the_power_of_the_settings(built, pages):
    table = read_table(built["folder"] / "planetary_temperatures.tsv", text=["condition", "body"])
    limits = read_table(built["folder"] / "planetary_limits.tsv", text=["condition", "contact", "limit_body"])
    said = pages[DESKTOP].run(f"""
      explorer.useMill(explorer.mills[1]); Object.assign(explorer.state, {{ fill_ratio: 0.11, speed_hz: 18 }});
      explorer.render(); {NEXT_FRAME}
      const found = explorer.heat.shown(), power = (state) => explorer.answer(state).wall_power_W.value;
      const {{ fill_ratio, speed_hz, ball_diameter_m }} = found.near;
      const factor = power(explorer.state) / power({{ ...explorer.state, fill_ratio, speed_hz, ball_diameter_m }});
      return {{ factor, used: found.factor, id: found.id, courses: found.courses,
        text: document.getElementById("heat-said").textContent,
        lines: document.querySelectorAll("#heat-chart path.line").length,
        bands: document.querySelectorAll("#heat-chart path.band").length,
        hidden: document.getElementById("spectra").hidden }};""")
    assert said["id"] == "d10_f0.12_n1200" and (said["lines"], said["bands"]) == (3, 3)
    assert said["used"] == pytest.approx(said["factor"]) and 0.5 < said["factor"] < 1
    for body, course in said["courses"].items():
        own = table[(table["condition"] == said["id"]) & (table["body"] == body)]
        for end, values in course.items():
            start = own[f"{end}_degC"].iloc[0]
            expected = start + said["factor"] * (own[f"{end}_degC"] - start)
            np.testing.assert_allclose(values, expected, atol=0.006)
    row = limits.set_index("condition").loc[said["id"]]
    assert f"reaches {HEAT.limit.temperature_degC:g} °C without a pause" in said["text"]
    assert row["total_W"] == pytest.approx(240)
    assert said["text"].startswith(f"{240 * said['factor']:.3g} W, rolling included, with no pauses")
    assert "fill 0.12, 1200 rpm, 240 W, times 0." in said["text"]
    # A mill without spectra shows no empty panel of them.
    assert said["hidden"]


# Of a unit, the kind, the row of the results that it is of, and how many of it the first unit of its kind is.
UNITS = {
    "µJ": ("energy", 0, 1e-3), "mJ": ("energy", 0, 1e-6), "J": ("energy", 0, 1e-9),
    "1/s": ("frequency", 2, 1), "1/min": ("frequency", 2, 60),
    "kJ/g": ("dose", -1, 1), "J/g": ("dose", -1, 1e3), "kWh/t": ("dose", -1, 1e3 / 3.6),
}  # fmt: skip


SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


def number(text: str) -> float:
    """A number of the page, also one in powers of ten."""
    return float(text.replace("·10", "e").translate(SUPERSCRIPTS))


@needs_browser
def test_units_change_what_is_shown_and_not_the_state(pages):
    said = pages[DESKTOP].run(f"""
      const set = (id, value) => {{ const choice = document.getElementById(id);
        choice.value = value; choice.dispatchEvent(new Event("change")); }};
      explorer.useMill(explorer.mills[0]); explorer.state.speed_hz = 15; explorer.render();
      const rows = () => [...document.querySelectorAll("#results div")];
      const dose = () => rows().find((e) => e.textContent.startsWith("Specific energy"));
      const before = JSON.stringify(explorer.state), shown = {{}}, speeds = {{}};
      for (const [unit, [kind, row]] of Object.entries({json.dumps(UNITS)}).reverse()) {{
        set(`unit-${{kind}}`, unit);
        shown[unit] = (row < 0 ? dose() : rows()[row]).querySelector("dd").textContent; }}
      for (const unit of ["Hz", "rpm", "g"]) {{
        set("unit-speed", unit);
        speeds[unit] = [document.getElementById("speed_hz-field").value,
          document.getElementById("speed_hz").getAttribute("aria-valuetext")]; }}
      const same = JSON.stringify(explorer.state) === before;
      set("speed_hz-field", "10"); const given = explorer.state.speed_hz;
      explorer.state.speed_hz = 15; set("unit-speed", "rpm");
      return {{ shown, speeds, same, set: given }};""")
    shown = {unit: number(text.split()[0]) for unit, text in said["shown"].items()}
    first = {kind: shown[unit] for unit, (kind, *_) in reversed(UNITS.items())}
    for unit, (kind, _, factor) in UNITS.items():
        start = next(own[2] for own in UNITS.values() if own[0] == kind)
        assert said["shown"][unit].endswith(unit)
        assert shown[unit] == pytest.approx(first[kind] * factor / start, rel=0.01)
    assert said["speeds"]["Hz"] == ["15", "15 Hz"] and said["speeds"]["rpm"] == ["900", "900 rpm"]
    assert float(said["speeds"]["g"][0]) == pytest.approx(ACCELERATION["emax"] * 15**2, rel=1e-5)
    assert said["set"] == pytest.approx((10 / ACCELERATION["emax"]) ** 0.5, rel=1e-9) and said["same"]


@needs_browser
def test_conditions_of_another_mill_have_the_units_of_that_mill(pages):
    words, option = pages[DESKTOP].run(f"""
      explorer.useMill(explorer.mills[1]); explorer.chosenUnits.speed = "g";
      explorer.spectra.chosen[0] = "emax/calibrated-d10-f0.06-n600"; explorer.render(); {NEXT_FRAME}
      const told = [document.querySelector("#spectra-key li").textContent,
        document.getElementById("spectra-0").selectedOptions[0].textContent];
      explorer.chosenUnits = {{}}; explorer.spectra.chosen[0] = ""; explorer.render();
      return told;""")
    assert words.endswith(option)
    assert float(option.split()[-2]) == pytest.approx(ACCELERATION["emax"] * 10**2, rel=1e-3)


@needs_browser
def test_numbers_of_the_page_are_rounded_before_their_form_is_chosen(pages):
    numbers = [999.4, 999.5, 999.6, 9994.0, 0.9996, 99.96, 123.4, 0.00123]
    ours = pages[DESKTOP].run(f"return [...{numbers!r}, 0].map((own) => digits(own)).concat(digits(99.7, 2));")
    assert ours == [*map(three, numbers), "0.00", "100"]
    assert pages[DESKTOP].run("return [digits(9996), digits(9.996e-4)];") == ["1.00·10⁴", "0.00100"]


@needs_browser
def test_the_methods_text_and_the_advice_follow_the_state(pages):
    said = pages[DESKTOP].run("""
      const read = () => ({ text: document.getElementById("methods").textContent,
        use: document.getElementById("use-for").innerText, avoid: document.getElementById("avoid-for").innerText });
      explorer.useMill(explorer.mills[0]);
      Object.assign(explorer.state, { speed_hz: 15, fill_ratio: 0.1, ball_diameter_m: 0.01, bpr: 20 });
      explorer.render(); const inside = read();
      explorer.state.speed_hz = 24; explorer.render(); const outside = read();
      getSelection().removeAllRanges(); document.getElementById("copy").click();
      await new Promise((done) => setTimeout(done, 300));
      return { inside, outside, copied: document.getElementById("copied").textContent,
        power: explorer.answer({ ...explorer.state, speed_hz: 15 }).wall_power_W.value,
        contact: explorer.fingerprint.about.contact };""")
    text = said["inside"]["text"]
    power = f"{said['power']:#.3g}".rstrip(".")
    for words in ("900 rpm", "balls of 10 mm", "fill 10 %", power, said["contact"], "mass ratio 20", "SHA-256", "95 %"):
        assert words in text, words
    assert "Outside the simulated range" not in text and "nan" not in text.lower() and "undefined" not in text
    assert "These settings" in said["inside"]["use"] and "These settings" not in said["inside"]["avoid"]
    assert "Outside the simulated range: speed." in said["outside"]["text"]
    assert "speed was not simulated here" in said["outside"]["avoid"]
    assert "These settings" not in said["outside"]["use"]
    assert said["copied"] in ("Copied.", "Selected: copy it with the keyboard.")


def test_a_table_with_other_bins_is_refused_in_one_line(built, monkeypatch):
    tables = [(built["folder"] / "spectra.tsv", built["folder"] / "spectra_summary.tsv")]
    monkeypatch.setattr(tables_of_page, "BIN_EDGES", np.geomspace(1e-12, 10.0, 92))
    with pytest.raises(ConfigError, match="its bins are not those of this version"):
        spectra_content(Spectra(tables, "lifetimes"))


# Text of a chart beyond it or over another, four digits or an exponent along an axis of numbers, a value longer than
# its field, and what is beyond the page outside a part that scrolls.
CUT = """
  const found = [], width = (e, text) => {
    const pen = document.createElement("canvas").getContext("2d");
    pen.font = getComputedStyle(e).font;
    return pen.measureText(text).width; };
  for (const e of document.querySelectorAll("svg text")) {
    const text = e.getBoundingClientRect(), svg = e.closest("svg").getBoundingClientRect();
    if (text.right > svg.right + 0.5 || text.left < svg.left - 0.5) found.push(e.textContent); }
  for (const svg of document.querySelectorAll("svg")) {
    const labels = [...svg.querySelectorAll("text")].map((e) => [e.textContent, e.getBoundingClientRect()]);
    for (const [i, [text, one]] of labels.entries())
      for (const [other, two] of labels.slice(i + 1))
        if (Math.min(one.right, two.right) - Math.max(one.left, two.left) > 1
          && Math.min(one.bottom, two.bottom) - Math.max(one.top, two.top) > 3) found.push(`${text} over ${other}`); }
  for (const e of document.querySelectorAll('svg text[text-anchor="end"]:not(.axis)'))
    if (/^\\d+(\\.\\d+)?(e|$)/.test(e.textContent) && /e|\\d{4}/.test(e.textContent)) found.push(e.textContent);
  for (const e of document.querySelectorAll('input[type="number"]'))
    if (e.clientWidth && width(e, e.value) + 10 > e.clientWidth) found.push(`${e.id} ${e.value}`);
  for (const e of document.querySelectorAll("p, dt, dd, h2, label, button, #spectra-table td"))
    if (e.getBoundingClientRect().right > innerWidth + 1) found.push(e.textContent);
  return found;"""


@needs_browser
@pytest.mark.parametrize("width", [DESKTOP, PHONE])
def test_nothing_is_cut(pages, width):
    for mill in (0, 1):
        cut = pages[width].run(f"explorer.useMill(explorer.mills[{mill}]); explorer.render(); {NEXT_FRAME} {CUT}")
        assert cut == []


@needs_browser
@pytest.mark.parametrize("width", [DESKTOP, PHONE])
def test_nothing_is_cut_in_any_unit(browser, width):
    """Of the included mills: some hit with some 40 uJ, which a reader may want in J."""
    with browser.page(width) as page:
        page.open(ROOT / "docs/fingerprints.html")
        cut = page.run(f"""
          const cut = () => {{ {CUT} }}, told = [];
          await explorer.finder.show();
          for (const mill of explorer.mills) {{
            explorer.useMill(mill);
            document.getElementById("take").click();
            for (let choice = 0; choice < 4; choice += 1) {{
              for (const kind of Object.keys(UNITS)) {{
                const names = explorer.units.names(kind), field = document.getElementById(`unit-${{kind}}`);
                field.value = names[choice % names.length];
                field.dispatchEvent(new Event("change")); }}
              {NEXT_FRAME}
              told.push(...cut().map((each) => `${{mill.name}}: ${{each}}`)); }} }}
          return told;""")
        assert cut == [] and page.errors == []
