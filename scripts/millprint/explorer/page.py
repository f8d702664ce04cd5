"""The explorer as one HTML file."""

from pathlib import Path

from millprint.pages import embed_files, embed_json, render_page

FOLDER = Path(__file__).parent
SCRIPTS = ("numerics.js", "fingerprint.js", "yields.js", "search.js", "charts.js", "page.js")


def explorer_page(content: dict) -> str:
    """The page that carries `content`, as `explorer_content` makes it, and computes from it in the browser."""
    abouts = [stored["about"] for stored in content["fingerprints"]]
    first = abouts[0]
    return render_page(
        FOLDER / "page.html",
        name=content["name"],
        title=content["title"],
        probability=f"{100 * first['probability']:g}",
        level=f"{100 * content['yield']['level']:g}",
        search=content["search"],
        about=first,
        contacts=[about["contact"] for about in abouts],
        conditions=sum(len(stored["inputs"]["fill_ratio"]) for stored in content["fingerprints"]),
        runs=len(content["yield"]["members"][0]["target"]),
        style=embed_files(FOLDER, "page.css"),
        scripts=embed_files(FOLDER, *SCRIPTS),
        content=embed_json(content),
    )
