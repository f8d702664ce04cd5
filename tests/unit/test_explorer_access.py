"""The explorer for everyone: axe finds no fault, a keyboard reaches everything, a phone needs no sideways scroll."""

import pytest

from tests.browser import DESKTOP, PHONE, needs_browser

# The element that has the focus: a name, where it is in the page, and whether its focus can be seen.
FOCUSED = """
  const focused = document.activeElement; const style = getComputedStyle(focused);
  const box = focused.getBoundingClientRect();
  return { id: focused.id || focused.textContent.slice(0, 30) || focused.tagName, tag: focused.tagName,
    seen: style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 1,
    within: box.left >= -1 && box.right <= innerWidth + 1 };"""


@pytest.fixture
def page(built, browser):
    with browser.page() as page:
        page.open(built["page"])
        yield page
        assert page.errors == []


@pytest.mark.slow
@needs_browser
@pytest.mark.parametrize("width", [DESKTOP, PHONE])
def test_axe_finds_no_fault_with_everything_shown(page, width):
    page.resize(width, 1200)
    page.run("""
      document.getElementById("take").click(); await explorer.finder.show();
      explorer.state.speed_hz = 24; explorer.keeper.read("{}"); explorer.render();
      await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));""")
    assert page.run(
        "return !document.getElementById('found').hidden && document.getElementById('outside').textContent !== '';"
    )
    assert page.accessibility_faults() == []
    measured = page.measure()
    assert measured["width"] == width and measured["beyond"] <= 0 and measured["smallest"] >= 10


@needs_browser
def test_on_paper_nothing_lies_over_the_text(page):
    page.resize(PHONE, 900)
    shown = "return ['brief', 'search', 'results'].map((id) => document.getElementById(id).checkVisibility());"
    assert page.run(shown) == [True, True, True]
    page.print()
    assert page.run(shown) == [False, False, True]


@needs_browser
def test_axe_finds_the_faults_of_a_page_that_has_some(page):
    page.run("""document.getElementById("mill").labels[0].remove();
      document.querySelector("#charts svg").removeAttribute("aria-label");
      document.getElementById("intro").style.color = "#ccc";""")
    found = {fault.split(":")[0] for fault in page.accessibility_faults()}
    assert found == {"select-name", "svg-img-alt", "color-contrast"}


@needs_browser
@pytest.mark.parametrize("width", [DESKTOP, PHONE])
def test_the_tab_key_reaches_every_control_with_a_visible_focus(page, width):
    page.resize(width, 1200)
    wanted = page.run("""
      const shown = (e) => e.checkVisibility() && !e.disabled && (e.type !== "radio" || e.checked);
      return [...document.querySelectorAll("summary, button, select, input, [tabindex='0']")].filter(shown)
        .map((e) => e.id || e.textContent.slice(0, 30) || e.tagName);""")
    assert len(wanted) > 25
    reached = []
    for _ in range(len(wanted)):
        page.press("Tab")
        focused = page.run(FOCUSED)
        assert focused["seen"], f"no focus is seen on {focused['id']}"
        assert focused["within"], focused
        reached.append(focused["id"])
    # In the order of the page, and nothing holds the focus.
    assert reached == wanted


@needs_browser
def test_keys_move_a_slider_and_press_a_button(page):
    page.run("document.getElementById('fill_ratio').focus();")
    before = page.run("return explorer.state.fill_ratio;")
    page.press("ArrowRight")
    assert page.run("return explorer.state.fill_ratio;") == pytest.approx(before + 0.005)
    page.run("document.getElementById('find').focus();")
    page.press("Space")
    page.run("await new Promise((done) => setTimeout(done, 3000));")
    assert page.run("return document.querySelectorAll('#found tbody tr').length;") > 0
