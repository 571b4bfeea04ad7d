"""Python behaviour for what is declared elsewhere: classes bound by name to programs and blocks.

    class MAIN:                            # the PROGRAM of that name
        def cycle(self) -> None:
            self.nCounter += 1
            self.fbMotor.cycle()

    class FB_Motor:                        # the FUNCTION_BLOCK, in all its instances
        def Start(self, target: float) -> bool:     # the METHOD of that name, callable by clients
            ...

The class sees the declared variables as attributes. `binds = "MAIN"` in the class names what it
is for if that is not its own name.
"""

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from typing import Any, cast

from achse.iec import DeclarationError, IecType, StructType
from achse.iec.describe import types_within
from achse.iec.structs import RecordKind, RecordMeta, StaticRecord


def with_behaviour(
    units: Iterable[type[StaticRecord]],
    behaviours: Iterable[type],
    types: Iterable[IecType[Any]] = (),
) -> list[type[StaticRecord]]:
    """Return the units, with the classes of those that `behaviours` has one for.

    Function blocks are found among `types` and in the variables of the units. Raises
    `DeclarationError` for a behaviour of nothing, or a second one of the same.
    """
    classes = list(units)
    blocks = {
        type.name.lower(): type
        for type in types_within([*(unit.__iec__ for unit in classes), *types])
        if isinstance(type, StructType) and type.kind is RecordKind.FUNCTION_BLOCK
    }
    positions = {unit.__iec__.name.lower(): index for index, unit in enumerate(classes)}
    taken: dict[str, type] = {}
    for_blocks: list[tuple[StructType[Any], type]] = []
    for behaviour in behaviours:
        name = str(getattr(behaviour, "binds", behaviour.__name__))
        key = name.lower()
        if key in taken:
            raise DeclarationError(f"{name} has two behaviours: {taken[key]!r} and {behaviour!r}")
        taken[key] = behaviour
        if key in positions:
            classes[positions[key]] = _behaving(classes[positions[key]], behaviour)
        elif key in blocks:
            for_blocks.append((blocks[key], behaviour))
        else:
            raise DeclarationError(_unknown(behaviour, name, [*positions, *blocks]))
    # A base type comes before those that extend it and inherit what it does.
    for block, behaviour in sorted(for_blocks, key=lambda pair: _depth(pair[0])):
        block.behave(behaviour)
    return classes


def _behaving(declared: type[StaticRecord], behaviour: type) -> type[StaticRecord]:
    iec = declared.__iec__
    record = RecordMeta(declared.__name__, (behaviour, declared), {}, iec=iec)
    return cast("type[StaticRecord]", record)


def _depth(type: StructType[Any]) -> int:
    return 0 if type.base is None else 1 + _depth(type.base)


def _unknown(behaviour: type, name: str, names: Sequence[str]) -> str:
    near = get_close_matches(name.lower(), names, 1)
    hint = f"; near: {near[0]}" if near else ""
    return (
        f"{behaviour.__module__}.{behaviour.__qualname__}: no program, variable list or function"
        f" block is named {name!r}{hint}"
    )
