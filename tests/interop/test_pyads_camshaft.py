"""pyads sets cams of the demo station at port 900 and sees their outputs while axis C turns."""

import struct
import threading
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import pytest

from tests.interop.waiting import until

pyads = pytest.importorskip("pyads", exc_type=Exception)  # type: ignore[arg-type]

AXIS = 3
CONTROLLER, CAM, OUTPUTS = 0x1000, 0x1100, 0xF030
ANGLE, RATE, CAMS = 1, 2, 16
"""Words of the output image."""
STATUS = 104
"""Byte of the status word in the online structure of an axis (256 bytes)."""
WORDS = struct.Struct("<17I")
WAY, TIME = 1, 2


def write_cam(camshaft: Any, number: int, kind: int, **values: int) -> None:
    """The complete set of a cam: the way to give it a type."""
    flags = [kind, 1, 1, values.get("dynamic", 0), 0, 0, 0, 0]
    numbers = [values.get(name, 0) for name in ("start", "end", "track", "dead_time")]
    numbers += [1, 0, values.get("duration", 1), 0, 2]
    data = struct.pack("<8B9I", *flags, *numbers)
    camshaft.write(CAM + number, 0, list(data), pyads.PLCTYPE_BYTE * len(data))


def turn(nc: Any, degrees: float, velocity: float) -> None:
    """Enable axis C and let it go."""
    nc.write(0x4300 + AXIS, 0x01, 0b111, pyads.PLCTYPE_UDINT)
    nc.write(0x4300 + AXIS, 0x21, 1_000_000, pyads.PLCTYPE_UDINT)
    until(lambda: nc.read(0x4100 + AXIS, 0, pyads.PLCTYPE_BYTE * 256)[STATUS] & 1)  # enabled
    start = struct.pack("<IIdd", 1, 0, degrees, velocity)
    nc.write(0x4200 + AXIS, 0x20, list(start), pyads.PLCTYPE_BYTE * len(start))


def test_outputs_follow_the_axis(station: Any, pyads_connection: Callable[..., Any]) -> None:
    """Two turns at 360°/s: a way cam in the very cycle, a cam with lead earlier, a time cam for its
    time; a client that sends nonsense beside it changes nothing."""
    camshaft, nc = pyads_connection(station, 900), pyads_connection(station, 501)
    write_cam(camshaft, 1, WAY, start=90, end=180, track=0)
    write_cam(camshaft, 2, WAY, start=90, end=180, track=1, dynamic=1, dead_time=200)
    write_cam(camshaft, 3, TIME, start=270, track=31, duration=1000)
    assert camshaft.read(CONTROLLER, 1, pyads.PLCTYPE_UDINT) == 3
    assert camshaft.read_by_name("Press.Cam1.end", pyads.PLCTYPE_UDINT) == 180
    with pytest.raises(pyads.ADSError, match="1803"):
        camshaft.write_by_name("Press.Cam1.end", 360, pyads.PLCTYPE_UDINT)

    images: list[tuple[int, ...]] = []

    def note(notification: Any, _: Any) -> None:
        images.append(WORDS.unpack(camshaft.parse_notification(notification, None, True)[2]))

    attributes = pyads.NotificationAttrib(
        WORDS.size, pyads.ADSTRANS_SERVERCYCLE, max_delay=0, cycle_time=2
    )
    handles = camshaft.add_device_notification((OUTPUTS, 0), attributes, note)
    over = threading.Event()
    hostile = pyads_connection(station, 900)

    def flood() -> None:
        turn_number = 0
        while not over.is_set():
            turn_number += 1
            group = (CONTROLLER, CAM + 1, CAM + 200, OUTPUTS, 0xF020, 0x3000)[turn_number % 6]
            try:
                hostile.write(group, 0x7777 + turn_number, list(range(61)), pyads.PLCTYPE_BYTE * 61)
            except pyads.ADSError:
                continue
            raise AssertionError("nonsense was taken")

    beside = threading.Thread(target=flood)
    beside.start()
    try:
        turn(nc, 800.0, 360.0)
        until(lambda: images and images[-1][ANGLE] == 800 and not images[-1][RATE])
    finally:
        over.set()
        beside.join()
        camshaft.del_device_notification(*handles)
    for image in images:
        assert image[CAMS] & 1 == (900 <= image[ANGLE] < 1800)
    rises: dict[int, list[int]] = {0: [], 1: [], 31: []}
    steps = {31: 0}
    for before, after in pairwise(images):
        for track, angles in rises.items():
            if after[CAMS] & ~before[CAMS] & 1 << track:
                angles.append(after[ANGLE])
        steps[31] += after[CAMS] >> 31
    full = [angle for angle in rises[1] if angle < 1000]
    assert len(rises[0]) == 2
    assert all(900 <= angle <= 910 for angle in rises[0])
    # 20 ms at 360°/s are 7.2°, in the first turn at whatever the speed was
    assert len(full) == 2
    assert abs(full[-1] - (900 - 72)) <= 15
    assert all(2700 <= angle <= 2710 for angle in rises[31])
    assert steps[31] == 50 * len(rises[31]) == 100
