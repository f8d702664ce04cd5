"""Writes the schemas, config/keys.md (every key) and workflow/descriptors.md (every column): `make reference`."""

from pathlib import Path

from millprint.config.document import MODELS, reference_text, schema_text
from millprint.files import whole_file
from millprint.fingerprint.columns import explain_columns

ROOT = Path(__file__).parent.parent
PAGES = {"config/keys.md": reference_text, "workflow/descriptors.md": explain_columns}


def main() -> None:
    """Write every schema and both pages."""
    for name in MODELS:
        with whole_file(ROOT / "workflow" / "schemas" / f"{name}.schema.json") as partial:
            partial.write_text(schema_text(name))
    for name, text in PAGES.items():
        with whole_file(ROOT / name) as partial:
            partial.write_text(text())


if __name__ == "__main__":
    main()
