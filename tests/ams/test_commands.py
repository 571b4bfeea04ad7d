"""The nine ADS commands: layouts, both directions, anything else is a DecodeError."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams import Command, DecodeError, Frame, NotificationStream
from achse.ams.commands import (
    ERROR_PADDING,
    AddNotificationRequest,
    AddNotificationResponse,
    DataResponse,
    DeleteNotificationRequest,
    EmptyRequest,
    ReadDeviceInfoResponse,
    ReadRequest,
    ReadStateResponse,
    ReadWriteRequest,
    Request,
    Response,
    ResultResponse,
    WriteControlRequest,
    WriteRequest,
    decode_request,
    decode_response,
)

u8 = st.integers(0, 0xFF)
u16 = st.integers(0, 0xFFFF)
u32 = st.integers(0, 0xFFFFFFFF)
blob = st.binary(max_size=32)
names = st.text(st.characters(codec="cp1252", exclude_characters="\0"), max_size=16)

REQUESTS: dict[Command, st.SearchStrategy[Request]] = {
    Command.READ_DEVICE_INFO: st.builds(EmptyRequest),
    Command.READ: st.builds(ReadRequest, u32, u32, u32),
    Command.WRITE: st.builds(WriteRequest, u32, u32, blob),
    Command.READ_STATE: st.builds(EmptyRequest),
    Command.WRITE_CONTROL: st.builds(WriteControlRequest, u16, u16, blob),
    Command.ADD_NOTIFICATION: st.builds(AddNotificationRequest, u32, u32, u32, u32, u32, u32),
    Command.DELETE_NOTIFICATION: st.builds(DeleteNotificationRequest, u32),
    Command.NOTIFICATION: st.just(NotificationStream(())),
    Command.READ_WRITE: st.builds(ReadWriteRequest, u32, u32, u32, blob),
}
RESPONSES: dict[Command, st.SearchStrategy[Response]] = {
    Command.READ_DEVICE_INFO: st.builds(ReadDeviceInfoResponse, u32, u8, u8, u16, names),
    Command.READ: st.builds(DataResponse, u32, blob),
    Command.WRITE: st.builds(ResultResponse, u32),
    Command.READ_STATE: st.builds(ReadStateResponse, u32, u16, u16),
    Command.WRITE_CONTROL: st.builds(ResultResponse, u32),
    Command.ADD_NOTIFICATION: st.builds(AddNotificationResponse, u32, u32),
    Command.DELETE_NOTIFICATION: st.builds(ResultResponse, u32),
    Command.READ_WRITE: st.builds(DataResponse, u32, blob),
}


def _frame(command: int, data: bytes = b"") -> Frame:
    return Frame(bytes(8), bytes(8), command, data=data)


def test_all_nine_commands_have_a_request_and_all_but_the_notification_a_response() -> None:
    assert list(REQUESTS) == list(Command) == list(range(1, 10))
    assert RESPONSES.keys() == REQUESTS.keys() - {Command.NOTIFICATION}


@pytest.mark.parametrize("command", REQUESTS)
@given(data=st.data())
def test_requests_and_back(command: Command, data: st.DataObject) -> None:
    request = data.draw(REQUESTS[command])
    assert decode_request(_frame(command, request.encode())) == request


@pytest.mark.parametrize("command", RESPONSES)
@given(data=st.data())
def test_responses_and_back(command: Command, data: st.DataObject) -> None:
    response = data.draw(RESPONSES[command])
    assert decode_response(_frame(command, response.encode())) == response


@pytest.mark.parametrize("command", REQUESTS)
@given(data=blob)
def test_arbitrary_bytes_are_a_request_or_a_decode_error(command: Command, data: bytes) -> None:
    try:
        request = decode_request(_frame(command, data))
    except DecodeError:
        return
    if command != Command.ADD_NOTIFICATION:  # its reserved bytes may hold anything
        assert request.encode() == data


@pytest.mark.parametrize("command", RESPONSES)
@given(data=blob)
def test_arbitrary_bytes_are_a_response_or_a_decode_error(command: Command, data: bytes) -> None:
    try:
        response = decode_response(_frame(command, data))
    except DecodeError:
        return
    assert response.result == int.from_bytes(data[:4], "little")


@pytest.mark.parametrize(
    ("request_", "layout"),
    [
        (ReadRequest(0xF005, 0x3B800002, 4), "05f00000 0200803b 04000000"),
        (WriteRequest(0xF006, 0, b"\x02\0\x80\x3b"), "06f00000 00000000 04000000 0200803b"),
        (ReadWriteRequest(0xF003, 0, 4, b"A.b\0"), "03f00000 00000000 04000000 04000000 412e6200"),
        (WriteControlRequest(6, 1, b"\xff"), "0600 0100 01000000 ff"),
        (DeleteNotificationRequest(0x102), "02010000"),
        (
            AddNotificationRequest(0xF005, 0x3B800002, 4, 4, 0, 10_000),
            "05f00000 0200803b 04000000 04000000 00000000 10270000" + "00" * 16,
        ),
    ],
)
def test_request_layouts(request_: Request, layout: str) -> None:
    assert request_.encode() == bytes.fromhex(layout)


@pytest.mark.parametrize(
    ("response", "layout"),
    [
        (DataResponse(0, b"\xaf\x27"), "00000000 02000000 af27"),
        (ResultResponse(0x704), "04070000"),
        (ReadStateResponse(0, 5, 1), "00000000 0500 0100"),
        (AddNotificationResponse(0, 26), "00000000 1a000000"),
        (
            ReadDeviceInfoResponse(0, 3, 1, 4024, "TwinCAT System"),
            "00000000 03 01 b80f 5477696e4341542053797374656d 0000",
        ),
    ],
)
def test_response_layouts(response: Response, layout: str) -> None:
    assert response.encode() == bytes.fromhex(layout)


@pytest.mark.parametrize("command", RESPONSES)
def test_an_error_response_has_its_full_length(command: Command) -> None:
    full = {1: 24, 2: 8, 3: 4, 4: 8, 5: 4, 6: 8, 7: 4, 9: 8}
    data = b"\x01\x07\0\0" + ERROR_PADDING[command]
    assert len(data) == full[command]
    response = decode_response(_frame(command, data))
    assert response.result == 0x701
    assert response.encode() == data


@pytest.mark.parametrize("command", RESPONSES)
def test_a_short_error_response_is_taken(command: Command) -> None:
    """Some TwinCAT 2 devices leave out what follows the result."""
    response = decode_response(_frame(command, b"\x01\x07\0\0"))
    assert response.result == 0x701
    assert response.encode() == b"\x01\x07\0\0" + ERROR_PADDING[command]


def test_a_short_success_is_an_error() -> None:
    with pytest.raises(DecodeError, match="at least 8 bytes, got 4"):
        decode_response(_frame(Command.READ, bytes(4)))


def test_the_reserved_bytes_of_add_notification_are_ignored() -> None:
    request = AddNotificationRequest(0xF005, 1, 4, 4, 0, 10_000)
    data = request.encode()[:24] + bytes(range(16))
    assert AddNotificationRequest.decode(data) == request


def test_huge_read_lengths_are_only_numbers() -> None:
    assert ReadRequest.decode(b"\xff" * 12).length == 0xFFFFFFFF


@pytest.mark.parametrize("command", [3, 5, 9])
@pytest.mark.parametrize("length", [0, 3, 5, 0xFFFF, 0xFFFFFFFF])
def test_a_write_length_other_than_the_data_is_an_error(command: int, length: int) -> None:
    before = {3: 8, 5: 4, 9: 12}[command]
    data = bytes(before) + length.to_bytes(4, "little") + b"four"
    with pytest.raises(DecodeError, match=f"with {length} bytes of data"):
        decode_request(_frame(command, data))


@pytest.mark.parametrize("command", [0, 10, 0xFFFF])
def test_unknown_commands_are_errors(command: int) -> None:
    with pytest.raises(DecodeError, match=r"not one of 1\.\.9"):
        decode_request(_frame(command))
    with pytest.raises(DecodeError, match="has no response"):
        decode_response(_frame(command))


def test_a_notification_has_no_response() -> None:
    with pytest.raises(DecodeError, match="has no response"):
        decode_response(_frame(Command.NOTIFICATION))


@pytest.mark.parametrize(
    ("name", "arrives"),
    [("x" * 40, "x" * 16), ("Größe", "Größe"), ("轴", "?"), ("a\0b", "a")],
)
def test_device_names_are_cut_and_made_cp1252(name: str, arrives: str) -> None:
    data = ReadDeviceInfoResponse(0, 1, 2, 3, name).encode()
    assert len(data) == 24
    assert ReadDeviceInfoResponse.decode(data).name == arrives
