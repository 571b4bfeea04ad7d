"""Soak: hours of virtual time with everything on, twice; digests are equal and memory is flat.

The station has axes on drives behind a bus, cams, a part program, PLC programs in both forms, a
scope, and clients that read, write, subscribe, move, couple and leave at random, all from one seed.
Each hour one of restart, reset of the PLC, online change. Each row: hour, memory, frames, digest.
Usage: python benchmarks/soak.py [HOURS [SEED [RUNS]]]; the digests of runs in several processes may
be compared by hand.
"""

import gc
import hashlib
import os
import random
import struct
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from same_run import Talker, act

from achse.ams import AmsAddress, Command
from achse.camshaft.kernel import KERNEL as CAMSHAFT
from achse.motion.compiled import KERNEL as AXES
from achse.station import Station
from achse.station.buses.whole_cycle import KERNEL as DRIVEN_AXES

CONFIG = """
[[axis]]
id = 1
name = "X"
plc = "MAIN.axis"

[[axis]]
id = 2
name = "Y"

[[axis]]
id = 3
name = "C"
modulo = true
encoder_modulo_factor = 360.0

[[axis]]
id = 4
name = "U"

[[axis]]
id = 5
name = "V"

[[channel]]
id = 1
name = "Interpolation"

[[group]]
id = 11
name = "3D"
channel = 1

[[camshaft]]
name = "Press"
axis = "C"

[[bus]]
name = "Drives"

[[drive]]
axis = "Y"

[[terminal]]
name = "Inputs"
input_address = 100

[[plc]]
port = 851
sources = "machine.st"

[[plc]]
port = 852
sources = "plain.st"
code = "plain"
"""

MACHINE = """
FUNCTION_BLOCK FB_Count
VAR nSum : DINT; tDelay : TON; END_VAR
METHOD Add : DINT VAR_INPUT n : DINT; END_VAR
    nSum := nSum + n;
    Add := nSum;
END_METHOD
tDelay(IN := nSum MOD 7 > 3, PT := T#30MS);
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR axis : AXIS_REF; fbCount : FB_Count; n : DINT; sText : STRING; p : POINTER TO DINT; END_VAR
VAR RETAIN nKept : DINT; END_VAR
VAR PERSISTENT nLasting : DINT; END_VAR
fbCount();
n := fbCount.Add(%d) MOD 100000;
sText := CONCAT('part ', DINT_TO_STRING(n));
p := __NEW(DINT);
IF p <> 0 THEN p^ := n; __DELETE(p); END_IF
nKept := nKept + 1;
nLasting := nLasting + 1;
END_PROGRAM
"""
PLAIN = (
    "PROGRAM MAIN VAR n : DINT; t : TON; END_VAR n := n + 1; t(IN := n MOD 50 > 3); END_PROGRAM\n"
)
PROGRAM = (
    "N10 G71\nN20 M40\nN30 G01 X50 Y20 F6000\nN40 G02 X60 Y30 I10 J0\nN50 G00 X0 Y0\nN60 M30\n"
)

TURN_S = 5.0
STAY = 60
"""Turns after which a client leaves, with all that it holds."""


class Row(NamedTuple):
    """An hour of the soak."""

    hour: int
    resident_mb: float
    lines: int
    digest: str


class Hashed(list[str]):
    """A list of lines that keeps their number and digest alone."""

    def __init__(self) -> None:
        super().__init__()
        self.lines = 0
        self.digest = hashlib.blake2b(digest_size=8)

    def append(self, line: str) -> None:
        self.lines += 1
        self.digest.update(line.encode())


def resident_mb() -> float:
    """Memory of this process; 0 where the system does not report it."""
    gc.collect()
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[1])
    except OSError:
        return 0.0
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def more(draw: random.Random, talker: Talker) -> None:
    """Actions that `act` does not have: couplings, cams, channel, drive objects, symbols."""
    match draw.randrange(6):
        case 0:
            gear = struct.pack("<IIdd", 1, 4, draw.uniform(-2, 2), 0.0)
            talker.write(501, 0x4205, 0x40, gear)
        case 1:
            talker.write(501, 0x4205, 0x41)
        case 2:
            talker.write(501, 0x3200 + 11, 0x50, struct.pack("<3I", 1, 4, 0))
        case 3:
            offset = draw.choice((0x04, 0x02, 0x02, 0x10, 0x11))
            talker.write(501, 0x2201, offset, b"part.nc\0" if offset == 0x04 else b"")
        case 4:
            talker.read(900, 0x1000, draw.randrange(8), 8)
        case 5:
            talker.exchange(851, 0xF004, 0, 4, b"MAIN.fbCount.nSum\0")


def soak(folder: Path, hours: float, seed: int, show: Callable[[Row], None]) -> str:
    """Return the digest of the run."""
    draw, lines = random.Random(seed), Hashed()
    (folder / "station.toml").write_text(CONFIG)
    (folder / "machine.st").write_text(MACHINE % 3)
    (folder / "plain.st").write_text(PLAIN)
    (folder / "part.nc").write_text(PROGRAM)
    station = Station.load(folder / "station.toml")
    station.advance(2.0)
    talkers: list[tuple[Talker, int]] = []
    turns, per_hour = round(hours * 3600 / TURN_S), round(3600 / TURN_S)
    for turn in range(turns):
        if turn % (STAY // 3) == 0:
            if len(talkers) == 3:
                leaving, port = talkers.pop(0)
                station.router.unregister(port)
                leaving.answers.clear()
            port = 40_000 + turn % 20_000
            talker = Talker(station.router, AmsAddress.of(station.router.net_id, port), lines)
            talkers.append((talker, port))
        for talker, _ in talkers:
            draw.choice((act, act, more))(draw, talker)
        if turn % 97 == 5:
            with station.scope(["MAIN.n"], length=0.1) as scope:
                station.advance(0.2)
            lines.append(str(scope.data().end_ns))
        station.advance(TURN_S)
        if turn % 12 == 11:
            talkers[0][0].ask(851, Command.READ_STATE)
        if turn % per_hour == per_hour - 1:
            hour = turn // per_hour + 1
            match hour % 3:
                case 0:
                    station.restart()
                    station.advance(3.0)
                case 1:
                    station.plcs[851].reset()
                    station.plcs[851].run()
                case 2:
                    (folder / "machine.st").write_text(MACHINE % (3 + hour))
                    station.online_change()
            lines.append(station.digest())
            show(Row(hour, resident_mb(), lines.lines, lines.digest.hexdigest()))
    return lines.digest.hexdigest()


def show(row: Row) -> None:
    print(
        f"hour {row.hour:3}  {row.resident_mb:6.1f} MB  {row.lines:9,} lines  {row.digest}",
        flush=True,
    )


def main(hours: float = 24.0, seed: float = 1, runs: float = 2) -> None:
    for kernel in (AXES, DRIVEN_AXES, CAMSHAFT):
        _ = kernel.function  # in the cache before a station looks for it there
    digests: list[str] = []
    for run in range(1, int(runs) + 1):
        begin = time.process_time()
        with tempfile.TemporaryDirectory() as folder:
            digests.append(soak(Path(folder), hours, int(seed), show))
        print(f"run {run}: {digests[-1]}, {time.process_time() - begin:.0f} s of processor time")
    equal = len(set(digests)) == 1
    print("digests equal" if equal else "digests differ")
    sys.exit(not equal)


if __name__ == "__main__":
    main(*map(float, sys.argv[1:]))
