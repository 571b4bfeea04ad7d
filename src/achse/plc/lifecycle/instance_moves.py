"""Instances that an online change ends, copies and creates, variable by variable.

An instance is touched where the vendor's runtime would move it: the layout of its type has changed,
or of what it is in. Source: FB_init, FB_reinit and FB_exit, attributes `no_copy`,
`init_on_onlchange` and `enable_dynamic_creation` of TwinCAT 3.
"""

from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from typing import Any, NamedTuple

from achse.iec.describe import types_within
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.iec.variables import Variable
from achse.plc.program import PlacedUnit, PlacedVariable


def is_alike(old: IecType[Any], new: IecType[Any]) -> bool:
    """Return True if values of one type are values of the other, byte by byte."""
    return old.size == new.size and (old is new or old.guid == new.guid)


def is_renewed(variable: Variable[Any, Any]) -> bool:
    """Return True for attribute `init_on_onlchange`: an online change starts the variable again."""
    return _has(variable, "init_on_onlchange")


def is_not_copied(variable: Variable[Any, Any]) -> bool:
    """Return True for attribute `no_copy`: the variable starts again if its instance moves."""
    return _has(variable, "no_copy")


def _has(variable: Variable[Any, Any], attribute: str) -> bool:
    return any(name.lower() == attribute for name in variable.attributes)


class InstanceMoves(NamedTuple):
    """Variables of programs and lists, `main.fbpump`, that an online change does something to."""

    copied: frozenset[str]
    """Their type has changed: end, begin, copy what is left of the values, FB_reinit."""
    renewed: frozenset[str]
    """They start again, and nothing is copied: `init_on_onlchange`, and `no_copy` in a unit that
    has changed."""
    new: frozenset[str]
    gone: frozenset[str]

    @classmethod
    def between(
        cls, before: Iterable[PlacedVariable], after: Iterable[PlacedVariable]
    ) -> "InstanceMoves":
        """Return the difference between two sets of declarations."""
        old = {placed.name.lower(): placed for placed in before}
        new = {placed.name.lower(): placed for placed in after}
        changed = {
            name
            for name, placed in new.items()
            if name in old and not is_alike(old[name].variable.type, placed.variable.type)
        }
        touched = {_unit(name) for name in changed | (old.keys() ^ new.keys())}
        renewed = {
            name
            for name, placed in new.items()
            if name in old
            and (
                is_renewed(placed.variable)
                or (is_not_copied(placed.variable) and _unit(name) in touched)
            )
        }
        return cls(
            frozenset(changed - renewed),
            frozenset(renewed),
            frozenset(new.keys() - old.keys()),
            frozenset(old.keys() - new.keys()),
        )

    @property
    def again(self) -> frozenset[str]:
        """Variables whose instances end and begin."""
        return self.copied | self.renewed


def _unit(name: str) -> str:
    return name.rpartition(".")[0]


def unit_variable(node: object) -> str:
    """Return the variable that a statement of `create`, `exit` or `reinit` is about; empty without
    one."""
    from achse.st.typed.places import UnitBase  # not needed without Structured Text

    if isinstance(node, UnitBase):
        return f"{node.unit}.{node.variable.name}".lower()
    if isinstance(node, tuple):
        parts: Iterable[object] = node
    elif is_dataclass(node) and type(node).__module__.startswith("achse.st.typed"):
        parts = (getattr(node, field.name) for field in fields(node))
    else:
        return ""
    return next((name for name in map(unit_variable, parts) if name), "")


def layouts(units: Iterable[PlacedUnit]) -> Mapping[str, StructType[Any]]:
    """Return the records that units are made of or point to, by name in lower case."""
    return {
        type.name.lower(): type
        for type in types_within([unit.instance.__iec__ for unit in units])
        if isinstance(type, StructType)
    }
