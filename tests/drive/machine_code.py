"""Drives that tests run for many cycles: in machine code where there is a compiler."""

from typing import Any

from achse.drive import VirtualDrive
from achse.native.backend import compiler_installed

__all__ = ["fast_drive"]


def fast_drive(*arguments: Any, **options: Any) -> VirtualDrive:
    """A drive in machine code; `test_compiled` shows that it does what a plain one does."""
    return VirtualDrive(*arguments, compiled=compiler_installed(), **options)
