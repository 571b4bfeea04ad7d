"""Channels: names, and values as bits."""

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import DataType
from achse.ethercat.description import Pdo, PdoEntry
from achse.ethercat.virtual.channels import PdoChannel, channels_of, decode_value, encode_value

INTS = {DataType.I8: 8, DataType.U16: 16, DataType.I32: 32, DataType.U64: 64}


def channel(kind: int, bits: int) -> PdoChannel:
    return PdoChannel("C", False, 0x6000, 1, bits, kind)


@given(kind=st.sampled_from(sorted(INTS)), data=st.data())
def test_whole_numbers_come_back_and_others_are_refused(kind: DataType, data: Any) -> None:
    bits = INTS[kind]
    result = channel(kind, bits)
    signed = kind in (DataType.I8, DataType.I32)
    low = -(1 << bits - 1) if signed else 0
    high = low + (1 << bits) - 1
    value = data.draw(st.integers(low, high))
    assert decode_value(result, encode_value(result, value)) == value
    for wrong in (low - 1, high + 1, 0.5):
        with pytest.raises(ValueError, match="C: "):
            encode_value(result, wrong)


@given(value=st.floats(), long=st.booleans())
def test_reals_come_back(value: float, long: bool) -> None:
    kind = DataType.F64 if long else DataType.F32
    result = channel(kind, kind.bits)
    try:
        back = decode_value(result, encode_value(result, value))
    except ValueError:
        assert not long
        return
    assert isinstance(back, float)
    assert math.isclose(back, value, rel_tol=1e-6, abs_tol=1e-30) or math.isnan(value)


@given(value=st.booleans(), data=st.binary(max_size=3))
def test_bits_and_bytes(value: bool, data: bytes) -> None:
    assert decode_value(channel(DataType.BOOL, 1), encode_value(channel(1, 1), value)) is value
    text = channel(DataType.OCTET_STRING, 24)
    assert decode_value(text, encode_value(text, data)) == data.ljust(3, b"\0")
    with pytest.raises(ValueError, match="24 bits"):
        encode_value(text, b"1234")


def test_names_are_whole_short_and_of_the_object() -> None:
    def pdo(index: int, name: str, *entries: tuple[int, int, str]) -> Pdo:
        rows = tuple(PdoEntry(i, s, 8, n, DataType.U8) for i, s, n in entries)
        return Pdo(index, name, 3, True, rows)

    result = channels_of(
        [pdo(0x1600, "Out", (0x7000, 1, "Value"))],
        [
            pdo(0x1A00, "Channel 1", (0x6000, 1, "Input"), (0, 0, "")),
            pdo(0x1A01, "Channel 2", (0x6010, 1, "Input"), (0x6010, 2, "State"), (0x6010, 3, "")),
        ],
    )
    assert result["Channel 2.Input"].place == (0x6010, 1)
    assert result["6000:01"].name == "Channel 1.Input"
    assert result["Value"].output
    assert result["State"].place == (0x6010, 2)
    assert result["Channel 2.6010:03"].place == (0x6010, 3)
    assert "Input" not in result, "two channels have that name"
