"""Modules that other packages import for more than a second, and that no test needs."""

import sys

__all__ = ["leave_out"]

_UNNEEDED = ("rfc3987_syntax",)
"""It judges international addresses for jsonschema, of which no schema here has one; it builds
parsers when it is imported."""


def leave_out() -> None:
    """Let their imports fail, as if they were not installed."""
    for name in _UNNEEDED:
        sys.modules[name] = None  # type: ignore[assignment]
