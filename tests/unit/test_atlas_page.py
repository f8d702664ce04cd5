"""The page from a paper to one's own mill, in a browser: the numbers of Python, refusals, pictures, for everyone."""

import json
from math import exp

import numpy as np
import pytest

from millprint.atlas.estimate_mill import check, estimate
from millprint.atlas.kind_groups import CONTACT, SETTINGS, Kind
from millprint.atlas.kinds import KINDS
from millprint.atlas.page.atlas_page import Name, atlas_content, atlas_page
from millprint.config.errors import ConfigError
from millprint.estimate.estimates import Estimate, Interval, ratio_of
from millprint.fingerprint.condition_search import verdict_on
from millprint.run.files import read_json
from tests.browser import DESKTOP, PHONE, needs_browser
from tests.conftest import ROOT
from tests.refusals import refusals
from tests.unit.made_atlas import made_atlas, made_errors

MAKERS, TURNS = ROOT / "config/atlas/makers.tsv", ROOT / "docs/turns.json"
CONDITIONS = 60


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "mills.html"
    path.write_text(atlas_page(atlas_content(made_atlas(), made_errors(), read_json(TURNS), MAKERS, list(KINDS))))
    return path


@pytest.fixture
def page(built, browser):
    with browser.page() as page:
        page.open(built)
        page.run("await atlas.drawn; await atlas.searched;")
        yield page
        assert page.errors == [] and not page.outside_requests()


def _random_conditions(kind: Kind, count: int, beyond: float = 0.0) -> list[dict[str, float]]:
    """Conditions of mills of any size; beyond: how far out of their ranges groups may be."""
    draw = np.random.default_rng(5)
    found = []
    for _ in range(count):
        shares = draw.uniform(-beyond, 1 + beyond, len(kind.groups))
        groups = {group.name: group.at(share) for group, share in zip(kind.groups, shares, strict=True)}
        # Restitution and rounding stay what they can be.
        groups |= {name: max(groups[name], 0.0) for name in groups if name == "rounding"}
        condition = kind.condition_of(groups)
        size, density = draw.uniform(0.3, 3.0), draw.uniform(2000, 15000)
        lengths = {name: size * value for name, value in condition.items() if name.endswith("_mm")}
        slower = {"speed_hz": condition["speed_hz"] / np.sqrt(size), "density_kg_m3": density}
        found.append({name: float(value) for name, value in (condition | lengths | slower).items()})
    return found


@needs_browser
@pytest.mark.parametrize("name", KINDS)
def test_the_page_and_python_give_the_same_numbers(page, name):
    kind, model = KINDS[name], made_atlas()[name]
    conditions, expected, unsure = [], [], []
    for condition in _random_conditions(kind, CONDITIONS):
        try:
            found = estimate(kind, condition, model)
        except ConfigError:
            continue
        conditions.append(condition)
        values = [[own.value, own.lower, own.upper] for own in found.known.values()]
        unsure.append(list(found.unsure))
        expected.append([found.hits, *np.ravel(values), *kind.groups_of(condition).values()])
    assert len(conditions) > CONDITIONS / 2
    said = page.run(f"""
      const kind = atlas.kinds[{name!r}];
      return {json.dumps(conditions)}.map((own) => {{
        const {{ known, hits, unsure }} = kind.estimate(own);
        const ends = Object.values(known).flatMap(({{ value, lower, upper }}) => [value, lower, upper]);
        return [unsure, [hits, ...ends, ...kind.ranges.map((group) => kind.groups(own)[group.name])]]; }});""")
    # The file of an atlas has seven digits.
    np.testing.assert_allclose([numbers for _, numbers in said], expected, rtol=1e-6)
    assert [names for names, _ in said] == unsure and any(unsure)


@needs_browser
def test_the_page_asks_for_a_simulation_where_more_than_the_mark_is_to_be_expected(page):
    wide, narrow = page.run("""
      const told = (mark) => {
        for (const name of Object.keys(CONTENT.marks)) CONTENT.marks[name] = mark;
        atlas.render();
        return document.getElementById("unsure").textContent;
      };
      return [told(0), told(10)];""")
    assert narrow == "" and wide.count("simulate it, with millprint card") == 2
    assert "Your mill is told worse than the atlas is meant to in power" in wide


@needs_browser
@pytest.mark.parametrize("name", KINDS)
def test_the_page_refuses_what_python_refuses(page, name):
    kind = KINDS[name]
    conditions = _random_conditions(kind, 8 * CONDITIONS, beyond=0.02)

    def refused(condition: dict[str, float]) -> bool:
        try:
            check(kind, condition)
        except ConfigError:
            return True
        return False

    expected = [refused(condition) for condition in conditions]
    assert 0.1 < np.mean(expected) < 0.9
    said = page.run(f"return {json.dumps(conditions)}.map((own) => atlas.kinds[{name!r}].fault(own)?.text ?? null);")
    assert [text is not None for text in said] == expected
    assert all(text is None or ("\n" not in text and "NaN" not in text and "undefined" not in text) for text in said)


@needs_browser
def test_the_page_and_a_match_give_one_verdict(page):
    draw = np.random.default_rng(2)
    logs = np.stack([draw.normal(0, 0.3, (200, 2)), *np.abs(draw.normal(0, 0.2, (2, 200, 2)))], axis=-1)
    pairs = [
        [{"value": exp(value), "lower": exp(value - low), "upper": exp(value + high)} for value, low, high in pair]
        for pair in logs.tolist()
    ]
    made = [[Estimate(own["value"], "J", mean=Interval(own["lower"], own["upper"])) for own in pair] for pair in pairs]
    expected = [verdict_on(ratio_of(*pair), 30).word for pair in made]
    verdict = "verdictOn({ interval: ratioWith(...pair) }, CONTENT.near_percent)"
    said = page.run(f"return {json.dumps(pairs)}.map((pair) => {verdict});")
    assert said == expected and set(said) == {"agrees", "differs", "open"}


@needs_browser
@pytest.mark.parametrize(("field", "text", "line"), refusals("bad_input_at_its_field"))
def test_bad_input_is_told_in_a_line_at_its_field(page, field, text, line):
    said = page.run(f"""
      const planetary = CONTENT.mills.findIndex((mill) => mill.kind === "planetary");
      atlas.sides[1].choose(String(planetary)); atlas.render();
      const own = atlas.sides[1].fields[{field!r}].input;
      const before = document.getElementById("verdict").textContent;
      own.value = {text!r}; own.dispatchEvent(new Event("change", {{ bubbles: true }}));
      return {{ line: document.getElementById("own-fault").textContent, invalid: own.getAttribute("aria-invalid"),
        five: document.querySelectorAll("#five td:last-child .number").length, before,
        verdict: document.getElementById("verdict").textContent }};""")
    assert said["line"] == line and said["invalid"] == "true" and said["five"] == 0
    assert said["verdict"] == "Nothing to compare: your settings have a fault."
    assert not said["before"].startswith("Nothing")


@needs_browser
def test_the_same_mill_on_both_sides_agrees_and_is_its_own_nearest(page):
    said = page.run("""
      const any = CONTENT.mills.findIndex((mill) => mill.kind === "planetary");
      for (const side of atlas.sides) { side.choose(String(any)); }
      atlas.render(); await atlas.searched;
      const hours = document.getElementById("time").textContent;
      const [first] = atlas.found;
      document.getElementById("take").click();
      return { words: document.getElementById("verdict").className, hours, far: first.distance,
        asked: atlas.conditions[0], found: first.condition, taken: atlas.conditions[1] };""")
    assert said["words"] == "agrees" and "2.00 h in the paper's mill are 2.00 h in yours" in said["hours"]
    # Whole numbers of balls and turns per minute keep it from the very same.
    assert said["far"] < 1e-3
    for name in ("ball_diameter_mm", "number", "speed_hz"):
        assert said["taken"][name] == pytest.approx(said["found"][name], rel=1e-5)


@needs_browser
@pytest.mark.parametrize(("name", "fastest"), [("mixer", "25.25"), ("planetary", "416.7")])
def test_settings_that_are_proposed_are_no_faster_than_the_machine(page, name, fastest):
    fault, speeds, focus = page.run(f"""
      const any = CONTENT.mills.findIndex((mill) => mill.kind === {name!r});
      for (const side of atlas.sides) side.choose(String(any));
      // What the paper does is beyond the own machine.
      const {{ fields }} = atlas.sides[1];
      fields.fastest_hz.input.value = {fastest!r}; fields.speed_hz.input.value = {fastest!r};
      atlas.render(); await atlas.searched;
      const speeds = atlas.found.map((own) => own.condition.speed_hz * atlas.sides[1].kind.perHertz);
      const button = document.getElementById("take");
      button.focus(); button.click();
      return [document.getElementById("own-fault").textContent, speeds, document.activeElement.id];""")
    assert fault == "" and 0.95 * float(fastest) < max(speeds) <= float(fastest)
    # The keyboard is not lost with the button.
    assert focus == "verdict-title"


@needs_browser
def test_a_machine_of_one_speed_is_proposed_at_that_speed_until_its_owner_says_another(page):
    only, others = page.run("""
      const spex = CONTENT.mills.findIndex((mill) => mill.kind === "spex" && mill.slowest_hz);
      for (const side of atlas.sides) side.choose(String(spex));
      const speeds = async () => { atlas.render(); await atlas.searched;
        return atlas.found.map((own) => own.condition.speed_hz); };
      // The paper's mill runs at half of its speed.
      atlas.sides[0].fields.speed_hz.input.value = "9";
      const only = await speeds();
      const { fields } = atlas.sides[1];
      fields.fastest_hz.input.value = "17"; fields.speed_hz.input.value = "10";
      return [only, await speeds()];""")
    assert only and set(only) == {17.5}
    assert others and min(others) < 16


@needs_browser
def test_nothing_of_another_mill_stays_where_a_search_finds_nothing(page):
    before, after = page.run("""
      const rows = () => ["#others tbody tr", "#best-reasons li"].map((own) => document.querySelectorAll(own).length);
      const before = rows();
      CONTENT.sold_mm.length = 0; atlas.render(); await atlas.searched;
      return [before, rows()];""")
    assert min(before) > 0 and after == [0, 0]


@needs_browser
def test_a_fault_of_the_contact_is_told_as_one_of_the_contact(page):
    said = page.run("""
      const input = document.getElementById("contact-restitution"), good = input.value;
      const set = (text) => { input.value = text; input.dispatchEvent(new Event("change", { bubbles: true }));
        return { verdict: document.getElementById("verdict").textContent, open: document.getElementById("contact").open,
          invalid: input.getAttribute("aria-invalid") }; };
      document.getElementById("contact").open = false;
      return [set("two"), set(good)];""")
    assert said[0]["open"] and said[0]["invalid"] == "true" and said[1]["invalid"] is None
    assert "contact" in said[0]["verdict"] and not said[1]["verdict"].startswith("Nothing to compare")


@needs_browser
def test_a_slow_drum_that_is_shown_fast_is_told_so(page):
    told = page.run("""
      const shown = (own) => { Object.defineProperty(atlas.film, "slower", { value: own, configurable: true });
        atlas.film.tell(); return document.getElementById("legend").textContent; };
      await atlas.drawn;
      return [4, 0.25, 1].map(shown);""")
    assert "4 times slower than" in told[0] and "4 times faster than" in told[1] and "as fast as" in told[2]


@needs_browser
def test_intervals_that_have_not_held_decide_nothing(page):
    held, verdict, reasons = page.run("""
      const kinds = Object.values(CONTENT.errors), held = kinds.flatMap((own) => Object.values(own.held));
      for (const own of kinds) for (const name of Object.keys(own.held)) own.held[name] = 0.6;
      atlas.render();
      return [held, document.getElementById("verdict").className, document.getElementById("reasons").textContent];""")
    assert held == [0.9] * len(held) and verdict == "open"
    assert reasons.count("intervals of the kind planetary mill held only 60 % of 100 mills kept apart") == 3


@needs_browser
@pytest.mark.parametrize("name", KINDS)
def test_recorded_balls_stay_in_their_jar_and_move(page, name):
    said = page.run(f"""
      const kind = atlas.kinds[{name!r}];
      const recorded = CONTENT.turns.kinds[{name!r}];
      const found = [];
      for (const run of recorded.runs) {{
        const {{ right, up, speed }} = await unpacked(run, CONTENT.turns.per_radius);
        const ball = run.condition.ball_diameter_mm / run.condition.radius_mm / 2;
        const half = run.condition.height_mm / run.condition.radius_mm / 2;
        let out = 0;
        right.forEach((x, i) => {{
          const [cx, cy, angle] = run.poses[i % run.frames];
          const [dx, dy] = [x - cx, up[i] - cy];
          const along = Math.abs(dx * Math.cos(angle) + dy * Math.sin(angle));
          const across = Math.abs(dy * Math.cos(angle) - dx * Math.sin(angle));
          const beyond = Math.max(along + ball - half, across + ball - 1);
          out = Math.max(out, recorded.outline === "round" ? Math.hypot(dx, dy) + ball - 1 : beyond);
        }});
        found.push({{ out, same: nearestRun(kind, recorded, run.condition) === run, moves: Math.max(...speed) }});
      }}
      return found;""")
    assert len(said) == 10
    for run in said:
        # A ball presses a little into a wall that is softer than steel.
        assert run["out"] < 0.02 and run["same"] and run["moves"] == 255


@needs_browser
def test_a_button_stops_the_balls_and_starts_them(page):
    said = page.run("""
      const button = document.getElementById("play");
      const picture = () => document.getElementById("own-balls").toDataURL();
      const wait = () => new Promise((done) => setTimeout(done, 400));
      const found = { plays: atlas.film.plays };
      let before = picture(); await wait(); found.moved = picture() !== before;
      button.click(); before = picture(); await wait();
      return { ...found, stopped: picture() === before, word: button.textContent };""")
    assert said == {"plays": True, "moved": True, "stopped": True, "word": "Let the balls move"}


@needs_browser
def test_balls_stand_still_for_people_who_have_asked_for_less_motion(built, browser):
    with browser.page() as page:
        page.reduce_motion()
        page.open(built)
        said = page.run("""
          await atlas.drawn;
          const canvas = document.getElementById("own-balls");
          const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
          const drawn = data.some((byte) => byte);
          return { drawn, plays: atlas.film.plays, word: document.getElementById("play").textContent };""")
        assert said == {"drawn": True, "plays": False, "word": "Let the balls move"}


@pytest.mark.slow
@needs_browser
@pytest.mark.parametrize("width", [DESKTOP, PHONE])
def test_everyone_can_use_the_page(page, width):
    page.resize(width, 900)
    page.run("for (const each of document.querySelectorAll('details')) each.open = true;")
    assert page.accessibility_faults() == []
    measured = page.measure()
    assert measured["beyond"] <= 0 and measured["smallest"] >= 11
    wanted = page.run("""
      return [...document.querySelectorAll("summary, button, select, input, [tabindex='0']")]
        .filter((e) => e.checkVisibility() && !e.disabled).length;""")
    focused = """
      const own = document.activeElement; const style = getComputedStyle(own); const box = own.getBoundingClientRect();
      return style.outlineStyle !== "none" && box.left >= -1 && box.right <= innerWidth + 1
        ? own.id || own.textContent : "";"""
    seen = []
    for _ in range(wanted):
        page.press("Tab")
        seen.append(page.run(focused))
    assert all(seen) and "take" in seen and "play" in seen and "own-ball_diameter_mm" in seen


def test_a_formula_that_has_no_javascript_is_told():
    with pytest.raises(TypeError, match=r"numpy\.arctan: add its name in JavaScript"):
        np.arctan(Name("x"))
    assert (2 * np.log(1 - Name("x")) ** 2).text == "(2.0 * Math.pow(Math.log((1.0 - x)), 2.0))"


def test_every_group_of_the_contact_is_a_setting():
    """So that a picture is chosen by what shows."""
    assert {group.name for group in CONTACT} <= {own.name for own in SETTINGS}
