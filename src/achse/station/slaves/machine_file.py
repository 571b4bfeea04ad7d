"""The machine of a drive as a TOML file: motor, load, encoder, switches, stops and probe.

Tables at the top are for all drives; each `[[drive]]` has those of one, along the cable.
"""

import types
from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from enum import IntEnum
from pathlib import Path
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

from achse.drive.machine import MACHINES, MachineError, Mechanics
from achse.iec.nearest import did_you_mean
from achse.station.configuration.documents import parse_toml

R = TypeVar("R")


class MachineFileError(ValueError):
    """A machine file cannot be used: file, key, what was expected, what came."""


def read_machines(file: Path, kinds: list[str]) -> list[Mechanics]:
    """Return the machine of each drive; `kinds` are theirs where the file says none.

    Raises MachineFileError; OSError if the file cannot be read.
    """
    try:
        return machines_of(parse_toml(file.read_text(encoding="utf-8")), kinds)
    except (MachineError, ValueError) as fault:
        raise MachineFileError(f"{file}: {fault}") from None


def machines_of(document: Mapping[str, Any], kinds: list[str]) -> list[Mechanics]:
    """Return the same of a document that is read already. Raises ValueError."""
    common = {key: value for key, value in document.items() if key != "drive"}
    single = document.get("drive", [])
    if not isinstance(single, list) or not all(isinstance(each, dict) for each in single):
        raise ValueError(f"drive: expected [[drive]] tables, got {single!r:.80}")
    if len(single) > len(kinds):
        raise ValueError(f"drive: expected up to {len(kinds)} tables (--count), got {len(single)}")
    machines = []
    for number, kind in enumerate(kinds):
        tables = [("", common)]
        if number < len(single):
            tables.append((f"drive[{number + 1}].", single[number]))
        for key, table in tables:
            kind = _type(table.get("type", kind), f"{key}type")
        machine = MACHINES[kind]
        for key, table in tables:
            machine = _changed(machine, {k: v for k, v in table.items() if k != "type"}, key)
        machines.append(machine)
    return machines


def _type(value: object, key: str) -> str:
    if not isinstance(value, str) or value not in MACHINES:
        raise ValueError(f"{key}: expected one of {', '.join(MACHINES)}, got {value!r:.80}")
    return value


def _changed(record: R, table: Mapping[str, Any], key: str) -> R:
    """Return a copy of a dataclass with what a table says."""
    assert is_dataclass(record)
    assert not isinstance(record, type)
    hints = get_type_hints(type(record))
    known = [field.name for field in fields(record)]
    values: dict[str, Any] = {}
    for name, value in table.items():
        if name not in known:
            there = ", ".join(known)
            near = did_you_mean(name, known)
            raise ValueError(f"{key}{name}: no such key, there are {there}{near}")
        inner = getattr(record, name)
        if is_dataclass(inner):
            if not isinstance(value, dict):
                raise ValueError(f"{key}{name}: expected a table, got {value!r:.80}")
            values[name] = _changed(inner, value, f"{key}{name}.")
        else:
            values[name] = _value(hints[name], value, f"{key}{name}")
    try:
        return replace(record, **values)
    except MachineError as fault:
        raise ValueError(f"{key}{fault}") from None


def _value(hint: Any, value: object, key: str) -> Any:
    """`value` as the type of a field: numbers, words of enumerations, pairs, lists of words."""
    origin = get_origin(hint)
    if origin in (Union, types.UnionType):
        [hint] = [part for part in get_args(hint) if part is not type(None)]
        return _value(hint, value, key)
    if origin is tuple:
        parts = get_args(hint)
        if not isinstance(value, list) or (Ellipsis not in parts and len(value) != len(parts)):
            size = "a list" if Ellipsis in parts else f"a list of {len(parts)}"
            raise ValueError(f"{key}: expected {size}, got {value!r:.80}")
        pair = tuple(_value(parts[0], item, f"{key}[{n}]") for n, item in enumerate(value, 1))
        if Ellipsis not in parts and not pair[0] < pair[1]:
            raise ValueError(f"{key}: expected the smaller one first, got {value!r:.80}")
        return pair
    if isinstance(hint, type) and issubclass(hint, IntEnum):
        words = {each.name.lower(): each for each in hint}
        if not isinstance(value, str) or value.lower() not in words:
            raise ValueError(f"{key}: expected one of {', '.join(words)}, got {value!r:.80}")
        return words[value.lower()]
    wanted = {float: (int, float), int: (int,), bool: (bool,)}[hint]
    if not isinstance(value, wanted) or (hint is not bool and isinstance(value, bool)):
        name = {float: "a number", int: "a whole number", bool: "true or false"}[hint]
        raise ValueError(f"{key}: expected {name}, got {value!r:.80}")
    if hint is float and not abs(float(value)) < float("inf"):
        raise ValueError(f"{key}: expected a finite number, got {value!r}")
    return hint(value)
