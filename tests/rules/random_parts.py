"""What random projects have besides plain variables: structures, durations, properties,
interfaces."""

from functools import partial
from random import Random
from typing import Any

from tests.rules.oracle import INTEGERS, Action, Cell, Env, Place, Value, converted, literal, wrap
from tests.rules.random_programs import Scope

DURATIONS = {"TIME": ("UDINT", "ms"), "LTIME": ("ULINT", "ns")}
"""The number that a duration is, and of what."""

Field = tuple[str, str, Any]


def structure(name: str, fields: list[Field]) -> str:
    """A type of these members, with their initial values."""
    members = "\n".join(
        f"    {field} : {type} := {literal(value, type)};" for field, type, value in fields
    )
    return f"TYPE {name} : STRUCT\n{members}\nEND_STRUCT\nEND_TYPE"


def structures(rng: Random, name: str, type: str, fields: list[Field], scope: Scope) -> Any:
    """A variable of a structure, or an array of them: its value; members join the scope.

    Gives the declaration and the value.
    """
    count = rng.choice([0, 0, 1, 3])
    values: list[Env] = [
        {field: Cell(value) for field, _, value in fields} for _ in range(max(count, 1))
    ]
    for number, cells in enumerate(values):
        path = f"{name}[{number}]" if count else name
        for field, kind, _ in fields:
            scope.add(Place(f"{path}.{field}", kind, partial(_cell, cells, field)))
    if not count:
        return f"    {name} : {type};", values[0]
    return f"    {name} : ARRAY [0..{count - 1}] OF {type};", values


def _cell(cells: Env, field: str, env: Env) -> Cell:
    cell: Cell = cells[field]
    return cell


def duration(rng: Random, name: str, type: str, env: Env, scope: Scope) -> str:
    """A variable of TIME or LTIME; what is done with it joins the scope. Gives its declaration."""
    number, unit = DURATIONS[type]
    start = rng.choice([0, 1, 500, 86_400_000, (1 << 32) - 1])
    cell = env[name] = Cell(start)

    def moved(of: Scope) -> Action:
        by, adds = of.rng.choice([0, 1, 1500, (1 << 32) - 1]), of.rng.random() < 0.5
        sign = "+" if adds else "-"

        def run(env: Env) -> None:
            cell.v = wrap(cell.v + by if adds else cell.v - by, number)

        prefix = "T" if type == "TIME" else "LTIME"
        return Action(f"{name} := {name} {sign} {prefix}#{by}{unit};", run)

    def taken(of: Scope) -> Action:
        place = of.any_place(*INTEGERS)
        assert place is not None

        def run(env: Env) -> None:
            place.cell(env).v = wrap(cell.v, place.type)

        return Action(f"{place.text} := TO_{place.type}({name});", run)

    def compared(of: Scope) -> Action:
        place, with_what = of.any_place("BOOL"), of.rng.choice([0, 1500, 86_400_000])
        if place is None:
            return taken(of)

        def run(env: Env) -> None:
            place.cell(env).v = cell.v > with_what

        prefix = "T" if type == "TIME" else "LTIME"
        return Action(f"{place.text} := {name} > {prefix}#{with_what}{unit};", run)

    scope.calls += [moved, taken, compared]
    prefix = "T" if type == "TIME" else "LTIME"
    return f"    {name} : {type} := {prefix}#{start}{unit};"


def property_text(name: str, field: str, type: str) -> str:
    """A property that is a variable of the block."""
    return (
        f"PROPERTY {name} : {type}\nGET\n{name} := {field};\nEND_GET\n"
        f"SET\n{field} := {name};\nEND_SET\nEND_PROPERTY\n"
    )


def property_access(path: str, instance: str, field: str, type: str, scope: Scope) -> Action:
    """A property is read into a number, or written."""
    if scope.rng.random() < 0.5:
        place = scope.any_place(*INTEGERS)
        assert place is not None

        def read(env: Env) -> None:
            place.cell(env).v = converted(env[instance][field].v, type, place.type)

        return Action(f"{place.text} := {path};", read)
    value: Value = scope.argument(type, 2)

    def write(env: Env) -> None:
        result = converted(value.run(env), value.type, type)
        env[instance][field].v = result

    return Action(f"{path} := {value.text};", write)
