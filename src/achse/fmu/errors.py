"""Errors of an export."""


class ExportError(ValueError):
    """A station that cannot be a unit, or a tool that is missing: expected, got."""
