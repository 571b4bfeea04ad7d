"""Differences between two symbol files: types and variables that were added, removed or changed."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from achse.iec.datatypes import DataTypeEntry
from achse.iec.describe import describe_type
from achse.iec.types import IecType
from achse.st.symbolfiles.model import FileVariable, SymbolFile, is_defined


class Change(NamedTuple):
    """One difference; `kind` is `type` or `variable`, `before` or `after` is empty if it is new
    or gone."""

    kind: str
    name: str
    before: str
    after: str

    def __str__(self) -> str:
        if not self.before:
            return f"+ {self.kind} {self.name}: {self.after}"
        if not self.after:
            return f"- {self.kind} {self.name}: {self.before}"
        return f"~ {self.kind} {self.name}: {self.before} -> {self.after}"


def differences(old: SymbolFile, new: SymbolFile, *, places: bool = True) -> list[Change]:
    """Return every difference, types first, by name. Without `places` addresses may differ."""
    return [
        *_compared("type", dict(_types(old)), dict(_types(new))),
        *_compared("variable", dict(_variables(old, places)), dict(_variables(new, places))),
    ]


def _compared(
    kind: str, old: Mapping[str, tuple[str, str]], new: Mapping[str, tuple[str, str]]
) -> Iterator[Change]:
    for key in sorted(old.keys() | new.keys()):
        before, after = old.get(key), new.get(key)
        if before == after:
            continue
        name = (after or before or ("",))[0]
        yield Change(kind, name, before[1] if before else "", after[1] if after else "")


def _types(file: SymbolFile) -> Iterator[tuple[str, tuple[str, str]]]:
    for type in file.types:
        if is_defined(type):
            yield type.name.lower(), (type.name, _definition(type))


def _definition(type: IecType[Any]) -> str:
    entry = describe_type(type)
    parts = [f"{entry.type_name or 'STRUCT'} ({entry.size} bytes)"]
    parts += [_member(item) for item in entry.members]
    parts += [f"{name}={int.from_bytes(raw, 'little')}" for name, raw in entry.enum_values]
    for method in entry.methods:
        inputs = ", ".join(f"{item.name} : {item.type_name}" for item in method.parameters)
        parts.append(f"#{method.name}({inputs}) : {method.return_type or '-'}")
    return "; ".join(parts)


def _member(item: DataTypeEntry) -> str:
    return f"{item.name} : {item.type_name} @{item.offset}"


def _variables(file: SymbolFile, places: bool) -> Iterator[tuple[str, tuple[str, str]]]:
    for item in file.variables:
        yield item.name.lower(), (item.name, _declaration(item, places))


def _declaration(item: FileVariable, places: bool) -> str:
    at = f" AT {item.declared.address}" if places and item.declared.address else ""
    return f"{item.declared.type.name}{at}"
