"""A drive is reached through a segment, frame by frame."""

import pytest

from achse.codes import AbortCode, AlState, SdoAbort
from achse.drive import Drive
from achse.drive.identity import VENDOR
from achse.ethercat import Loopback, Segment, Slave
from achse.testing import ReachError, SegmentReach


@pytest.fixture
def reach() -> SegmentReach:
    return SegmentReach(Segment([Slave(Loopback()), Slave(Drive())]), 1)


def test_states_objects_and_process_data(reach: SegmentReach) -> None:
    assert reach.request(AlState.PREOP) == (AlState.PREOP, 0)
    assert reach.read(0x1018, 1) == VENDOR.to_bytes(4, "little")
    reach.write(0x6085, 0, (4711).to_bytes(4, "little"))
    assert reach.read(0x6085) == (4711).to_bytes(4, "little")
    with pytest.raises(SdoAbort) as refusal:
        reach.read(0x5000)
    assert refusal.value.code is AbortCode.NO_OBJECT
    assert reach.request(AlState.SAFEOP) == (AlState.SAFEOP, 0)
    assert len(reach.exchange(bytes(15))) == 23
    assert reach.request(AlState.OP) == (AlState.OP, 0)
    reach.exchange(b"\x06".ljust(15, b"\0"))
    reach.exchange(b"\x06".ljust(15, b"\0"))
    assert reach.exchange(b"\x06".ljust(15, b"\0"))[2] & 0x6F == 0x21


def test_texts_of_any_length_within_a_mailbox() -> None:
    reach = SegmentReach(Segment([Slave(Loopback())]))
    reach.request(AlState.PREOP)
    reach.write(0x2000, 0, b"a longer text")
    assert reach.read(0x2000) == b"a longer text"


def test_a_slave_that_does_not_answer_is_reported(reach: SegmentReach) -> None:
    reach.request(AlState.PREOP)
    reach.segment.slaves[1].mailbox_delay_ns = 10**10
    with pytest.raises(ReachError, match="answer"):
        reach.read(0x1000)


def test_a_lost_frame_is_reported(reach: SegmentReach) -> None:
    reach.segment.break_link(reach.segment.slaves[0])
    with pytest.raises(ReachError, match="lost"):
        reach.request(AlState.PREOP)
