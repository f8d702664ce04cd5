"""The explorer: one HTML file with the fingerprints of mills, which computes in the browser and fetches nothing."""

from pathlib import Path

from millprint.run.html_pages import embed_files, embed_json, render_page

FOLDER = Path(__file__).parent
# In the order of their dependencies.
SCRIPTS = (
    *("numerics.js", "fingerprint.js", "yields.js", "search.js", "units.js", "mill.js", "conditions.js"),
    *("elements.js", "charts.js", "logcharts.js", "controls.js", "results.js", "finder.js", "spectra.js", "heat.js"),
    *("intro.js", "advice.js", "methods.js", "state.js", "page.js"),
)


def explorer_page(content: dict) -> str:
    """The page with `content` from `millprint.explorer.content.explorer_content`, from which it computes."""
    return render_page(
        FOLDER / "page.html",
        name=content["name"],
        title=content["mills"][0]["title"],
        several=len(content["mills"]) > 1,
        style=embed_files(FOLDER, "page.css"),
        scripts=embed_files(FOLDER, *SCRIPTS),
        content=embed_json(content),
    )
