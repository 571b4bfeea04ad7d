"""Public names that a module defines itself."""

from types import ModuleType

__all__ = ["public_names"]


def public_names(module: ModuleType) -> list[str]:
    """Names without an underscore that the module does not import, in the order of its text.

    Classes and functions know their module; all else counts, modules aside.
    """
    return [
        name
        for name, value in vars(module).items()
        if not name.startswith("_")
        and not isinstance(value, ModuleType)
        and not (callable(value) and value.__module__ != module.__name__)
    ]
