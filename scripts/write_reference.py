"""Writes workflow/schemas and config/keys.md, the reference of every key, from the models: `make reference`."""

from pathlib import Path

from millprint.config.document import MODELS, reference_text, schema_text
from millprint.files import whole_file

ROOT = Path(__file__).parent.parent
REFERENCE = ROOT / "config" / "keys.md"


def main() -> None:
    """Write every schema and the reference."""
    for name in MODELS:
        with whole_file(ROOT / "workflow" / "schemas" / f"{name}.schema.json") as partial:
            partial.write_text(schema_text(name))
    with whole_file(REFERENCE) as partial:
        partial.write_text(reference_text())


if __name__ == "__main__":
    main()
