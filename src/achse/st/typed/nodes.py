"""Nodes of the typed form, whatever they are: which objects are nodes, and all inside of one."""

from collections.abc import Iterator
from enum import Enum
from typing import Any

from achse.st.syntax.nodes import field_names

_MODULES = frozenset(f"achse.st.typed.{name}" for name in ("expressions", "places", "statements"))


def is_node(value: object) -> bool:
    """Return True if an object is a node of the typed form."""
    return type(value).__module__ in _MODULES and not isinstance(value, Enum)


def nodes_in(node: Any) -> Iterator[Any]:
    """Yield a node or the nodes of a tuple, and all nodes inside, in no special order."""
    waiting = [node]
    while waiting:
        one = waiting.pop()
        if isinstance(one, tuple):
            waiting += one
        elif is_node(one):
            yield one
            kind: type = type(one)
            waiting += [getattr(one, name) for name in field_names(kind)]
