"""Types of all forms and the bytes of their values, for tests that write and read values."""

from typing import Any

from hypothesis import strategies as st

from achse.iec.arrays import ArrayType, Bounds
from achse.iec.elementary import BOOL, DINT, LREAL, REAL, USINT
from achse.iec.strings import StringType
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.iec.variables import Variable

SCALARS: st.SearchStrategy[IecType[Any]] = st.sampled_from(
    [BOOL, DINT, LREAL, REAL, USINT, StringType(9)]
)
TYPES: st.SearchStrategy[IecType[Any]] = st.recursive(
    SCALARS,
    lambda inner: st.one_of(
        st.builds(lambda one: ArrayType(one, [Bounds(1, 2), Bounds(0, 1)]), inner),
        st.builds(
            lambda parts: StructType(
                "ST", [Variable(type, name=f"m{place}") for place, type in enumerate(parts)]
            ),
            st.lists(inner, min_size=1, max_size=3),
        ),
    ),
    max_leaves=6,
)


def value_bytes(type: IecType[Any], data: st.DataObject, *, finite: bool = False) -> bytes:
    """Return the bytes of some value. `finite`: JSON has no number for the others."""
    if isinstance(type, ArrayType):
        return b"".join(value_bytes(type.element, data, finite=finite) for _ in range(type.count))
    if isinstance(type, StructType):
        whole = bytearray(type.size)
        for member in type.members:
            part = value_bytes(member.type, data, finite=finite)
            whole[member.offset : member.offset + len(part)] = part
        return bytes(whole)
    if type is BOOL:
        return type.encode(data.draw(st.booleans()))
    if type in (LREAL, REAL):
        width = 64 if type is LREAL else 32
        numbers = st.floats(allow_nan=False, allow_infinity=not finite, width=width)  # type: ignore[arg-type]
        return type.encode(data.draw(numbers))
    if isinstance(type, StringType):
        signs = st.characters(min_codepoint=32, max_codepoint=126)
        return type.encode(data.draw(st.text(signs, max_size=9)).strip())
    low, high = (0, 255) if type is USINT else (-(2**31), 2**31 - 1)
    return type.encode(data.draw(st.integers(low, high)))
