"""Values in XML elements: what is written into a document is read back from it."""

from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from achse.iec.types import IecType
from achse.plc.routines.xml_documents import XmlDocuments
from achse.plc.routines.xml_symbols import SymbolElements
from tests.plc.routines.conftest import TYPES, value_bytes


@settings(max_examples=40, deadline=None)
@given(TYPES, st.data())
def test_values_are_read_as_they_were_written(type: IecType[Any], data: st.DataObject) -> None:
    value = value_bytes(type, data)
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
    place = reading.spot("/data/value")
    got = bytearray(type.size)
    assert place is not None
    assert reading.read(place, type, got)
    assert bytes(got) == value
