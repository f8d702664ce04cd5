"""Writes schemas, config/keys.md, workflow/descriptors.md, workflow/card.md, docs/mills.html: `make reference`."""

from pathlib import Path

from millprint.card.card_schema import card_schema_text, explain_card
from millprint.config.document import MODELS, schema_text
from millprint.config.included import load_mill
from millprint.config.reference import reference_text
from millprint.explorer.content import Machine, explorer_content, mill_content
from millprint.explorer.page import explorer_page
from millprint.fingerprint.columns import explain_columns
from millprint.fingerprint.condition_search import simulated_request
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.ready_made import find_ready_made, ready_made
from millprint.run.files import whole_file

ROOT = Path(__file__).parent.parent
PAGES = {
    "config/keys.md": reference_text,
    "workflow/descriptors.md": explain_columns,
    "workflow/card.md": explain_card,
    "workflow/schemas/card.schema.json": card_schema_text,
}
# Its text takes longer than that of the others.
MILLS = "docs/mills.html"


def mills_page() -> str:
    """The explorer of the mills that come with millprint, from their fingerprints, without a simulation."""
    contents = []
    for name in ready_made():
        path = find_ready_made(name)
        assert path is not None, f"{name}: its file is another one than config/fingerprints was made of"
        request = simulated_request(Fingerprint.read(path), "weighted")
        contents.append(mill_content(Machine.of_mill(load_mill(name)), [path], request))
    return explorer_page(explorer_content("the mills of millprint", contents))


def main() -> None:
    """Write every schema and every page."""
    for name in MODELS:
        with whole_file(ROOT / "workflow" / "schemas" / f"{name}.schema.json") as draft:
            draft.write_text(schema_text(name))
    for name, text in (PAGES | {MILLS: mills_page}).items():
        with whole_file(ROOT / name) as draft:
            draft.write_text(text())


if __name__ == "__main__":
    main()
