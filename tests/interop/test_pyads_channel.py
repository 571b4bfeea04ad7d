"""pyads runs a part program on the demo station: documented services, nothing of ours.

Channel 1 has an interpreter and 3D group 11, which gets axes 1 and 2 as X and Y. M40 waits.
"""

import struct
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from typing import Any

import pytest

from tests.interop.waiting import until

pyads = pytest.importorskip("pyads", exc_type=Exception)  # type: ignore[arg-type]

IDLE, READY, RUNNING = 1, 2, (3, 5, 7, 9, 16)
GROUP = 11


class Channel:
    """Channel 1 as pyads reaches it."""

    def __init__(self, connection: Any) -> None:
        self.nc = connection

    def call(self, group: int, offset: int, data: bytes = b"") -> None:
        kind = pyads.PLCTYPE_BYTE * len(data) if data else None
        self.nc.write(group, offset, list(data), kind)

    def read(self, group: int, offset: int, length: int) -> bytes:
        return bytes(self.nc.read(group, offset, pyads.PLCTYPE_BYTE * length))

    @property
    def state(self) -> int:
        return int(self.nc.read(0x2101, 0x03, pyads.PLCTYPE_UDINT))

    @property
    def request(self) -> tuple[int, int]:
        number, request = struct.unpack_from("<HH", self.read(0x2301, 0x80, 160), 24)
        return number, request

    def position(self, axis: int) -> float:
        return float(self.nc.read(0x4100 + axis, 0x0A, pyads.PLCTYPE_LREAL))

    def bring(self, axis: int, position: float) -> None:
        """One axis by itself to a position, as soon as it is ready for it."""
        self.until(lambda: self._accepts_start(axis, position))
        self.until(lambda: abs(self.position(axis) - position) < 1e-6)

    def _accepts_start(self, axis: int, position: float) -> bool:
        try:
            self.call(0x4200 + axis, 0x20, struct.pack("<IIdd", 1, 0, position, 200.0))
        except pyads.ADSError:
            return False
        return True

    def accepts_axes(self) -> bool:
        """Axes 1 and 2 into the group, once they stand."""
        try:
            self.assign(1, 2, 0)
        except pyads.ADSError:
            return False
        return bool(self.nc.read(0x3100 + GROUP, 0x05, pyads.PLCTYPE_UDINT) == 1)

    def assign(self, *axes: int) -> None:
        self.call(0x3200 + GROUP, 0x50, struct.pack("<3I", *axes))

    def grant(self, level: int) -> None:
        self.call(0x2301, 0x00, struct.pack("<HHH122x", 0, 0, level))

    def until(self, condition: Callable[[], object]) -> None:
        until(condition)


@pytest.fixture(scope="module")
def station(start_station: Callable[..., AbstractContextManager[Any]]) -> Iterator[Any]:
    """The demo station, five times as fast as the clock."""
    with start_station("--speed", "5") as running:
        yield running


def make_ready(channel: Channel) -> None:
    """Two enabled axes in the group, at 0."""
    for axis in (1, 2):
        channel.call(0x4200 + axis, 0x01)
        channel.nc.write(0x4300 + axis, 0x01, 0b111, pyads.PLCTYPE_UDINT)
        channel.nc.write(0x4300 + axis, 0x21, 1_000_000, pyads.PLCTYPE_UDINT)
        channel.bring(axis, 0.0)
    channel.until(channel.accepts_axes)


@pytest.fixture
def channel(station: Any, pyads_connection: Callable[..., Any]) -> Iterator[Channel]:
    """The channel with two enabled axes at 0; given back afterwards."""
    channel = Channel(pyads_connection(station, 501))
    make_ready(channel)
    yield channel
    channel.call(0x2201, 0x10)
    channel.until(lambda: channel.state == IDLE)
    channel.call(0x3200 + GROUP, 0x53)


def test_load_start_handshake_stop_reset(channel: Channel) -> None:
    """The program of the demo ends where it began; a stopped one wants a reset and a load."""
    channel.call(0x2201, 0x04, b"plate.nc\0")
    assert channel.state == READY
    channel.call(0x2201, 0x02)
    assert channel.state in RUNNING
    channel.until(lambda: channel.request == (40, 1))
    assert channel.position(1) == pytest.approx(0.0, abs=1e-6)
    assert channel.position(2) == pytest.approx(40.0, abs=1e-6)
    fast = struct.unpack_from("<5I", channel.read(0x2301, 0x80, 160), 4)
    assert fast == (1 << 7, 0, 0, 0, 0)
    channel.grant(1)
    channel.until(lambda: channel.request[1] == 0)
    channel.grant(0)
    channel.until(lambda: channel.state == READY)
    assert channel.position(1) == pytest.approx(0.0, abs=1e-6)
    assert channel.position(2) == pytest.approx(0.0, abs=1e-6)
    assert struct.unpack_from("<5I", channel.read(0x2301, 0x80, 160), 4) == (0,) * 5
    channel.call(0x2201, 0x02)
    channel.until(lambda: channel.position(1) > 5.0 or channel.request[1])
    channel.call(0x2201, 0x11)
    channel.until(lambda: channel.state == IDLE)
    with pytest.raises(pyads.ADSError) as refused:
        channel.call(0x2201, 0x02)
    assert refused.value.err_code == 0x42C5
    channel.call(0x2201, 0x10)
    channel.until(lambda: channel.state == IDLE)
    channel.call(0x2201, 0x04, b"plate.nc\0")


def test_r_parameters_and_group_states(channel: Channel) -> None:
    channel.nc.write(0x2301, 0x1000_0005, 2.5, pyads.PLCTYPE_LREAL)
    assert channel.nc.read(0x2301, 0x1000_0005, pyads.PLCTYPE_LREAL) == 2.5
    assert struct.unpack("<3I", channel.read(0x3100 + GROUP, 0x550, 12)) == (1, 2, 0)
    assert channel.nc.read(0x4001, 0x54, pyads.PLCTYPE_UDINT) == GROUP
    with pytest.raises(pyads.ADSError) as refused:
        channel.call(0x4201, 0x20, struct.pack("<IIdd", 1, 0, 5.0, 10.0))
    assert refused.value.err_code == 0x4257


def test_a_stop_while_an_m_function_waits(channel: Channel) -> None:
    """Its request goes; the program is over, and after a reset it may be loaded again."""
    channel.call(0x2201, 0x04, b"plate.nc\0")
    channel.call(0x2201, 0x02)
    channel.until(lambda: channel.request == (40, 1))
    assert channel.state == 16
    channel.call(0x2201, 0x11)
    channel.until(lambda: channel.state == IDLE)
    assert channel.request[1] == 0
    channel.grant(1)
    with pytest.raises(pyads.ADSError) as refused:
        channel.call(0x2201, 0x02)
    assert refused.value.err_code == 0x42C5
    channel.grant(0)
    channel.call(0x2201, 0x10)
    channel.until(lambda: channel.state == IDLE)
    assert struct.unpack_from("<5I", channel.read(0x2301, 0x80, 160), 4) == (0,) * 5
    channel.call(0x2201, 0x04, b"plate.nc\0")
    assert channel.state == READY


def test_a_block_search_begins_in_the_middle(channel: Channel) -> None:
    """Half of N70 is left: the axes are brought there, and the program goes on to M40."""
    channel.call(0x2201, 0x04, b"plate.nc\0")
    channel.call(0x2201, 0x18, struct.pack("<4Id", 1, 1, 70, 0, 50.0))
    channel.call(0x2201, 0x02)
    channel.until(lambda: struct.unpack("<dII", channel.read(0x3100 + GROUP, 0x556, 16))[1] == 70)
    assert channel.state == 8
    assert struct.unpack("<dII", channel.read(0x3100 + GROUP, 0x556, 16))[0] == 50.0
    with pytest.raises(pyads.ADSError) as refused:
        channel.call(0x2201, 0x19)
    assert refused.value.err_code == 0x4171
    channel.call(0x3200 + GROUP, 0x53)
    channel.bring(1, 20.0)
    channel.bring(2, 40.0)
    channel.until(channel.accepts_axes)
    channel.call(0x2201, 0x19)
    channel.until(lambda: channel.request == (40, 1))
    assert channel.position(1) == pytest.approx(0.0, abs=1e-6)
    assert channel.position(2) == pytest.approx(40.0, abs=1e-6)


@pytest.fixture(scope="module")
def own_station(
    tmp_path_factory: pytest.TempPathFactory,
    start_station: Callable[..., AbstractContextManager[Any]],
) -> Iterator[Any]:
    """A station whose channel has files: a program, a default program, a subroutine."""
    folder = tmp_path_factory.mktemp("mill")
    (folder / "data").mkdir()
    (folder / "data" / "DefaultGCode1.def").write_text("G91 F6000\nR7=5\n")
    (folder / "part.nc").write_text("N10 G1 X10\nN20 L100 P3\nN30 R8=R7*2\nN40 M30\n")
    (folder / "L100.NC").write_text("X5 Y1\nM17\n")
    axes = "".join(f'[[axis]]\nid = {n}\nname = "{name}"\n' for n, name in ((1, "X"), (2, "Y")))
    channel = '[[channel]]\nid = 1\nprograms = "."\ndata = "data"\n'
    group = f"[[group]]\nid = {GROUP}\nchannel = 1\n"
    file = folder / "station.toml"
    file.write_text(f'name = "mill"\n{axes}{channel}{group}')
    with start_station(str(file), "--speed", "5") as running:
        yield running


def test_a_default_program_runs_before_each(
    own_station: Any, pyads_connection: Callable[..., Any]
) -> None:
    """0x15: its modal words and its F hold; without it the program has no F (0x42C9)."""
    channel = Channel(pyads_connection(own_station, 501))
    make_ready(channel)
    channel.call(0x2201, 0x04, b"part.nc\0")
    channel.call(0x2201, 0x02)
    channel.until(lambda: channel.state == 12)
    assert channel.nc.read(0x2101, 0x01, pyads.PLCTYPE_DINT) == 0x42C9
    assert channel.nc.read(0x2101, 0x10, pyads.PLCTYPE_UDINT) == 0
    channel.call(0x2201, 0x10)
    channel.until(lambda: channel.state == IDLE)
    channel.nc.write(0x2001, 0x15, 1, pyads.PLCTYPE_UINT)
    for times in (1, 2):
        channel.call(0x2201, 0x04, b"part.nc\0")
        channel.call(0x2201, 0x02)
        channel.until(lambda: channel.state == READY)
        assert channel.position(1) == pytest.approx(25.0 * times, abs=1e-6)
        assert channel.position(2) == pytest.approx(3.0 * times, abs=1e-6)
    assert channel.nc.read(0x2301, 0x1000_0008, pyads.PLCTYPE_LREAL) == 10.0
