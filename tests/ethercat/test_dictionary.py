"""Dictionaries written down as data."""

import pytest

from achse.codes import AbortCode, DataType, SdoAbort
from achse.ethercat.dictionary import entry_of, number, record_object, text_object

OBJECTS = (
    text_object(0x1008, "Device name", b"press"),
    record_object(0x1018, "Identity", [number(1, "Vendor", 32, 5)]),
    record_object(0x6000, "Input", [number(0x11, "Value", 16, -2, signed=True)], 0x11),
)


def test_entries_have_type_size_and_value() -> None:
    value = entry_of(OBJECTS, 0x6000, 0x11)
    assert (value.data_type, value.bits, value.default) == (DataType.I16, 16, b"\xfe\xff")
    assert entry_of(OBJECTS, 0x1008, 0).bits == 40
    assert entry_of(OBJECTS, 0x6000, 0).default == b"\x11"
    assert OBJECTS[1].data_type == DataType.IDENTITY


@pytest.mark.parametrize(
    ("place", "abort"),
    [((0x2000, 0), AbortCode.NO_OBJECT), ((0x1018, 2), AbortCode.NO_SUBINDEX)],
)
def test_a_place_that_is_not_there_is_an_abort(place: tuple[int, int], abort: AbortCode) -> None:
    with pytest.raises(SdoAbort) as refused:
        entry_of(OBJECTS, *place)
    assert refused.value.code == abort
