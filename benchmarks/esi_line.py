"""Processor time of a cyclic frame in a line of slaves of ESI files.

PLACE is an ESI file or a folder of them, SPEC is TYPE[@REVISION][=MODULE,…][*COUNT] as for
`achse bus serve`, CYCLES the cycles of a batch (100). Our master brings the line to Op in virtual
time; then its frames of one cycle pass again and again: the time is that of the slaves alone, that
of the fastest of nine batches.
Usage: python benchmarks/esi_line.py PLACE SPEC… [CYCLES]
"""

import sys
import time
from pathlib import Path

from achse.codes import AlState
from achse.ethercat import Segment
from achse.ethercat.master import BusConfiguration, Master, Ring
from achse.ethercat.master.esi_reader import from_esi
from achse.station.slaves.esi_line import EsiLine

CYCLE_NS = 4_000_000
MOST_CYCLES = 50_000
BATCHES = 9


def in_op(segment: Segment, slaves: EsiLine) -> list[bytes]:
    """Bring the line to Op; the frames of a cycle in which nothing else travels."""
    configurations = tuple(
        from_esi(each.device.esi, f"Box {number}", cycle_ns=CYCLE_NS)
        for number, each in enumerate(slaves.slaves, 1)
    )
    master = Master(BusConfiguration(configurations, cycle_ns=CYCLE_NS))
    master.request(AlState.OP)
    ring = Ring(master, segment)
    for _ in range(MOST_CYCLES):
        ring.exchange(segment.time.now_ns + CYCLE_NS)
        if master.operational:
            break
    else:
        raise SystemExit(f"not in Op: {[each.last_trouble for each in master.slaves][:5]}")
    cycles: list[list[bytes]] = []
    process = segment.process

    def note(frame: bytes) -> bytes | None:
        cycles[-1].append(bytes(frame))
        return process(frame)

    segment.process = note  # type: ignore[method-assign]
    for _ in range(50):
        cycles.append([])
        ring.exchange(segment.time.now_ns + CYCLE_NS)
    segment.process = process  # type: ignore[method-assign]
    return min(cycles, key=len)


def main() -> None:
    if len(sys.argv) < 3:
        raise SystemExit(__doc__)
    place, *specs = sys.argv[1:]
    count = int(specs.pop()) if specs[-1].isdigit() else 100
    line = EsiLine(specs, [Path(place)])
    segment = Segment(line.slaves)
    begin = time.process_time()
    frames = in_op(segment, line)
    up = time.process_time() - begin
    samples = []
    for _ in range(BATCHES):
        begin = time.process_time()
        for _ in range(count):
            for frame in frames:
                segment.process(frame)
            segment.advance(segment.time.now_ns + CYCLE_NS)
        samples.append((time.process_time() - begin) / count)
    cycle = min(samples)
    print(
        f"{len(line.slaves)} slaves, {up:.1f} s to Op, {len(frames)} frames a cycle with"
        f" {sum(map(len, frames))} bytes: {1e3 * cycle / len(frames):.3f} ms a frame,"
        f" {1e6 * cycle / len(line.slaves):.2f} µs a slave and cycle"
    )


if __name__ == "__main__":
    main()
