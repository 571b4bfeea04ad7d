"""Recorded traffic of real slaves: each frame is read, and their answers replay to our master.

`ACHSE_CAPTURES` names a folder of pcapng files with EtherCAT; none are kept here. Public ones are
those of ethercrab (folders `dumps` and `tests`): a drive and terminals with TwinCAT, SOEM and it.
"""

import os
import struct
from pathlib import Path
from typing import Any

import pytest

from achse.ethercat import Segment
from achse.ethercat.frame import EthercatFrame
from achse.ethercat.master.scanning import ScannedSlave, scan_bus
from achse.ethercat.master.traffic import AcyclicTraffic, same_request
from tests.interop.ethercat.recorded import (
    Recorded,
    ethercat_frames,
    recorded,
    recorded_slave,
)

FOLDER = os.environ.get("ACHSE_CAPTURES", "")
CAPTURES = sorted(Path(FOLDER).rglob("*.pcapng")) if FOLDER else []
BACK = 0x02
MS = 1_000_000
OUTPUTS, INPUTS = 0x1C12, 0x1C13

pytestmark = [
    pytest.mark.skipif(not CAPTURES, reason="no captures here (ACHSE_CAPTURES names a folder)"),
]


@pytest.mark.parametrize("capture", CAPTURES, ids=lambda path: path.stem)
def test_each_frame_is_read_and_answers_are_known_as_such(capture: Path) -> None:
    away: dict[int, Any] = {}
    for packet in ethercat_frames(capture):
        frame = EthercatFrame.decode(packet)
        again = bytearray(frame.encode() if frame.datagrams else packet)
        again[14:16] = packet[14:16]  # some masters count more than there is
        assert packet[: len(again)] == again
        if not frame.datagrams:
            continue
        index = frame.datagrams[0].index
        if not packet[6] & BACK:
            away[index] = frame.datagrams
        elif (sent := away.pop(index, None)) is not None:
            assert len(sent) == len(frame.datagrams)
            assert all(map(same_request, sent, frame.datagrams))


def scanned(slaves: list[Recorded]) -> list[ScannedSlave]:
    """What our master finds on a segment of these slaves."""
    segment = Segment(map(recorded_slave, slaves))
    traffic = AcyclicTraffic(10 * MS)
    job = traffic.start(scan_bus())
    now = 0
    while not job.is_done:
        now += MS // 10
        assert now < 120_000 * MS
        segment.advance(now)
        for frame in traffic.frames(now, 4):
            reply = segment.process(frame)
            if reply is not None:
                traffic.receive(reply, now)
    return job.result()


def assigned(slave: Recorded, index: int) -> list[int] | None:
    """The PDOs that a slave told to be assigned; None if nobody asked for all of them."""

    def value(subindex: int) -> int | None:
        question = struct.pack("<HBHB4x", 0x2000, 0x40, index, subindex)
        answers = slave.answers.get(question, [])
        if not answers or answers[0][2] & 0xE0 != 0x40:
            return None
        return int.from_bytes(answers[0][6:8], "little")

    count = value(0)
    if count is None:
        return None
    pdos = [value(number) for number in range(1, count + 1)]
    return None if None in pdos else [each for each in pdos if each is not None]


@pytest.mark.parametrize("capture", CAPTURES, ids=lambda path: path.stem)
def test_recorded_slaves_are_scanned(capture: Path) -> None:
    slaves = recorded(ethercat_frames(capture))
    if not slaves:
        pytest.skip("no EEPROM is read in this capture")
    for slave, came in zip(slaves, scanned(slaves), strict=True):
        head = slave.image
        assert came.facts.identity[:2] == struct.unpack_from("<2I", head, 0x10)
        outputs, inputs = assigned(slave, OUTPUTS), assigned(slave, INPUTS)
        if outputs is None or inputs is None or came.trouble:
            continue  # another master asked for less than we do
        configuration = came.configuration
        assert [each.index for each in configuration.outputs] == outputs
        assert [each.index for each in configuration.inputs] == inputs
