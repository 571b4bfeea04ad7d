"""Two clients, each row of channels, groups and axes, at every moment of part programs.

All numbers are drawn from those that hurt: ids of others, NaN, infinity, very small and very large.
Each request has its answer, nothing fails inside, set points stay finite and below the fastest
velocity; then all is given back, and the axes go where they are told by themselves.
"""

import contextlib
import math
import re
import struct
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import DeviceError
from achse.codes import NcError
from achse.server import READ, READ_WRITE, WRITE, Service
from tests.conftest import RouterClient
from tests.devices.nc.conftest import GroupBench

VELOCITY = 300.0
VALUES = {
    "max_velocity": VELOCITY,
    "max_acceleration": 3000.0,
    "max_deceleration": 3000.0,
    "default_jerk": 20_000.0,
}
SPECIAL = (0.0, 1.0, 2.0, -1.0, 5.0, 100.0, -100.0, 0.5, 1e-9, 1e6, 1e300, -1e300, 1e-320,
           math.nan, math.inf, -math.inf)  # fmt: skip
SMALL = (0, 1, 1, 2, 3, 4, 5, 11, 12, 13, 20, 0x4000)
IDS = {
    **dict.fromkeys((0x2000, 0x2100, 0x2200, 0x2300), (1, 1, 1, 2, 3)),
    **dict.fromkeys((0x3000, 0x3100, 0x3200, 0x3300), (11, 11, 12, 13)),
}
LEFT_OUT = (0x4000, 0x4100, 0x5000, 0x5100, 0x6000, 0x6100, 0x7000, 0x7100, 0x7300)
"""Parameters of axes, and what drives and encoders tell: by them the promises are made."""
FIELD = re.compile(r"(\d+) unused|BYTE\[(\d+)\]|((?:REAL|U?INT)(\d+)|BOOL)")
BLOCKS = (
    *("G1 X{a} Y{b}", "G0 Z{c}", "G3 X{a} Y{b} B{r}", "G2 X{a} Y{b} I{c} J{n}", "G4 X0.1", "M40"),
    *("M7", "M9", "@714", "@717", "G74 X", "#set paramVertexSmoothing({n};1;0.5)#", "G54", "G53"),
    *("G41 D{n}", "G42 D{n}", "G40", "T{n}", "G18", "G91", "G90", "R{n}={a}", "X=R{n}", "L{n}"),
    *("@100 {n}", "DYNOVR=0.5", "MEAS X{a}", "G58 X{a}", "ROT X{a}", "/{n} X{a}", "G60", "G64"),
    *("FLIN F{r}", "M30", "#set paramPathDynamics({r};{r};{r})#", "G1 X{a} Q1={b}", "G70"),
)


UNLIMITED = {(0x4200, offset) for offset in (0x1E, 0x25, 0x26, 0x27, 0x60)}
"""Another scaling, and what leads the drive past the set point."""


class Clients:
    """What two clients do to one station."""

    def __init__(self, folder: Path, draw: Random) -> None:
        self.folder, self.draw = folder, draw
        self.bench = bench = GroupBench(RouterClient, folder, **VALUES)
        self.failures: list[Exception] = []
        refuse: Any = bench.device._refusal

        def note(frame: Any, failure: Exception) -> bytes:
            if not isinstance(failure, DeviceError):
                self.failures.append(failure)
            answer: bytes = refuse(frame, failure)
            return answer

        bench.device._refusal = note  # type: ignore[method-assign]
        bench.put(0x320B, 0x50, "<3I", 1, 2, 3)
        if draw.random() < 0.3:
            bench.write(0x320B, 0x53)
            ids = (1, 2, *[0] * 6, 3, 4, *[0] * 6, draw.randrange(2), 0)
            bench.put(0x320D, 0x54, "<18I", *ids)
        self.rows = [
            (int(getattr(group, "base", 0) or getattr(group, "index_group", 0)), group, row)
            for group in bench.device.services
            for row in getattr(group, "rows", ())
        ]
        self.rows = [
            each
            for each in self.rows
            if each[0] not in LEFT_OUT and (each[0], each[2].offset) not in UNLIMITED
        ]
        near = (0x2000, 0x2200, 0x3000, 0x3200, 0x4200)
        self.near = [each for each in self.rows if each[0] in near]

    def number(self, kind: str, bits: int) -> bytes:
        draw = self.draw
        if kind.startswith("REAL"):
            value = draw.choice(SPECIAL) if draw.random() < 0.7 else draw.uniform(-200.0, 200.0)
            if bits == 32:
                value = math.copysign(math.inf, value) if abs(value) > 1e30 else value
                return struct.pack("<f", value)
            return struct.pack("<d", value)
        whole = draw.choice(SMALL) if draw.random() < 0.8 else draw.getrandbits(bits)
        return (whole & ((1 << bits) - 1)).to_bytes(bits // 8, "little")

    def data(self, row: Service) -> bytes:
        """Bytes for a row, by its layout."""
        draw = self.draw
        codec = draw.choice(row.codec) if isinstance(row.codec, tuple) else row.codec
        out = b""
        for unused, text, kind, bits in FIELD.findall(getattr(codec, "name", "") or ""):
            if unused:
                out += bytes(int(unused))
            elif text:
                size = int(text)
                name = draw.choice((b"part.nc", b"snap", b"", b"../x", draw.randbytes(size)))
                out += name[:size].ljust(size, b"\0")
            else:
                out += self.number(kind, int(bits or 8))
        if codec.size is None:
            many = b"".join(self.number("REAL64", 64) for _ in range(draw.randrange(20)))
            return draw.choice((b"part.nc\0", b"sub", b"", self.number("UINT32", 32), many))
        return out if len(out) == codec.size else draw.randbytes(codec.size)

    def program(self) -> str:
        draw, lines = self.draw, ["F6000"]
        for number in range(1, draw.randrange(2, 20)):
            block = draw.choice(BLOCKS[:6] * 3 + BLOCKS)
            lines.append(
                f"N{number} "
                + block.format(
                    a=draw.randint(-30, 30),
                    b=draw.randint(-30, 30),
                    c=draw.randint(-5, 5),
                    n=draw.randint(0, 5),
                    r=draw.choice((1, 50, 500, 20_000)),
                )
            )
        return "\n".join(lines)

    def run(self, cycles: int) -> None:
        for _ in range(cycles):
            self.bench.nc.cycle()
            for axis in self.bench.nc:
                assert math.isfinite(axis.set_position)
                assert abs(axis.set_velocity) <= VELOCITY * 1.001

    def act(self) -> None:
        """One request, or what happens to an axis."""
        draw, bench = self.draw, self.bench
        kind = draw.random()
        if kind < 0.15:
            (self.folder / "part.nc").write_text(self.program())
            bench.write(0x2201, 0x04, b"part.nc\0")
            bench.write(0x2201, 0x02)
        elif kind < 0.2:
            for axis in bench.nc:
                axis.control_dword, axis.velocity_override = 7, 1_000_000
            bench.write(0x2201, 0x10)
        elif kind < 0.23:
            draw.choice(list(bench.nc)).control_dword = draw.choice((0, 3, 7))
        elif kind < 0.26:
            bench.put(0x4200 + draw.randrange(1, 5), 0x19, "<I", 0x4650)
        else:
            base, group, row = draw.choice(self.near if draw.random() < 0.85 else self.rows)
            index = base
            if getattr(group, "base", None) is not None:
                index += draw.choice(IDS.get(base, (1, 2, 3, 4)))
            offset = row.offset + (draw.randrange(row.count) if row.count > 1 else 0)
            if WRITE in row.access:
                bench.write(index, offset, self.data(row))
            elif READ_WRITE in row.access:
                bench.exchange(index, offset, 400, self.data(row))
            if READ in row.access:
                bench.read(index, offset, 1020)

    def recover(self) -> None:
        """Stop, reset, dissolve, decouple; then each axis lives by itself."""
        bench = self.bench

        def all_the_same(*request: Any) -> None:
            with contextlib.suppress(DeviceError):
                bench.write(*request)

        for axis in bench.nc:
            axis.control_dword, axis.velocity_override = 7, 1_000_000
        for _ in range(3):
            for channel in (1, 2, 3):
                all_the_same(0x2200 + channel, 0x11)
            for axis in bench.nc:
                for function in (0x51, 0x03, 0x41, 0x61):
                    # enabled again, stopped, decoupled, without external set points
                    all_the_same(0x4200 + axis.axis_id, function)
            self.run(1500)
            for channel in (1, 2, 3):
                all_the_same(0x2200 + channel, 0x10)
            for group in (0x320B, 0x320C, 0x320D):
                all_the_same(group, 0x01)
                self.run(100)
                all_the_same(group, 0x53)
            for axis in bench.nc:
                all_the_same(0x4200 + axis.axis_id, 0x01)
            self.run(200)
        for axis in bench.nc:
            assert not axis.error_code, hex(axis.error_code)
            assert not axis.grouped
            self.move(axis)

    def move(self, axis: Any) -> None:
        """By itself; a set position that is far from the actual one costs a reset."""
        bench = self.bench
        for _ in range(2):
            target = round(axis.set_position) + 5.0
            bench.start(target, 50.0, axis=axis.axis_id)
            self.run(600)
            if axis.error_code != NcError.FOLLOWING_ERROR_POSITION:
                break
            bench.write(0x4200 + axis.axis_id, 0x01)
            self.run(100)
        assert axis.set_position == pytest.approx(target), hex(axis.error_code)


@settings(max_examples=12, derandomize=True)
@given(st.integers(0, 2**32 - 1))
def test_any_request_at_any_moment_of_a_program(seed: int) -> None:
    draw = Random(seed)
    with TemporaryDirectory() as folder:
        clients = Clients(Path(folder), draw)
        for _ in range(draw.randint(10, 60)):
            clients.run(draw.choice((0, 1, 1, 2, 5, 20, 80)))
            with contextlib.suppress(DeviceError):
                clients.act()
            assert not clients.failures, clients.failures
        clients.recover()
