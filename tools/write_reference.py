"""Writes schemas, config/keys.md (keys), workflow/descriptors.md (columns), workflow/card.md: `make reference`."""

from pathlib import Path

from millprint.card.card_schema import card_schema_text, explain_card
from millprint.config.document import MODELS, schema_text
from millprint.config.reference import reference_text
from millprint.fingerprint.columns import explain_columns
from millprint.run.files import whole_file

ROOT = Path(__file__).parent.parent
PAGES = {
    "config/keys.md": reference_text,
    "workflow/descriptors.md": explain_columns,
    "workflow/card.md": explain_card,
    "workflow/schemas/card.schema.json": card_schema_text,
}


def main() -> None:
    """Write every schema and every page."""
    for name in MODELS:
        with whole_file(ROOT / "workflow" / "schemas" / f"{name}.schema.json") as draft:
            draft.write_text(schema_text(name))
    for name, text in PAGES.items():
        with whole_file(ROOT / name) as draft:
            draft.write_text(text())


if __name__ == "__main__":
    main()
