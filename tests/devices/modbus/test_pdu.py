"""PDUs of Modbus: the examples of the specification, limits, answers that do not fit."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.devices.modbus.pdu import ModbusRefusal, Query, answer_data, request_pdu, swapped

EXAMPLES = [
    # Section of the specification, request, its PDU, PDU of the answer, what the PLC gets.
    ("6.1", Query(1, 0x13, 0x13), "01 00 13 00 13", "01 03 CD 6B 05", "CD 6B 05"),
    ("6.2", Query(2, 0xC4, 0x16), "02 00 C4 00 16", "02 03 AC DB 35", "AC DB 35"),
    ("6.3", Query(3, 0x6B, 3), "03 00 6B 00 03", "03 06 02 2B 00 00 00 64", "2B 02 00 00 64 00"),
    ("6.4", Query(4, 8, 1), "04 00 08 00 01", "04 02 00 0A", "0A 00"),
    ("6.5", Query(5, 0xAC, 0xFF00), "05 00 AC FF 00", "05 00 AC FF 00", ""),
    ("6.6", Query(6, 1, 3), "06 00 01 00 03", "06 00 01 00 03", ""),
    ("6.8", Query(8, 0, 0xA537), "08 00 00 A5 37", "08 00 00 A5 37", "37 A5"),
    (
        "6.11",
        Query(15, 0x13, 10, data=b"\xcd\x01"),
        "0F 00 13 00 0A 02 CD 01",
        "0F 00 13 00 0A",
        "",
    ),
    (
        "6.12",
        Query(16, 1, 2, data=b"\x0a\0\2\1"),
        "10 00 01 00 02 04 00 0A 01 02",
        "10 00 01 00 02",
        "",
    ),
    (
        "6.17",
        Query(23, 3, 6, 0xE, 3, bytes.fromhex("FF00FF00FF00")),
        "17 00 03 00 06 00 0E 00 03 06 00 FF 00 FF 00 FF",
        "17 0C 00 FE 0A CD 00 01 00 03 00 0D 00 FF",
        "FE 00 CD 0A 01 00 03 00 0D 00 FF 00",
    ),
]


@pytest.mark.parametrize(("section", "query", "requested", "answer", "data"), EXAMPLES)
def test_examples_of_the_specification(
    section: str, query: Query, requested: str, answer: str, data: str
) -> None:
    assert request_pdu(query) == bytes.fromhex(requested)
    assert answer_data(query, bytes.fromhex(answer)) == bytes.fromhex(data)
    assert query.size == len(bytes.fromhex(data))


@pytest.mark.parametrize(
    ("query", "code"),
    [
        *((Query(function, 0, 0), 3) for function in (1, 2, 3, 4, 15, 16, 23)),
        *((Query(function, 0, 2001), 3) for function in (1, 2, 15)),
        *((Query(function, 0, 126), 3) for function in (3, 4, 16, 23)),
        (Query(15, 0, 1969, data=bytes(256)), 3),
        (Query(16, 0, 124, data=bytes(256)), 3),
        (Query(23, 0, 125, 0, 122, bytes(256)), 3),
        (Query(23, 0, 1, 0, 0), 3),
        (Query(3, 65535, 2), 2),
        (Query(1, 65000, 600), 2),
        (Query(16, 65535, 2, data=bytes(4)), 2),
        (Query(23, 0, 1, 65535, 2, bytes(4)), 2),
        (Query(16, 0, 2, data=bytes(3)), 2),
        (Query(15, 0, 9, data=bytes(1)), 2),
        *((Query(function), 1) for function in (0, 7, 17, 24, 43, 255)),
    ],
)
def test_invalid_requests(query: Query, code: int) -> None:
    with pytest.raises(ModbusRefusal) as refusal:
        request_pdu(query)
    assert refusal.value.code == code


@given(st.sampled_from([q for _, q, *_ in EXAMPLES]), st.integers(0, 255))
def test_exceptions_of_a_device(query: Query, code: int) -> None:
    with pytest.raises(ModbusRefusal) as refusal:
        answer_data(query, bytes((query.function | 0x80, code)))
    assert refusal.value.code == code


@given(st.sampled_from([q for _, q, *_ in EXAMPLES]), st.binary(max_size=260))
def test_any_bytes_are_an_answer_or_do_not_fit(query: Query, pdu: bytes) -> None:
    code = 0
    try:
        data = answer_data(query, pdu)
    except ModbusRefusal as refusal:
        code = refusal.code
    else:
        assert len(data) == query.size
        assert pdu[0] == query.function
    assert code in (0, 4) or pdu[:1] == bytes((query.function | 0x80,))


@given(st.integers(1, 2000), st.data())
def test_bits_that_were_not_requested_are_0(quantity: int, drawn: st.DataObject) -> None:
    size = (quantity + 7) // 8
    sent = drawn.draw(st.binary(min_size=size, max_size=size))
    data = answer_data(Query(1, 0, quantity), bytes((1, size)) + sent)
    whole = int.from_bytes(sent, "little")
    assert int.from_bytes(data, "little") == whole & (1 << quantity) - 1


@given(st.lists(st.integers(0, 0xFFFF), max_size=125))
def test_registers_turn_round_and_back(registers: list[int]) -> None:
    little = b"".join(each.to_bytes(2, "little") for each in registers)
    assert swapped(little) == b"".join(each.to_bytes(2, "big") for each in registers)
    assert swapped(swapped(little)) == little
