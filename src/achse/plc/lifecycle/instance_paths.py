"""Instance paths: variables with attribute `instance-path` hold the name of their block's instance.

Source: attributes `instance-path` and `reflection` of TwinCAT 3.
"""

from collections.abc import Iterable, Iterator
from itertools import product
from typing import Any

from achse.iec import ArrayType, IecType, StructType, resolved
from achse.iec.strings import StringType
from achse.iec.structs import RecordKind
from achse.plc.memory import Memory
from achse.plc.program import PlacedVariable


def put_instance_paths(variables: Iterable[PlacedVariable], memory: Memory) -> None:
    """Write the name of each instance (`MAIN.fbAxis`) into its variables that ask for it.

    Only blocks with attribute `reflection` are looked at, as the vendor's compiler does. A name
    that is too long is cut at the end.
    """
    known: dict[int, bool] = {}
    for placed in variables:
        if _has_path(placed.variable.type, known):
            for text, offset, name in _texts(placed.variable.type, placed.name, 0, known):
                data = text.short(text.cut(name))
                memory[placed.area].write(placed.offset + offset, data)


def _is_path(member: Any) -> bool:
    names = {name.lower() for name in member.attributes}
    return "instance-path" in names and isinstance(resolved(member.type), StringType)


def _reflects(type: StructType[Any]) -> bool:
    """Return True if a block, or one that it extends, has the attribute `reflection`."""
    here: StructType[Any] | None = type
    while here is not None:
        if "reflection" in {name.lower() for name in here.attributes}:
            return True
        here = here.base
    return False


def _has_path(type: IecType[Any], known: dict[int, bool]) -> bool:
    """Return True if a variable inside a type gets an instance path."""
    real = resolved(type)
    has_path = known.get(id(real))
    if has_path is None:
        if isinstance(real, ArrayType):
            has_path = _has_path(real.element, known)
        elif isinstance(real, StructType):
            is_block = real.kind is RecordKind.FUNCTION_BLOCK and _reflects(real)
            has_path = any(
                (is_block and _is_path(member)) or _has_path(member.type, known)
                for member in real.fields
            )
        else:
            has_path = False
        known[id(real)] = has_path
    return has_path


def _texts(
    type: IecType[Any], name: str, offset: int, known: dict[int, bool]
) -> Iterator[tuple[StringType, int, str]]:
    """Return the texts for paths: type, offset and path of each."""
    real = resolved(type)
    if isinstance(real, ArrayType):
        size = real.element.size
        ranges = (range(bounds.first, bounds.last + 1) for bounds in real.dimensions)
        for number, index in enumerate(product(*ranges)):
            at = ",".join(map(str, index))
            yield from _texts(real.element, f"{name}[{at}]", offset + number * size, known)
    elif isinstance(real, StructType):
        is_block = real.kind is RecordKind.FUNCTION_BLOCK and _reflects(real)
        for member in real.fields:
            text = resolved(member.type)
            if is_block and _is_path(member):
                assert isinstance(text, StringType)
                yield text, offset + member.offset, name
            elif _has_path(member.type, known):
                yield from _texts(
                    member.type, f"{name}.{member.name}", offset + member.offset, known
                )
