"""Values in XML elements: what is written into a document is read back from it."""

from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from achse.iec.arrays import ArrayType, Bounds
from achse.iec.elementary import BOOL, DINT, LREAL, REAL, USINT
from achse.iec.strings import StringType
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.iec.variables import Variable
from achse.plc.routines.xml_documents import XmlDocuments
from achse.plc.routines.xml_symbols import SymbolElements

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


def _bytes(type: IecType[Any], data: st.DataObject) -> bytes:
    if isinstance(type, ArrayType):
        return b"".join(_bytes(type.element, data) for _ in range(type.count))
    if isinstance(type, StructType):
        whole = bytearray(type.size)
        for member in type.members:
            part = _bytes(member.type, data)
            whole[member.offset : member.offset + len(part)] = part
        return bytes(whole)
    if type is BOOL:
        return type.encode(data.draw(st.booleans()))
    if type in (LREAL, REAL):
        width = 64 if type is LREAL else 32
        return type.encode(data.draw(st.floats(allow_nan=False, width=width)))  # type: ignore[arg-type]
    if isinstance(type, StringType):
        signs = st.characters(min_codepoint=32, max_codepoint=126)
        return type.encode(data.draw(st.text(signs, max_size=9)).strip())
    low, high = (0, 255) if type is USINT else (-(2**31), 2**31 - 1)
    return type.encode(data.draw(st.integers(low, high)))


@settings(max_examples=40, deadline=None)
@given(TYPES, st.data())
def test_values_are_read_as_they_were_written(type: IecType[Any], data: st.DataObject) -> None:
    value = _bytes(type, data)
    documents = XmlDocuments()
    document = documents.start(0)
    adding = SymbolElements(documents, document, adds=True)
    spot = adding.spot("/data/value")
    assert spot is not None
    adding.write(spot, type, value)
    text = documents.text(documents.root(document), as_xml=True)
    other = documents.start(0)
    assert documents.read(other, text)
    reading = SymbolElements(documents, other, adds=False)
    found = reading.spot("/data/value")
    got = bytearray(type.size)
    assert found is not None
    assert reading.read(found, type, got)
    assert bytes(got) == value
