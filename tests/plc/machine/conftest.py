"""The fixtures of plain code: each gives both forms."""

from tests.plc.code.conftest import form, run

__all__ = ["form", "run"]
