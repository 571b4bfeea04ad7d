"""Files against JSON schemas, without a process for each."""

from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

__all__ = ["complaints", "validate"]


def complaints(schema: str, *files: str | Path) -> str:
    """Return what `check-jsonschema --builtin-schema` prints of files; empty if it is content."""
    main = pytest.importorskip("check_jsonschema", reason="the group `dev` has it").main
    words = ["--regex-variant", "python", "--builtin-schema", schema, *map(str, files)]
    result = CliRunner().invoke(main, words)
    return result.output if result.exit_code else ""


def validate(document: object, schema: dict[str, Any]) -> None:
    """Raise an error of jsonschema if the document is not as the schema says."""
    jsonschema = pytest.importorskip("jsonschema")
    jsonschema.validate(document, schema)
