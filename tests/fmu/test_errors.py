"""The error of an export."""

from achse.fmu.errors import ExportError


def test_export_error_is_a_value_error() -> None:
    assert issubclass(ExportError, ValueError)
