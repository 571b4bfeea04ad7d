"""Files against JSON schemas, without a process for each."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

__all__ = ["complaints", "validate"]

IRIS = "rfc3987_syntax"
"""Judges international addresses for jsonschema, of which no schema here has one. It builds parsers
when it is imported, for more than a second."""


@contextmanager
def without_iris() -> Iterator[None]:
    """Import jsonschema here, in this or in another way."""
    with pytest.MonkeyPatch.context() as patch:
        if IRIS not in sys.modules:
            patch.setitem(sys.modules, IRIS, None)
        yield


def complaints(schema: str, *files: str | Path) -> str:
    """Return what `check-jsonschema --builtin-schema` prints of files; empty if it is content."""
    with without_iris():
        main = pytest.importorskip("check_jsonschema", reason="the group `dev` has it").main
        words = ["--regex-variant", "python", "--builtin-schema", schema, *map(str, files)]
        result = CliRunner().invoke(main, words)
    return result.output if result.exit_code else ""


def validate(document: object, schema: dict[str, Any]) -> None:
    """Raise an error of jsonschema if the document is not as the schema says."""
    with without_iris():
        import jsonschema
    jsonschema.validate(document, schema)
