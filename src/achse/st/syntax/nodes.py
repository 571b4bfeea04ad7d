"""Nodes of syntax trees and of what is made of them: classes that are compared without places."""

from dataclasses import dataclass, field, fields
from functools import cache
from typing import Any, TypeVar, dataclass_transform

N = TypeVar("N")


@dataclass_transform(frozen_default=True)
def node(cls: type[N]) -> type[N]:
    """Makes a class of nodes, which do not change once they are made.

    Type checkers see to that. `frozen=True` would do so at run time, and make the nodes of a
    large project take four times as long.
    """
    return dataclass(slots=True, unsafe_hash=True)(cls)


def place() -> Any:
    """Return the field `at` of a node."""
    return field(default=0, compare=False, repr=False)


def changed(node: N, **changes: Any) -> N:
    """Return a copy of a node with other values of some fields, faster than `replace`."""
    copy = object.__new__(node.__class__)
    for name in node.__class__.__match_args__:  # type: ignore[attr-defined]
        setattr(copy, name, changes[name] if name in changes else getattr(node, name))
    return copy


@cache
def field_names(kind: type) -> tuple[str, ...]:
    """Return the names of the fields of a class of nodes, without the place; none of others."""
    if not hasattr(kind, "__dataclass_fields__"):
        return ()
    return tuple(item.name for item in fields(kind) if item.name != "at")
