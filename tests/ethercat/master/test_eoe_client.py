"""EoE: frames to and from a slave, the settings of its port, slaves that do not keep to it."""

from collections.abc import Callable
from ipaddress import IPv4Address
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.codes import AlState
from achse.ethercat import Disturbance
from achse.ethercat.eoe import EoeResult, EoeType, IpSettings, MacFilter, request
from achse.ethercat.mailbox import MailboxProtocol
from achse.ethercat.master.eoe_client import EoeRefusal
from achse.ethercat.master.errors import MailboxRefusal, MailboxTimeout, WrongAnswer
from tests.ethercat.master.conftest import Bus
from tests.ethercat.master.messaging import Messenger

FRAMES = st.lists(st.binary(min_size=14, max_size=1518), max_size=4)
IP = IpSettings(b"\x02\0\0\0\0\x07", IPv4Address("10.0.0.7"), IPv4Address("255.0.0.0"), name="x")


@settings(max_examples=15, deadline=None)
@given(FRAMES, FRAMES, st.booleans(), st.lists(st.integers(0, 40), max_size=3))
def test_frames_travel_both_ways(
    out: list[bytes], back: list[bytes], split: bool, lost: list[int]
) -> None:
    """All parameters drawn; frames of the bus that are lost cost none."""
    ours = Bus(1, {}, {}, Messenger).up(AlState.PREOP)
    slave, device = ours.master.slaves[0], ours.line[0]
    assert slave.eoe is not None and slave.mailbox is not None  # noqa: PT018
    slave.mailbox.split_writes = split
    came: list[bytes] = []
    slave.eoe.take = came.append
    ours.segment.disturbance = Disturbance()
    for frame in back:
        device.send_frame(frame)  # type: ignore[attr-defined]
    jobs = [ours.master.run(slave.eoe.send(frame)) for frame in out]
    for cycle in range(4000):
        if cycle in lost:
            ours.segment.disturbance.lose = 1
        ours.run()
        if len(came) == len(back) and all(job.is_done for job in jobs):
            break
    assert came == back
    assert [job.result() for job in jobs] == [None] * len(out)
    assert device.frames == out  # type: ignore[attr-defined]
    assert slave.eoe.dropped == 0


def test_settings_are_kept_and_refused(bus: Callable[..., Any]) -> None:
    ours = bus(kind=Messenger).up(AlState.PREOP)
    eoe, device = ours.master.slaves[0].eoe, ours.line[0]
    wanted = MacFilter((bytes(range(6)),), (), False)
    ours.do(eoe.set_ip(IP))
    ours.do(eoe.set_filter(wanted))
    assert ours.do(eoe.get_ip()) == IP
    assert ours.do(eoe.get_filter()) == wanted
    device.result = EoeResult.NO_DHCP_SUPPORT
    with pytest.raises(EoeRefusal, match="addresses: 0x0202 no dhcp support") as refusal:
        ours.do(eoe.set_ip(IP))
    assert refusal.value.number == 0x0202
    with pytest.raises(EoeRefusal, match="filter: 0x0202"):
        ours.do(eoe.get_filter())
    with pytest.raises(ValueError, match="a name 32 at most"):
        eoe.set_ip(IpSettings(name="x" * 33))
    assert ours.master.slaves[0].mailbox.idle


def test_a_slave_without_a_port_says_so(bus: Callable[..., Any]) -> None:
    ours = bus().up(AlState.PREOP)
    with pytest.raises(MailboxRefusal, match="UNSUPPORTED_PROTOCOL"):
        ours.do(ours.master.slaves[0].eoe.get_ip())
    with pytest.raises(WrongAnswer, match="14 to 1518 bytes"):
        ours.do(ours.master.slaves[0].eoe.send(b"short"))


@settings(max_examples=15, deadline=None)
@given(st.lists(st.binary(max_size=60), max_size=8), st.binary(max_size=60))
def test_hostile_messages_end_in_an_error(unasked: list[bytes], answer: bytes) -> None:
    ours = Bus(1, {}, {}, Messenger).up(AlState.PREOP)
    slave, device = ours.master.slaves[0], ours.line[0]
    assert slave.eoe is not None and slave.mailbox is not None  # noqa: PT018
    services = ours.segment.slaves[0]._mailbox._services
    services[2] = lambda data: [*unasked, request(EoeType.GET_IP_ANSWER, answer)]
    device.outbox.extend((2, each) for each in unasked)  # type: ignore[attr-defined]
    try:
        got = ours.do(slave.eoe.get_ip(response_ns=50_000_000))
    except (WrongAnswer, MailboxTimeout, EoeRefusal):
        pass
    else:
        assert isinstance(got, IpSettings)
    assert slave.mailbox.idle


def test_a_slave_that_never_stops_sending_is_not_waited_for(bus: Callable[..., Any]) -> None:
    ours = bus(kind=Messenger).up(AlState.PREOP)
    device = ours.line[0]
    ours.segment.slaves[0]._mailbox._services[2] = lambda data: ()
    device.take_message = lambda: (MailboxProtocol.EOE, bytes(40))
    with pytest.raises(MailboxTimeout, match="no answer within 50 ms"):
        ours.do(ours.master.slaves[0].eoe.get_ip(response_ns=50_000_000))
