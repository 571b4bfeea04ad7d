"""Settings of several faults at once, and what becomes of them after a restart."""

import struct
from typing import Any

from achse.station import Station


def test_what_stands_goes_on_after_a_restart(
    sender: Any, station: Station, client_of: Any, refused: Any
) -> None:
    station.faults.add("slow_cycle", factor=4)
    station.faults.add("error", symbol="MAIN.nCounter", code=0x706)
    station.faults.add("error", port=851, group=0x1234, code=0x70A)
    station.faults.add("truncate", symbol="GVL.nInt", size=2)
    station.restart()
    station.advance(1)
    plc = client_of(station.router, 851)
    with refused(0x706):
        plc.exchange(0xF004, 0, 4, b"MAIN.nCounter\0")
    with refused(0x70A):
        plc.read(0x1234, 0, 4)
    assert station.plcs[851].tasks[0].stretch == 4
    client = sender(station)
    place = plc.exchange(0xF007, 0, 12, b"GVL.nInt\0")[:8]
    client.read(1, *struct.unpack("<II", place))
    assert len(client.frames[0].data) == 10
    station.faults.clear()
    assert len(plc.exchange(0xF004, 0, 4, b"MAIN.nCounter\0")) == 4
    with refused(0x701):
        plc.read(0x1234, 0, 4)
    assert station.plcs[851].tasks[0].stretch == 1
