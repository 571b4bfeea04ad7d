"""Errors of an export."""

__all__ = ["ExportError"]


class ExportError(ValueError):
    """A station that cannot be a unit, or a tool that is missing: expected, got."""
