"""The explorer in a browser: the same numbers as the library, no requests, readable on a phone."""

import re
from typing import ClassVar

import numpy as np
import pandas as pd
import pytest

from millprint.api import read_fingerprint
from millprint.config.fingerprint import InverseConfig, SearchConfig
from millprint.config.yields import AveragingConfig, PredictionConfig
from millprint.estimate.estimates import columns_of
from millprint.explorer.content import Machine, explorer_content, explorer_page, mill_content, sliders
from millprint.fingerprint import processes
from millprint.fingerprint.bands import checked_factors
from millprint.fingerprint.condition_search import rank_conditions, target_at
from millprint.fingerprint.descriptors import tabulate_descriptors
from millprint.fingerprint.match_words import best_of, match_in_words
from millprint.fingerprint.model import Fingerprint
from millprint.observables.definitions import TARGET_DESCRIPTORS
from millprint.thesis.doe.factorial_designs import YIELD
from millprint.thesis.yields.averaging import fit_averaged
from millprint.thesis.yields.new_conditions import explorer_yields, range_warnings, trained_ranges
from millprint.thesis.yields.stored_models import load_averaged, save_averaged, training_rows
from tests.browser import DESKTOP, PHONE, needs_browser
from tests.conftest import ROOT, configuration
from tests.unit.factor_samples import factors_of
from tests.unit.synthetic_mill import DENSITY, FILLS, VOLUME, overrides, still, summary
from tests.unit.yield_settings import all_runs, thesis_yields

CONTACTS = ("calibrated", "steel")
CHEMICAL = ("bpr", "molar_ratio", "time_h")
BANDS = (
    *(*TARGET_DESCRIPTORS, "strong_frequency_hz", "normal_power_W", "tangential_power_W"),
    *("wall_power_W", "tangential_share"),
)
LEVEL = 0.95


class AllWeights(AveragingConfig):
    """Keeps the processes of every link and structure, however small their weights."""

    smallest_weight: ClassVar[float] = 1e-9


def _fingerprint(contact: str, seed: int) -> Fingerprint:
    """A mill that departs from the scaling, so that every part of the model has something to say."""
    generator = np.random.default_rng(seed)
    runs = [
        summary(fill, diameter, speed, contact, noise=0.05 * generator.standard_normal() + 0.1 * (diameter > 5))
        for fill in FILLS[1:-2:2]
        for diameter in (5.0, 10.0)
        for speed in (600.0, 1200.0)
    ]
    # Few balls of the second contact set go round as one layer at one speed.
    layer = [still(FILLS[0], 5.0, 600.0, contact)] if contact == CONTACTS[1] else []
    return Fingerprint.fit(tabulate_descriptors(runs + layer + overrides(contact=contact), "gap_0_03"), VOLUME, 0.95)


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> dict:
    """Two fingerprints, a yield model with every link and kind of structure, and the page of both."""
    folder = tmp_path_factory.mktemp("explorer")
    paths = [folder / f"fingerprint_{contact}.json" for contact in CONTACTS]
    for seed, (contact, path) in enumerate(zip(CONTACTS, paths, strict=True)):
        own = _fingerprint(contact, seed)
        # One of the two was analysed, at fewer fill ratios than were simulated.
        analysed = (
            {"contact": checked_factors(factors_of(), "contact", own.about, "x")} if contact == CONTACTS[0] else {}
        )
        own.with_further(analysed).write(path)
    section = thesis_yields()
    settings = AllWeights(
        **section["averaging"]
        | {
            "structures": ["trend_product"],
            "scales": {name: scales[-1:] for name, scales in section["averaging"]["scales"].items()},
        }
    )
    rows = all_runs()
    model = fit_averaged(rows, rows[YIELD].to_numpy(float), settings)
    save_averaged(model, rows, settings.margin, str(folder / "yield.json"))
    request = InverseConfig(**configuration()["fingerprint"]["inverse"])
    request = request.model_copy(update={"ball_diameters_mm": [5.0, 10.0]})
    prediction = PredictionConfig(**section["prediction"])
    yields = explorer_yields(folder / "yield.json", prediction, LEVEL)
    machine = Machine("emax", "A mill <of> ours", "the jar moves", 0.07)
    content = explorer_content("test", [mill_content(machine, paths, request, yields)])
    page = folder / "explorer.html"
    page.write_text(explorer_page(content))
    return {
        "page": page,
        "folder": folder,
        "content": content,
        "fingerprints": [Fingerprint.read(path) for path in paths],
        "yield": folder / "yield.json",
        "prediction": prediction,
        "request": request,
    }


def _states(content: dict, count: int) -> list[dict]:
    """Conditions at random, half over all that the sliders can reach and half over what was simulated."""
    generator = np.random.default_rng(7)
    (mill,) = content["mills"]
    trained = {name: (0.8 * low, 1.2 * high) for name, (low, _, high) in mill["chemistry"].items()}
    simulated = mill["fingerprints"][0]["about"]["ranges"]
    inside = {name: simulated[name] for name in mill["sliders"]}
    return [
        {"contact": k % 2, **{name: float(generator.uniform(*ends)) for name, ends in (ranges | trained).items()}}
        for ranges in (mill["sliders"], inside)
        for k in range(count // 2)
    ]


def _library(run: dict, state: dict) -> dict:
    """The values of the library for a state of the page."""
    condition = {name: state[name] for name in ("speed_hz", "ball_diameter_m", "fill_ratio", "density_kg_m3")}
    own = run["fingerprints"][state["contact"]]
    found = own.predict(own.condition(**condition))
    rows = pd.DataFrame(
        [
            {name: state[name] for name in CHEMICAL}
            | {
                "normal_energy_uJ": 1e6 * found.normal_energy_J.value,
                "tangential_energy_uJ": 1e6 * found.tangential_energy_J.value,
                "specific_frequency_hz": found.specific_frequency_hz.value,
            }
        ]
    )
    model, value, ends = load_averaged(str(run["yield"])), np.nan, (np.nan, np.nan)
    if rows.notna().all(axis=None):
        value, ends = model.predict(rows)[0], model.intervals(rows, [LEVEL])[0, 0]
    told = range_warnings(rows, trained_ranges(training_rows(str(run["yield"])), run["prediction"]))[0]
    return {
        "bands": [[getattr(getattr(found, name), end) for end in ("value", "lower", "upper")] for name in BANDS],
        "mean": [list(getattr(found, name).ends("mean")) for name in BANDS],
        "contact": [
            [getattr(interval, end) for end in ("lower", "upper")] if interval else [-1.0, -1.0]
            for interval in (getattr(found, name).contact for name in BANDS)
        ],
        "balls": found.balls,
        "outside": sorted(found.outside),
        "yield": [float(each) for each in (value, *ends)],
        "not_trained": sorted(text.split(" = ")[0] for text in told.split("; ") if text),
    }


@pytest.fixture
def page(run, browser):
    with browser.page() as page:
        page.open(run["page"])
        yield page
        assert page.errors == []


@pytest.mark.slow
@needs_browser
def test_the_page_computes_what_the_library_computes(run, page):
    states = _states(run["content"], 24)
    # In the condition without impacts, as many balls as in it, and between it and one with.
    layer = {"contact": 1, "ball_diameter_m": 0.005, "speed_hz": 10.0, "density_kg_m3": DENSITY}
    states += [states[-1] | layer | {"fill_ratio": factor * FILLS[0]} for factor in (1.0, 1.001, 1.2)]
    script = f"""
      const ends = (band) => [band.value, band.lower, band.upper];
      return {states!r}.map((state) => {{
        const found = explorer.answer(state, explorer.fingerprints[state.contact]);
        const contact = (band) => band.further.contact ?? {{ lower: -1, upper: -1 }};
        return {{ bands: {list(BANDS)!r}.map((name) => ends(found[name])), balls: found.balls,
          mean: {list(BANDS)!r}.map((name) => [found[name].further.mean.lower, found[name].further.mean.upper]),
          contact: {list(BANDS)!r}.map((name) => [contact(found[name]).lower, contact(found[name]).upper]),
          outside: [...found.outside].sort(), yield: ends(found.yield_percent),
          not_trained: found.yield_percent.outside.map((each) => each.name).sort() }};
      }});"""
    ours, theirs = page.run(script), [_library(run, state) for state in states]
    for key in ("bands", "mean", "contact", "yield"):
        np.testing.assert_allclose(
            np.array([each[key] for each in ours]), np.array([each[key] for each in theirs]), rtol=1e-6, atol=1e-9
        )
    for key in ("balls", "outside", "not_trained"):
        assert [each[key] for each in ours] == [each[key] for each in theirs]
    steel = [each["bands"] for each, state in zip(theirs, states, strict=True) if state["contact"] == 1]
    assert {bool(np.isnan(bands[0][0])) for bands in steel} == {True, False}
    assert np.isfinite([each["bands"][BANDS.index("wall_power_W")][0] for each in theirs[-3:]]).tolist() == [1, 1, 0]
    assert any(each["outside"] for each in theirs) and any(not each["outside"] for each in theirs)
    # Of the contact set that was analysed, and only where it was.
    known = {(state["contact"], each["contact"][0][0] > 0) for state, each in zip(states, theirs, strict=True)}
    assert known == {(0, True), (0, False), (1, False)}


@needs_browser
def test_the_page_of_many_conditions_computes_from_few_what_the_library_does(run, browser, tmp_path, monkeypatch):
    monkeypatch.setattr(processes, "WHOLE_MAX", 10)
    paths = [run["folder"] / f"fingerprint_{contact}.json" for contact in CONTACTS]
    mill = mill_content(Machine("emax", "A mill", "the jar moves", 0.07), paths, run["request"])
    assert all("reduced" in own for each in mill["fingerprints"] for own in each["processes"].values())
    path = tmp_path / "many.html"
    path.write_text(explorer_page(explorer_content("test", [mill])))
    own = Fingerprint.read(paths[0])
    states = [state for state in _states(run["content"], 24) if state["contact"] == 0]
    names = ("speed_hz", "ball_diameter_m", "fill_ratio", "density_kg_m3")
    theirs = [own.predict(own.condition(**{name: state[name] for name in names})).wall_power_W for state in states]
    with browser.page() as page:
        page.open(path)
        ours = page.run(
            f"return {states!r}.map((state) => {{ const {{ value, lower, upper }} = explorer.fingerprints[0]"
            ".predict(state).wall_power_W; return [value, lower, upper]; });"
        )
        assert page.errors == []
    wanted = [[each.value, each.lower, each.upper] for each in theirs]
    np.testing.assert_allclose(np.array(ours), np.array(wanted), rtol=1e-6)


@needs_browser
def test_intervals_are_shown_apart_and_the_charts_show_the_one_that_is_chosen(page):
    script = """
      const said = "#results div:first-child .interval";
      const lines = () => [...document.querySelectorAll(said)].map((e) => e.textContent);
      const bands = () => [...document.querySelectorAll("#charts svg")].map((e) => e.querySelectorAll(".band").length);
      const shapes = () => [...document.querySelectorAll("#charts .band")].map((e) => e.getAttribute("d")).join();
      const next = () => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
      explorer.state.fill_ratio = 0.12; explorer.axis = "speed_hz"; explorer.render(); await next();
      const first = { lines: lines(), bands: bands(), shapes: shapes() };
      const choice = document.getElementById("shaded");
      const options = [...choice.options].map((option) => option.textContent);
      choice.value = "contact"; choice.dispatchEvent(new Event("change")); await next();
      const chosen = { lines: lines(), bands: bands(), shapes: shapes() };
      explorer.state.fill_ratio = 0.35; explorer.render(); await next();
      const beyond = { lines: lines(), bands: bands() };
      explorer.choose(1); await next();
      return { first, chosen, beyond, other: lines(), options };"""
    said = page.run(script)
    assert said["options"] == ["a new simulation", "the mean", "contact parameters"]
    assert [line.split(":")[0] for line in said["first"]["lines"]] == said["options"]
    assert all(" to " in line for line in said["first"]["lines"])
    assert said["first"]["bands"] == said["chosen"]["bands"] == [2, 2, 2, 1, 4, 1, 1]
    assert said["first"]["shapes"] != said["chosen"]["shapes"] and said["first"]["lines"] == said["chosen"]["lines"]
    # Not analysed there: said in words, and no band is drawn, but that of the yield.
    assert said["beyond"]["lines"][2] == "contact parameters: analysed at fill ratios from 0.06 to 0.3"
    assert said["beyond"]["bands"] == [0, 0, 0, 0, 0, 0, 1]
    assert said["other"][2] == "contact parameters: not analysed for this contact set"


@pytest.mark.slow
@needs_browser
@pytest.mark.parametrize(
    ("left_open", "factor", "speeds"),
    [((), 1, None), (("specific_frequency_hz",), 1, None), ((), 0.05, [600.0, 1200.0])],
)
def test_the_page_finds_the_nearest_conditions_that_the_library_finds(run, page, left_open, factor, speeds):
    """Also where they are at a corner of the ranges, which was simulated: the simulated value counts, not the curve."""
    request = run["request"]
    target = {name: factor * value for name, value in request.targets[0].given.items() if name not in left_open}
    if speeds:
        request = request.model_copy(update={"speeds_rpm": speeds})
    script = f"""
      explorer.mill.content.search.speeds_rpm = {request.speeds_rpm!r};
      const rows = await explorer.mill.search({target!r});
      return rows.map((row) => [row.distance, row.condition.ball_diameter_m * 1e3,
        row.condition.fill_ratio, row.condition.speed_hz * 60]);"""
    ours = np.array(page.run(script))
    table = rank_conditions(target, run["fingerprints"], request)
    theirs = table[["distance", "ball_diameter_mm", "fill_ratio", "speed_rpm"]].to_numpy(float)
    assert len(ours) == len(theirs) > 2
    np.testing.assert_allclose(ours[:, 0], theirs[:, 0], rtol=1e-4, atol=1e-6)
    apart = theirs[:, 0] > 1e-5
    np.testing.assert_allclose(ours[apart, 1:], theirs[apart, 1:], rtol=2e-3)


@needs_browser
def test_a_slider_moves_every_answer_and_marks_what_was_not_simulated(page):
    script = """
      const shown = () => [...document.querySelectorAll("#results dd:nth-of-type(1)")].map((e) => e.textContent);
      const slide = (name, value) => { const slider = document.getElementById(name); slider.value = value;
        slider.dispatchEvent(new Event("input")); };
      slide("speed_hz", 700); const before = shown(); const quiet = document.getElementById("outside").textContent;
      slide("speed_hz", 1100); const after = shown();
      slide("speed_hz", 2400); const warned = document.getElementById("outside").textContent;
      await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
      return { before, after, quiet, warned, hint: document.getElementById("speed_hz-hint").textContent,
        charts: document.querySelectorAll("#charts svg[role=img][aria-label]").length };"""
    said = page.run(script)
    # The speed changes neither the tangential share by much nor what is weighed in; all else moves.
    assert sum(one != other for one, other in zip(said["before"], said["after"], strict=True)) >= 7
    assert "Not simulated" not in said["quiet"] and "Not simulated: speed" in said["warned"]
    assert said["hint"].startswith("outside") and "600 to 1200 rpm" in said["hint"]
    assert said["charts"] == 7


# Put a number into the field of a setting; what is told at its place, and what the field then has.
PUT = """
  const put = (name, text) => { const field = document.getElementById(`${name}-field`);
    field.focus(); field.value = text; field.dispatchEvent(new Event("change"));
    return [document.getElementById(`${name}-hint`).textContent, Number(field.value)]; };"""


@needs_browser
def test_a_number_that_is_changed_or_not_taken_is_told_at_its_place(page):
    said = page.run(f"""{PUT}
      const {{ powder_g }} = explorer.answer(explorer.state);
      const few = put("powder", "1e-6"), none = put("powder", "-2"), taken = put("powder", "20");
      const field = document.getElementById("target-specific_frequency_hz");
      field.value = "-5"; field.dispatchEvent(new Event("change"));
      return {{ few, none, taken, bpr: explorer.answer(explorer.state).balls_g / 20 - explorer.state.bpr,
        time: put("time_h", "1e5"), most: explorer.mill.reach("time_h")[1], target: field.value,
        open: document.getElementById("left-open").textContent }};""")
    assert said["few"][0].startswith("1e-6 g cannot be set here: ") and said["few"][1] > 0.1
    assert said["none"] == ["-2 is no number over 0", said["few"][1]] and said["taken"] == ["", 20]
    assert said["bpr"] == pytest.approx(0, abs=1e-9)
    assert said["time"][0].startswith("100000 h cannot be set here: ") and said["time"][1] <= said["most"]
    assert said["target"] == "" and said["open"].startswith("-5 is no number over 0: ")


@needs_browser
def test_the_advice_takes_as_given_only_what_was_not_analysed(page):
    said = page.run("""
      const read = () => ["use-for", "avoid-for"].map((id) => document.getElementById(id).textContent);
      explorer.state.fill_ratio = 0.12; explorer.render(); const analysed = read();
      explorer.choose(1); return { analysed, other: read() };""")
    use, avoid = said["analysed"]
    assert "unknown friction and restitution: it has" in use
    assert "whole error: shape of the jar is taken as given" in avoid
    use, avoid = said["other"]
    assert "unknown friction" not in use and "friction, restitution and shape of the jar are taken as given" in avoid


@pytest.mark.slow
@needs_browser
def test_the_page_and_the_library_give_one_verdict_on_a_match(browser):
    """On the page of the mills that come with millprint: each condition that is first shown, on two other mills."""
    with browser.page() as page:
        page.open(ROOT / "docs/fingerprints.html")
        for like, mill in (("emax", "planetary"), ("mixer", "spex"), ("planetary", "drum")):
            said = page.run(f"""
              explorer.change(() => explorer.useMill(explorer.mills.find((each) => each.name === {like!r})));
              explorer.state.time_h = 8;
              const wanted = {{ ...explorer.state }};
              await explorer.finder.findOn({mill!r});
              const {{ row, condition }} = explorer.finder.matched;
              const text = (id) => document.getElementById(id).textContent;
              return {{ wanted, condition, row: {{ verdict: row.verdict, ratios: row.ratios, time: row.time }},
                searching: text("searching"), wish: text("wanted"), methods: text("methods"),
                choices: document.querySelectorAll("#choices li").length,
                time_h: explorer.state.time_h, rows: document.querySelectorAll("#found tbody tr").length }};""")
            one, other = (read_fingerprint(name) for name in (like, mill))
            wanted = {name: said["wanted"][name] for name in ("speed_hz", "fill_ratio", "ball_diameter_m")}
            target = target_at(one, one.condition(**wanted), "", [other], SearchConfig())
            table = rank_conditions(target, [other], SearchConfig())
            best = best_of(table)
            assert said["rows"] == len(table) and said["row"]["verdict"] == best["verdict"]
            assert 60 * said["condition"]["speed_hz"] == pytest.approx(best["speed_rpm"], rel=5e-3)
            pairs = [(said["row"]["ratios"][name], f"{name}_ratio") for name in target.asked]
            for ours, name in [*pairs, (said["row"]["time"], "time_ratio")]:
                interval = ours["interval"] or {"lower": np.nan, "upper": np.nan}
                theirs = [best[column] for column in (name, *columns_of(name, "mean"))]
                np.testing.assert_allclose([ours["value"], *interval.values()], theirs, rtol=2e-2)
            # The page then shows the time for the same dose, also beyond its slider.
            assert said["time_h"] == pytest.approx(8 * best["time_ratio"], rel=2e-2)
            # Ratios have three digits, also small ones.
            shown = re.findall(r"([\d.]+) times", said["searching"])
            assert [len(text.replace(".", "").lstrip("0")) for text in shown] == [3] * len(target.asked)
            # The sentences and what else could be chosen are those of the command.
            lines = match_in_words(table, target, SearchConfig(), [other])
            assert said["choices"] == sum(line.startswith("or ") for line in lines)
            head = {"agrees": "Met", "open": "Not known", "differs": "Not met"}[best["verdict"]]
            assert said["searching"].startswith(head) and "8 h there is " in said["searching"]
            # What was wanted stays in view, and the methods text is of what was found.
            assert said["wish"].startswith("Wanted: what ") and said["wish"].split(" does")[0][14:] in said["methods"]
        assert not page.errors and not page.outside_requests()


@needs_browser
@pytest.mark.parametrize(("width", "height"), [(DESKTOP, 900), (PHONE, 844)])
def test_what_was_wanted_and_the_answer_of_a_search_are_in_view(browser, width, height):
    with browser.page(width, height) as page:
        page.open(ROOT / "docs/fingerprints.html")
        said = page.run("""
          const box = (id) => document.getElementById(id).getBoundingClientRect();
          const ends = (id) => [box(id).top, box(id).bottom];
          const text = (id) => document.getElementById(id).textContent;
          await explorer.finder.findOn("planetary");
          const bar = box("brief");
          const found = { seen: [ends("wanted"), ends("searching")], foot: bar.height ? bar.top : innerHeight,
            focus: document.activeElement.id };
          // Other units, another of the found conditions, and other settings than any of them.
          const unit = document.getElementById("unit-speed");
          unit.value = "Hz"; unit.dispatchEvent(new Event("change"));
          const hertz = { hidden: document.getElementById("answer").hidden, answer: text("searching") };
          document.querySelectorAll("#found button")[1].click();
          found.seen.push(ends("compared"));
          const chosen = text("methods");
          explorer.state.fill_ratio = 0.2; explorer.render();
          const moved = { compared: text("compared"), methods: text("methods") };
          const ratio = () => explorer.finder.toWanted(explorer.answer(explorer.state)).time.value;
          const times = [ratio()];
          explorer.state.bpr *= 2; explorer.render();
          times.push(ratio()); found.doubled = text("compared");
          explorer.state.bpr /= 2; explorer.render();
          // By the form: what one mill does, on another that is chosen by hand.
          document.getElementById("take").click();
          explorer.change(() => explorer.useMill(explorer.mills.find((each) => each.name === "spex")));
          document.getElementById("search").requestSubmit();
          while (!explorer.finder.answer) await new Promise((done) => setTimeout(done, 50));
          await new Promise((done) => setTimeout(done, 200));
          found.seen.push(ends("wanted"), ends("searching"));
          const [best] = explorer.finder.answer.rows;
          return { ...found, ...moved, times, hertz, chosen, byForm: text("methods"),
            same: explorer.state.speed_hz === best.condition.speed_hz };""")
        for top, bottom in said["seen"]:
            assert 0 <= top < bottom <= said["foot"]
        assert said["focus"] == "answer" and not said["hertz"]["hidden"] and " Hz, balls of" in said["hertz"]["answer"]
        wanted = "Retsch Emax, 125 mL jar, 900 rpm, balls of 10 mm, fill 0.100"
        verdict = r"(met|not met|not known)"
        assert re.search(rf"chosen to do what {wanted} does \({verdict} within 30 %\): E\*n", said["chosen"])
        assert re.match(rf"Wanted: what {wanted} does\. (?i:{verdict}): E\*n", said["compared"])
        assert re.search(rf"Compared with {wanted} \({verdict} within 30 %\): E\*n", said["methods"])
        assert "were chosen" not in said["methods"]
        # Half the powder has the same energy per gram in half the time.
        assert said["times"][1] == pytest.approx(said["times"][0] / 2) and said["doubled"] != said["compared"]
        assert said["same"] and "These settings were chosen to do what Planetary mill" in said["byForm"]


def test_text_of_the_run_cannot_end_the_script_or_become_markup(run):
    text = run["page"].read_text()
    assert "A mill &lt;of&gt; ours" in text and "<of>" not in text
    assert text.count("</script>") == 1
    assert "https://" not in text and "src=" not in text


def test_sliders_reach_past_what_was_simulated(run):
    about = {"ranges": {"speed_hz": [10, 20], "fill_ratio": [0.1, 0.5], "ball_diameter_m": [0.01, 0.01]}}
    about["ranges"]["density_kg_m3"] = [7700, 7700]
    found = sliders([about], run["request"])
    assert found["speed_hz"] == pytest.approx([5 / 1.25, 2000 / 60 * 1.25])
    assert found["density_kg_m3"] == pytest.approx([3850, 15400])
    assert found["fill_ratio"][1] == 0.6
