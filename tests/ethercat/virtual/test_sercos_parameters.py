"""SoE of a slave: IDNs of start commands and PDOs, their elements, refusals."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import AlState
from achse.ethercat.mailbox import MailboxError
from achse.ethercat.master.esi_reader import EsiError, read_esi
from achse.ethercat.master.soe_client import SoeClient, SoeElement, SoeRefusal
from achse.ethercat.virtual import make_slave
from achse.ethercat.virtual.sercos_parameters import SercosParameters
from tests.ethercat.virtual.conftest import CYCLE_NS, Served
from tests.ethercat.virtual.esi_text import INPUTS, MAILBOX, OUTPUTS, device, esi, pdo

DRIVE = (
    OUTPUTS
    + INPUTS
    + pdo("RxPdo", 24, [(134, 0, 16, "Control", "UINT"), (36, 0, 32, "Velocity", "DINT")], Sm=2)
    + pdo("TxPdo", 16, [(135, 0, 16, "Status", "UINT"), (51, 0, 32, "Position", "REAL")], Sm=3)
)


def commands(rows: list[tuple[int, int, bytes]], channels: int = 2) -> str:
    """SoE with start commands: drive, IDN, data."""
    inner = "".join(
        f'<InitCmd Chn="{drive}"><Transition>PS</Transition><IDN>{idn}</IDN>'
        f"<Data>{data.hex()}</Data></InitCmd>"
        for drive, idn, data in rows
    )
    return f'<SoE ChannelCount="{channels}">{inner}</SoE>'


@settings(max_examples=15, deadline=None)
@given(
    drive=st.integers(0, 1),
    idn=st.integers(1, 0xFFFF).filter(lambda idn: idn not in (16, 24, 36, 51, 134, 135)),
    data=st.binary(min_size=1, max_size=600),
)
def test_start_command_s_parameter_is_written_and_read(drive: int, idn: int, data: bytes) -> None:
    ours = Served(commands([(drive, idn, bytes(len(data)))]), more=DRIVE)
    soe = SoeClient(ours.seen.mailbox)
    assert ours.do(soe.read(idn, SoeElement.VALUE, drive)) == bytes(len(data))
    ours.do(soe.write(idn, data, SoeElement.VALUE, drive))
    assert ours.do(soe.read(idn, SoeElement.VALUE, drive)) == data
    assert ours.device.messages.parameters is not None
    assert ours.device.messages.parameters.value(idn, drive) == data
    for other, value, number in (
        (1 - drive, data, 0x1001),
        (7, data, 0x1001),
        (drive, data + b"x", 0x7003),
        (drive, data[1:], 0x7002),
    ):
        with pytest.raises(SoeRefusal, match=f"0x{number:04X}"):
            ours.do(soe.write(idn, value, SoeElement.VALUE, other))


def test_mapped_parameters_describe_themselves() -> None:
    ours = Served("<SoE/>", more=DRIVE)
    soe = SoeClient(ours.seen.mailbox)
    assert ours.do(soe.read(36, SoeElement.NAME)) == b"\x08\0\x08\0Velocity"
    attributes = [
        int.from_bytes(ours.do(soe.read(idn, SoeElement.ATTRIBUTE)), "little")
        for idn in (134, 36, 51, 24)
    ]
    assert [each >> 16 & 3 for each in attributes] == [1, 2, 2, 1]
    assert [each >> 18 & 1 for each in attributes] == [0, 0, 0, 1]
    assert [each >> 20 & 7 for each in attributes] == [1, 2, 6, 5]
    lists = [ours.do(soe.read(idn)) for idn in (24, 16)]
    assert lists == [b"\2\0\2\0\x24\0", b"\2\0\2\0\x33\0"], "without what is always mapped"
    both = SoeElement.STATUS | SoeElement.VALUE
    assert ours.do(soe.read(36, both)) == bytes(6)
    for element, number in (
        (SoeElement.UNIT, 0x4001), (SoeElement.MINIMUM, 0x5001), (SoeElement.MAXIMUM, 0x6001),
    ):  # fmt: skip
        with pytest.raises(SoeRefusal, match=f"S-0-0036: SERCOS error 0x{number:04X}"):
            ours.do(soe.read(36, element))
    for idn, element, number in (
        (36, SoeElement.NAME, 0x2004),
        (36, SoeElement.UNIT, 0x4004),
        (24, SoeElement.VALUE, 0x7008),
    ):
        with pytest.raises(SoeRefusal, match=f"0x{number:04X}"):
            ours.do(soe.write(idn, b"\0\0\0\0", element))


START = (
    '<SoE ChannelCount="2">'
    '<InitCmd Chn="1"><Transition>PS</Transition><IDN>32</IDN><Data>0b00</Data></InitCmd>'
    "<InitCmd><Transition>PS</Transition><Transition>SO</Transition><IDN>#x8001</IDN>"
    "<Data>010203</Data></InitCmd>"
    "<InitCmd><Transition>PS</Transition><IDN>1</IDN>"
    '<Data AdaptAutomatically="1">d007</Data></InitCmd>'
    "<InitCmd><Transition>PS</Transition><IDN>24</IDN>"
    '<Data AdaptAutomatically="true">00000000</Data></InitCmd>'
    "<InitCmd><Transition>PS</Transition><IDN>16</IDN><Data>020002003300</Data></InitCmd></SoE>"
)


def test_master_writes_the_start_commands_at_their_transitions() -> None:
    ours = Served(START, more=DRIVE)
    soe = SoeClient(ours.seen.mailbox)
    parameters = ours.device.messages.parameters
    assert parameters is not None

    def go(state: AlState) -> None:
        ours.master.request(state)
        ours.until(lambda: ours.seen.state == state)

    for idn, drive, size in ((32, 1, 2), (0x8001, 0, 3), (1, 0, 2)):
        ours.do(soe.write(idn, bytes(size), drive=drive))
    go(AlState.SAFEOP)
    assert parameters.value(32, 1) == b"\x0b\0"
    assert parameters.value(0x8001) == b"\1\2\3"
    assert parameters.value(1) == (CYCLE_NS // 1000).to_bytes(2, "little")
    ours.do(soe.write(32, bytes(2), drive=1))
    ours.do(soe.write(0x8001, bytes(3)))
    go(AlState.OP)
    assert (parameters.value(32, 1), parameters.value(0x8001)) == (bytes(2), b"\1\2\3")
    assert ours.seen.last_trouble == ""


def test_a_refused_start_command_holds_the_slave() -> None:
    """A list of IDNs that the mapping of the file is not."""
    text = START.replace("020002003300", "020002003400")
    ours = Served(text, more=DRIVE)
    ours.master.request(AlState.OP)
    ours.until(lambda: ours.seen.failed_command)
    assert ours.seen.state == AlState.PREOP
    assert "S-0-0016: SERCOS error 0x7008" in ours.seen.last_trouble


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (commands([(2, 1, b"x")]), "no IDN 1 of drive 2"),
        (commands([(0, 0, b"x")]), "no IDN 0 of drive 0"),
        (commands([], 9), "expected 1 to 8, got 9"),
        ('<SoE ChannelCount="x"/>', "expected a number, got 'x'"),
    ],
)
def test_what_cannot_be_read_refuses_the_device(text: str, message: str) -> None:
    box = device(MAILBOX + f"<Mailbox>{text}</Mailbox>", name="Drive")
    with pytest.raises(EsiError, match=f"Drive: .*{message}"):
        make_slave(read_esi(esi(box))[0])


@given(st.lists(st.binary(max_size=120), max_size=6))
def test_any_message_has_an_answer_or_an_error(messages: list[bytes]) -> None:
    box = read_esi(esi(device(MAILBOX + DRIVE + "<Mailbox><SoE/></Mailbox>")))[0]
    drives = SercosParameters(box, 122)
    for data in messages:
        outcome = drives.answer(data)
        assert isinstance(outcome, int) or all(len(each) <= 122 for each in outcome)
    drives.open(122)
    endless = (b"\x0b\x40" + left.to_bytes(2, "little") + bytes(118) for left in range(900, 0, -1))
    assert MailboxError.NO_MEMORY in [drives.answer(each) for each in endless]


@given(st.data())
def test_fragments_of_two_writes_are_never_joined(drawn: st.DataObject) -> None:
    """Two writes in fragments, mixed at random: a value is one that was sent whole, or none."""
    box = read_esi(esi(device(MAILBOX + f"<Mailbox>{commands(_LONG)}</Mailbox>")))[0]
    drives = SercosParameters(box, 122)
    places = drawn.draw(st.permutations(_LONG))[:2]
    values = [bytes([n + 1]) * 300 for n in range(2)]
    queues = [fragments(*place[:2], value) for place, value in zip(places, values, strict=True)]
    order = drawn.draw(st.permutations([0] * 4 + [1] * 4))
    outcomes = [drives.answer(queues[n].pop(0)) for n in order]
    mixed = order not in ([0] * 4 + [1] * 4, [1] * 4 + [0] * 4)
    for (drive, idn, _), value in zip(places, values, strict=True):
        assert drives.value(idn, drive) in (value, bytes(300))
    assert mixed == any(each[0] & 0x10 for outcome in outcomes for each in outcome)  # type: ignore[union-attr]  # never an int here
    whole = fragments(0, 40, b"x" * 300)
    drives.answer(whole[0])
    assert drives.answer(b"\x01\x40\x28\0"), "a read ends what is pending"
    assert [drives.answer(each) for each in whole] == [(), (), (), (b"\x04\x40\x28\0",)]
    assert drives.value(40) == b"x" * 300


_LONG = [(0, 40, bytes(300)), (0, 41, bytes(300)), (1, 40, bytes(300))]
REFUSED = (b"\x14\x40\x03\0\x08\x70",)


def fragments(drive: int, idn: int, value: bytes) -> list[bytes]:
    """A write in messages with 80 bytes of the value each."""
    parts = [value[at : at + 80] for at in range(0, len(value), 80)]
    heads = [
        (3 | drive << 5 | 8 * bool(left), left or idn) for left in range(len(parts) - 1, -1, -1)
    ]
    return [
        bytes([flags, 0x40]) + number.to_bytes(2, "little") + part
        for (flags, number), part in zip(heads, parts, strict=True)
    ]


def test_a_fragment_of_another_write_ends_the_pending_one() -> None:
    box = read_esi(esi(device(MAILBOX + f"<Mailbox>{commands(_LONG)}</Mailbox>")))[0]
    drives = SercosParameters(box, 122)
    first, other = fragments(0, 40, b"a" * 300), fragments(0, 41, b"b" * 300)
    assert drives.answer(first[0]) == ()
    assert drives.answer(other[0]) == REFUSED
    assert drives.answer(other[-1]) == (b"\x14\x40\x29\0\x02\x70",), "too short by itself"
    assert drives.value(40) == drives.value(41) == bytes(300)
