"""AoE of a slave: objects by ADS, name, state, what it refuses."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.ams.frame import Command, Flags, Frame
from achse.codes import AbortCode, AlState, ReturnCode, SdoAbort, return_code_of
from achse.ethercat.mailbox import MailboxError
from achse.ethercat.virtual.ads_port import AdsPort
from tests.ethercat.virtual.conftest import Served
from tests.ethercat.virtual.esi_text import OUTPUTS, pdo

SLAVE, CLIENT = bytes(range(8)), bytes(range(8, 16))
MORE = OUTPUTS + pdo("RxPdo", 0x1600, [(0x7000, 1, 32, "Valve", "DINT")], Sm=2)


class Objects:
    """Objects of any length; `refusal` is what refuses all of them."""

    name = "A name that is too long for ADS"
    state = AlState.SAFEOP

    def __init__(self, refusal: AbortCode | None = None) -> None:
        self.values: dict[tuple[int, int], bytes] = {}
        self.refusal = refusal

    def read_object(self, index: int, subindex: int) -> bytes:
        if self.refusal is not None:
            raise SdoAbort(self.refusal)
        return self.values[index, subindex]

    def write_object(self, index: int, subindex: int, data: bytes) -> None:
        if self.refusal is not None:
            raise SdoAbort(self.refusal)
        self.values[index, subindex] = data


def ask(port: AdsPort, command: int, data: bytes = b"", invoke_id: int = 7) -> bytes:
    """The data of the response."""
    packet = Frame(SLAVE, CLIENT, command, invoke_id=invoke_id, data=data).encode()
    outcome = port.answer(packet)
    assert not isinstance(outcome, int)
    (reply,) = map(Frame.decode, outcome)
    assert (reply.target, reply.source, reply.invoke_id) == (CLIENT, SLAVE, invoke_id)
    assert (reply.command, reply.flags, reply.error) == (command, 0x0004 | Flags.RESPONSE, 0)
    return reply.data


def place(index: int, subindex: int, length: int, group: int = 0xF302) -> bytes:
    return struct.pack("<III", group, index << 16 | subindex, length)


@given(st.integers(0, 0xFFFF), st.integers(0, 0xFF), st.binary(max_size=200), st.integers(0, 300))
def test_written_object_is_read(index: int, subindex: int, data: bytes, length: int) -> None:
    port = AdsPort(Objects(), 200)
    assert ask(port, Command.WRITE, place(index, subindex, len(data)) + data) == bytes(4)
    outcome = ask(port, Command.READ, place(index, subindex, length))
    if len(data) <= min(length, 160):
        assert outcome == bytes(4) + len(data).to_bytes(4, "little") + data
    else:
        assert outcome == struct.pack("<II", ReturnCode.INVALID_SIZE.number, 0)


@pytest.mark.parametrize("abort", AbortCode)
def test_abort_is_a_return_code(abort: AbortCode) -> None:
    port, number = AdsPort(Objects(abort), 200), return_code_of(abort).number
    assert ask(port, Command.READ, place(1, 2, 4)) == struct.pack("<II", number, 0)
    assert ask(port, Command.WRITE, place(1, 2, 1) + b"x") == struct.pack("<I", number)


def test_name_state_and_what_is_refused() -> None:
    port = AdsPort(Objects(), 200)
    assert ask(port, Command.READ_DEVICE_INFO) == bytes(4) + b"\1\0\0\0A name that is \0"
    assert ask(port, Command.READ_STATE) == struct.pack("<IHH", 0, 6, AlState.SAFEOP)
    for command, data, number in (
        (Command.ADD_NOTIFICATION, bytes(40), 0x701),
        (Command.WRITE, place(1, 2, 1, 0x4020) + b"x", 0x702),
        (Command.WRITE, place(1, 0x100, 1) + b"x", 0x702),
        (Command.WRITE, place(1, 2, 4) + b"x", 0x705),
        (Command.WRITE, b"x", 0x705),
    ):
        assert ask(port, command, data) == number.to_bytes(4, "little")
    for data, number in ((place(1, 2, 1, 0x4020), 0x702), (b"x", 0x705)):
        assert ask(port, Command.READ, data) == struct.pack("<II", number, 0)
    response = Frame(SLAVE, CLIENT, Command.READ, 0x0004 | Flags.RESPONSE).encode()
    assert port.answer(response) == ()


@given(st.binary(max_size=80))
def test_any_message_has_an_answer_or_an_error(data: bytes) -> None:
    outcome = AdsPort(Objects(), 200).answer(data)
    assert isinstance(outcome, MailboxError) or len(list(outcome)) < 2  # type: ignore[arg-type]


def test_master_reads_and_writes_objects_of_a_slave_by_aoe() -> None:
    ours = Served('<AoE AdsRouter="true"/>', more=MORE)

    def exchange(command: int, data: bytes) -> bytes:
        packet = Frame(SLAVE, CLIENT, command, invoke_id=3, data=data).encode()
        return Frame.decode(ours.do(ours.seen.aoe.request(packet))).data

    assert exchange(Command.READ_DEVICE_INFO, b"")[8:] == b"Speaker".ljust(16, b"\0")
    assert exchange(Command.WRITE, place(0x7000, 1, 4) + b"abcd") == bytes(4)
    assert exchange(Command.READ, place(0x7000, 1, 4)) == b"\0\0\0\0\4\0\0\0abcd"
    assert exchange(Command.READ, place(0x7777, 1, 4))[:4] == b"\3\7\0\0"
