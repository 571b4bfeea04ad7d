"""SDO: every size, complete access, refusals, information, hostile answers."""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from achse.codes import AbortCode, AlState
from achse.drive import Drive
from achse.ethercat import Segment, Slave, describe
from achse.ethercat.master import BusConfiguration, Master, Ring, from_description
from achse.ethercat.master.errors import BusError, SdoRefusal
from achse.ethercat.sdo_information import LIST_TYPES


@pytest.mark.parametrize("size", [1, 2, 3, 4, 5, 238, 239, 240, 241, 247, 486, 487, 1000, 5000])
def test_every_size_goes_and_comes(bus: Callable[..., Any], size: int) -> None:
    ours = bus().up(AlState.PREOP)
    sdo = ours.master.slaves[0].sdo
    value = bytes(number & 0xFF for number in range(size))
    ours.do(sdo.download(0x2000, 0, value))
    assert ours.line[0].text == value
    assert ours.do(sdo.upload(0x2000)) == value


def test_complete_access(bus: Callable[..., Any]) -> None:
    ours = bus().up(AlState.PREOP)
    sdo = ours.master.slaves[0].sdo
    whole = ours.do(sdo.upload(0x1018, 0, complete=True))
    assert whole[:2] == b"\x04\x00"
    assert ours.do(sdo.upload(0x1018, 1, complete=True)) == whole[2:]
    ours.do(sdo.download(0x7000, 1, b"\1\2\3\4", complete=True))
    assert ours.do(sdo.upload(0x7000, 4)) == b"\4"


@pytest.mark.parametrize(
    ("index", "subindex", "data", "code"),
    [
        (0x5FFF, 0, None, AbortCode.NO_OBJECT),
        (0x1018, 9, None, AbortCode.NO_SUBINDEX),
        (0x1000, 0, b"\0\0\0\0", AbortCode.READ_ONLY),
        (0x7000, 1, b"\0\0\0\0", AbortCode.LENGTH),
        (0x7000, 1, bytes(500), AbortCode.LENGTH),
    ],
)
def test_refusals(
    bus: Callable[..., Any], index: int, subindex: int, data: bytes | None, code: AbortCode
) -> None:
    ours = bus().up(AlState.PREOP)
    sdo = ours.master.slaves[0].sdo
    steps = sdo.upload(index, subindex) if data is None else sdo.download(index, subindex, data)
    with pytest.raises(SdoRefusal) as refusal:
        ours.do(steps)
    assert refusal.value.code is code
    assert ours.do(sdo.upload(0x1000)) == (0xC0DE_0001).to_bytes(4, "little")


def test_the_dictionary_of_the_drive_is_described_as_it_is() -> None:
    """All objects and entries, read through fragments of lists and one by one."""
    drive = Drive()
    master = Master(BusConfiguration((from_description(describe(drive)),)))
    ring = Ring(master, Segment([Slave(drive)]), rounds=40)
    master.request(AlState.PREOP)
    ring.run(500_000_000)
    sdo = master.slaves[0].sdo
    assert sdo is not None

    def do(steps: Any) -> Any:
        job = master.run(steps)
        for _ in range(200):
            if job.is_done:
                break
            ring.exchange(master.now_ns + 2_000_000)
        return job.result()

    objects = {each.index: each for each in drive.objects()}
    assert do(sdo.object_list()) == list(objects)
    assert do(sdo.object_list(0))[0] == len(objects)
    for kind, wanted in LIST_TYPES.items():
        listed = [
            index
            for index, each in objects.items()
            if not wanted or any(entry.access & wanted for entry in each.entries)
        ]
        assert do(sdo.object_list(kind)) == listed
    for index, described in list(objects.items())[::17]:
        message = do(sdo.object_information(index))
        assert (message.index, message.name, message.code) == (
            index,
            described.name,
            described.code,
        )
        for entry in described.entries:
            of_entry = do(sdo.entry_information(index, entry.subindex, 0x77))
            assert (of_entry.bits, of_entry.access) == (entry.bits, entry.access)
    with pytest.raises(SdoRefusal):
        do(sdo.object_information(0x5FFF))


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(answers=st.lists(st.binary(max_size=40), min_size=1, max_size=4), kind=st.integers(0, 3))
def test_any_answers_end_in_a_value_or_an_error(
    bus: Callable[..., Any], answers: list[bytes], kind: int
) -> None:
    """A slave that says anything at all: the request ends, and the next one works."""
    ours = bus().up(AlState.PREOP)
    slave = ours.segment.slaves[0]
    sdo = ours.master.slaves[0].sdo
    for each in answers:
        slave._mailbox.send(3, each)
    steps = (
        sdo.upload(0x2000, response_ns=20_000_000),
        sdo.download(0x2000, 0, bytes(300), response_ns=20_000_000),
        sdo.object_list(),
        sdo.entry_information(0x1018, 1),
    )[kind]
    job = ours.master.run(steps)
    ours.run()
    for each in answers:
        slave._mailbox.send(3, each)
    try:
        ours.until(lambda: job.is_done, 3000)
        job.result()
    except BusError:
        pass
    assert ours.do(sdo.upload(0x1000)) == (0xC0DE_0001).to_bytes(4, "little")
