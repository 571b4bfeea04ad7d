"""Hints for a name that a device does not know: what may have been meant, and what it holds."""

from collections.abc import Mapping, Sequence
from typing import Any

from achse.iec import IecIndexError, IecPathError, IecType, StructType, resolved
from achse.iec.derived import ReferenceType
from achse.iec.nearest import did_you_mean
from achse.iec.paths import PathMember, PathMethod, follow, parse_path
from achse.iec.symbols import SymbolEntry, fold

_SHOWN = 4


def hint_for(name: str, listed: Mapping[str, SymbolEntry]) -> str:
    """`; did you mean 'MAIN.nCounter'?` for a name that is not a symbol, or what a list holds.

    `listed` are the symbols of a device by folded name. Nothing for a symbol that is there.
    """
    name = name.strip().rstrip(".")
    key = fold(name)
    if key in listed:
        return ""
    inside = [entry.name for each, entry in listed.items() if each.startswith(f"{key}.")]
    if not inside or not key:
        names = [entry.name for entry in listed.values()]
        if "." not in name:  # that of a program or a list
            names += {each.partition(".")[0]: None for each in names}
        return did_you_mean(name, names)
    symbols = "1 symbol" if len(inside) == 1 else f"{len(inside)} symbols"
    return f"; {name} holds {symbols}: {_some(inside)}"


def hint_inside(type: IecType[Any], rest: str) -> str:
    """For a path that begins at a symbol of `type` and leaves it by `rest`, like `.fVelocty`.

    `; ST_Axis has no member 'fVel'; did you mean 'fVelo'?`, or nothing.
    """
    try:
        for step in parse_path(rest):
            within = _record(type)
            try:
                type = follow(type, [step]).type
            except IecPathError as fault:
                if within is None or not isinstance(step, PathMember | PathMethod):
                    raise
                names = _names(within, step)
                return f"; {fault}{did_you_mean(step.name, names) or _it_has(names)}"
    except (IecPathError, IecIndexError) as fault:
        return f"; {fault}"
    return ""


def _record(type: IecType[Any]) -> StructType[Any] | None:
    """Return the record that a step goes into, behind references."""
    real = resolved(type)
    while isinstance(real, ReferenceType):
        real = resolved(real.target)
    return real if isinstance(real, StructType) else None


def _names(record: StructType[Any], step: PathMember | PathMethod) -> list[str]:
    if isinstance(step, PathMethod):
        return [method.name for method in record.methods]
    return [member.name for member in record.fields] + [item.name for item in record.properties]


def _it_has(names: Sequence[str]) -> str:
    return f"; it has {_some(names)}" if names else ""


def _some(names: Sequence[str]) -> str:
    return ", ".join(names[:_SHOWN]) + ", …" * (len(names) > _SHOWN)
