"""AoE by ADS: slaves with a NetId of their own, and what they ask the station."""

import struct
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import AmsAddress, Command, Frame, NetId
from achse.codes import AlState
from achse.devices.io.slave_net import SlaveNet
from tests.devices.io.conftest import STATION, IoBus, Refused
from tests.ethercat.master.messaging import AOE, Messenger

SLAVE = NetId("10.1.2.3.2.3")
"""Of the second place, behind the drive."""
BOX = 1002


def reading(length: int = 100, offset: int = 0x2000_0000) -> bytes:
    return struct.pack("<III", 0xF302, offset, length)


def net_of(io: IoBus) -> SlaveNet:
    (net,) = io.attached._buses[0]._slave_nets
    return net


@settings(max_examples=10, deadline=None)
@given(st.integers(0x1000, 0x10FF), st.binary(max_size=190), st.sampled_from([2, 4, 8]))
def test_any_port_of_a_slave_is_queried_in_its_mailbox(port: int, value: bytes, state: int) -> None:
    io = IoBus(1, Messenger).up(AlState(state))
    body = struct.pack("<III", 0xF302, 0x2000_0000, len(value)) + value
    assert io.ask(port, Command.WRITE, body, SLAVE) == b""
    assert io.ask(port, Command.READ, reading(), SLAVE)[4:] == value
    with pytest.raises(Refused, match="0x703"):
        io.ask(port, Command.READ, reading(offset=1), SLAVE)


def test_clients_find_the_net_id_and_others_have_none() -> None:
    io = IoBus(1, Messenger)
    for station, net_id in ((1001, "10.1.2.3.2.1"), (BOX, str(SLAVE))):
        message = io.read_write(300, 0x5001, 8, 6, station.to_bytes(2, "little"))
        assert NetId(message) == NetId(net_id)
    with pytest.raises(Refused, match=r"0x7$"):
        io.ask(0x1000, Command.READ, reading(), NetId("10.1.2.3.2.2"))


def test_refusals() -> None:
    io = IoBus(1, Messenger)
    with pytest.raises(Refused, match="0x712"):  # not in PreOp yet
        io.ask(0x1000, Command.READ, reading(), SLAVE)
    io.up(AlState.PREOP)
    with pytest.raises(Refused, match="0x705"):
        io.ask(0x1000, Command.WRITE, bytes(230), SLAVE)
    services = io.segment.slaves[1]._mailbox._services
    services[AOE] = lambda data: ()
    with pytest.raises(Refused, match="0x719"):
        io.ask(0x1000, Command.READ, reading(), SLAVE)
    services[AOE] = lambda data: 4  # service not supported
    with pytest.raises(Refused, match="0x701"):
        io.ask(0x1000, Command.READ, reading(), SLAVE)
    io.attached.close()
    with pytest.raises(Refused, match=r"0x7$"):
        io.ask(0x1000, Command.READ, reading(), SLAVE)


def test_a_late_answer_is_not_taken_for_another_request() -> None:
    io = IoBus(1, Messenger).up(AlState.PREOP)
    device: Any = io.line[0]
    late: list[bytes] = []
    services = io.segment.slaves[1]._mailbox._services

    def silent(data: bytes) -> tuple[bytes, ...]:
        late.extend(device.ads(data))
        return ()

    services[AOE] = silent
    with pytest.raises(Refused, match="0x719"):
        io.ask(0x1000, Command.READ, reading(), SLAVE)
    device.value = b"new"

    def answers(data: bytes) -> list[bytes]:
        return [*late, *device.ads(data)]  # the old one first: the client's invoke id is the same

    services[AOE] = answers
    assert io.ask(0x1000, Command.READ, reading(), SLAVE)[4:] == b"new"


@settings(max_examples=20, deadline=None)
@given(
    st.sampled_from([SLAVE, STATION, NetId("1.2.3.4.5.6")]),
    st.sampled_from([STATION, NetId("127.0.0.1.1.1"), NetId("10.9.9.9.1.1"), SLAVE]),
    st.integers(0, 0xFFFF),
    st.sampled_from([4, 5]),
    st.binary(max_size=40),
)
def test_a_slave_queries_devices_of_the_station_in_its_own_name_alone(
    source: NetId, target: NetId, port: int, flags: int, body: bytes
) -> None:
    """All parameters drawn. The answer to a request is sent back to the slave."""
    io = IoBus(1, Messenger).up(AlState.PREOP)
    device: Any = io.line[0]
    frame = Frame(
        AmsAddress.of(target, port), AmsAddress.of(source, 0x1000), Command.READ, flags, 0, 9, body
    )
    device.outbox.append((AOE, frame.encode()))
    io.run(200)
    right = source == SLAVE and io.router.is_local(target) and flags == 4
    assert net_of(io).dropped == (not right)
    assert len(device.messages) == right
    if right:
        answer = Frame.decode(device.messages[0])
        assert (answer.target, answer.invoke_id) == (frame.source, 9)


def test_a_slave_reads_the_number_of_buses() -> None:
    io = IoBus(1, Messenger).up(AlState.PREOP)
    device: Any = io.line[0]
    body = struct.pack("<III", 0x5000, 2, 4)
    source, target = AmsAddress.of(SLAVE, 0x1001), AmsAddress.of(STATION, 300)
    device.outbox.append((AOE, Frame(target, source, Command.READ, 4, 0, 9, body).encode()))
    io.run(200)
    (message,) = device.messages
    assert Frame.decode(message).data == struct.pack("<III", 0, 4, 1)
