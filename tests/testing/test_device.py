"""A device that the test writes, seen by clients."""

import struct
from collections.abc import Callable
from typing import Any

import pytest

from achse.ams import Command, DeviceError, NetId
from achse.ams.commands import ReadRequest, ReadWriteRequest
from achse.iec import LREAL, STRING, UDINT
from achse.router import Router
from achse.testing import FakeDevice, check_device


@pytest.fixture
def fake() -> FakeDevice:
    return FakeDevice({"MAIN.nCount": (UDINT, 7), "GVL.fSpeed": LREAL, "GVL.sName": STRING(20)})


@pytest.fixture
def plc(fake: FakeDevice, client_of: Any) -> Any:
    router = Router(NetId("5.1.1.1.1.1"))
    fake.attach(router, 851)
    return client_of(router, 851)


def test_variables_are_read_and_written_by_test_and_client(fake: FakeDevice, plc: Any) -> None:
    assert plc.exchange(0xF004, 0, 4, b"main.ncount\0") == struct.pack("<I", 7)
    fake["MAIN.nCount"] = 8
    assert plc.exchange(0xF004, 0, 4, b"MAIN.nCount\0") == struct.pack("<I", 8)
    (handle,) = struct.unpack("<I", plc.exchange(0xF003, 0, 4, b"GVL.sName\0"))
    plc.write(0xF005, handle, b"axis\0")
    assert fake["GVL.sName"] == "axis"
    with pytest.raises(KeyError, match="nowhere"):
        fake["GVL.nowhere"]
    with pytest.raises(ValueError, match=r"LIST\.NAME"):
        FakeDevice({"nCount": UDINT})


def test_services_are_answered_as_written_down(fake: FakeDevice, plc: Any) -> None:
    counter = iter(range(10))
    taken: list[bytes] = []
    fake.answer(0x5000, 4, b"abcd")
    fake.answer(0x5000, 8, lambda: bytes([next(counter)]))
    fake.on_write(0x5000, 4, taken.append)
    assert plc.read(0x5000, 4, 2) == b"ab"
    assert [plc.read(0x5000, 8, 1) for _ in range(3)] == [b"\0", b"\1", b"\2"]
    plc.write(0x5000, 4, b"new")
    assert plc.exchange(0x5000, 4, 4, b"both") == b"abcd"
    assert taken == [b"new", b"both"]
    with pytest.raises(DeviceError):
        plc.read(0x5000, 12, 4)


def test_requests_are_kept_decoded(fake: FakeDevice, plc: Any) -> None:
    plc.read(0x4020, 8, 4)
    plc.exchange(0xF003, 0, 4, b"MAIN.nCount\0")
    assert fake.requests == [
        ReadRequest(0x4020, 8, 4),
        ReadWriteRequest(0xF003, 0, 4, b"MAIN.nCount\0"),
    ]
    assert [frame.command for frame in fake.received] == [Command.READ, Command.READ_WRITE]


def test_misbehaviour_in_order_and_by_command(fake: FakeDevice, plc: Any, refused: Any) -> None:
    fake.misbehave("error", code=0x70A, command=Command.WRITE)
    fake.misbehave("error", 2, code=0x706)
    for _ in range(2):
        with refused(0x706):
            plc.read(0x4020, 0, 4)
    assert plc.read(0x4020, 0, 4) == bytes(4)
    with refused(0x70A):
        plc.write(0x4020, 0, b"\1")
    fake.misbehave("no_reply")
    with pytest.raises(IndexError):  # nothing came
        plc.read(0x4020, 0, 4)
    with pytest.raises(ValueError, match="kind: expected one of no_reply"):
        fake.misbehave("dance")


def test_notifications_come_at_a_tick(fake: FakeDevice, plc: Any) -> None:
    plc.subscribe(0x4020, 0, 4, cycle_s=0.02)
    plc.samples()
    fake.tick(0.01)
    assert plc.samples() == []
    fake.tick(0.01)
    assert [data for _, data in plc.samples()] == [bytes(4)]


def test_it_conforms() -> None:
    check_device(lambda: FakeDevice({"MAIN.nCount": (UDINT, 7)}))


def test_pyads_talks_to_it(fake: FakeDevice, witness: Callable[[str], None]) -> None:
    witness("pyads")
    import pyads

    with fake.serving() as live:
        plc = pyads.Connection(f"{live.host}.1.1", 851, live.host)
        with plc:
            plc.set_timeout(3_600_000)
            assert plc.read_by_name("MAIN.nCount") == 7
            plc.set_timeout(200)
            live.run(fake.misbehave, "wrong_invoke_id", command=Command.READ_STATE)
            with pytest.raises(pyads.ADSError, match="1861"):
                plc.read_state()
            plc.set_timeout(3_600_000)
            live.run(fake.misbehave, "truncate", size=2, command=Command.READ)
            with pytest.raises(RuntimeError, match="2 were read"):
                plc.read(0x4020, 0, pyads.PLCTYPE_UDINT)
