"""Cost of a cyclic frame in `Segment.process`: one LRW for all slaves, and one with DC besides.

The slaves are loopbacks of 16 bytes each way or drives with their default mapping that move in csp,
all in Op, with the frames as the clock; each cycle therefore lets 1 ms pass for every slave.
Usage: python benchmarks/ethercat_segment.py [SECONDS_PER_ROW]
"""

import statistics
import struct
import sys
import time

from achse.codes import AlState
from achse.drive import Drive
from achse.drive.compiled import Bank
from achse.ethercat import (
    Application,
    Datagram,
    DatagramCommand,
    EthercatFrame,
    Loopback,
    Segment,
    Slave,
)
from achse.ethercat.description import LAYOUT

CYCLE_NS = 1_000_000
BATCH = 50
OUTPUTS = struct.Struct("<HbHiHI")  # 1600h: controlword, mode, max torque, target, probe, outputs
CSP = 8
REFERENCE = 0x1001


def plain_drives(count: int) -> list[Application]:
    """Drives in Python."""
    return [Drive() for _ in range(count)]


def compiled_drives(count: int) -> list[Application]:
    """Drives in machine code."""
    bank = Bank(count)
    return [Drive(compiled=bank) for _ in range(count)]


def loopbacks(count: int) -> list[Application]:
    """Slaves that give back what they get."""
    return [Loopback(16) for _ in range(count)]


KINDS = {"loopbacks": loopbacks, "drives": plain_drives, "compiled": compiled_drives}


def in_op(applications: list[Application], *, dc: bool) -> Segment:
    """A segment whose slaves a minimal master has brought to Op."""
    segment = Segment(map(Slave, applications), cycle_ns=CYCLE_NS)

    def send(*datagrams: Datagram) -> bytes:
        reply = segment.process(EthercatFrame(datagrams).encode())
        assert reply is not None
        return EthercatFrame.decode(reply).datagrams[0].data

    outputs, inputs = 0, sum(each.output_size for each in applications)
    for position, application in enumerate(applications):
        station = REFERENCE + position
        mailboxes = b"".join(
            struct.pack("<HHBBBB", area.start, area.length, area.control, 0, 1, 0)
            for area in (LAYOUT.mailbox_out, LAYOUT.mailbox_in)
        )
        buffers = b"".join(
            struct.pack("<HHBBBB", area.start, size, area.control, 0, 1, 0)
            for area, size in (
                (LAYOUT.outputs, application.output_size),
                (LAYOUT.inputs, application.input_size),
            )
        )
        mapping = b"".join(
            struct.pack("<IHBBHBBB3x", logical, size, 0, 7, area.start, 0, direction, 1)
            for logical, size, area, direction in (
                (outputs, application.output_size, LAYOUT.outputs, 2),
                (inputs, application.input_size, LAYOUT.inputs, 1),
            )
        )
        outputs += application.output_size
        inputs += application.input_size
        send(Datagram.at(DatagramCommand.APWR, -position, 0x0010, station.to_bytes(2, "little")))
        send(Datagram.at(DatagramCommand.FPWR, station, 0x0800, mailboxes))
        send(Datagram.at(DatagramCommand.FPWR, station, 0x0120, b"\x02\x00"))
        send(Datagram.at(DatagramCommand.FPWR, station, 0x0810, buffers))
        send(Datagram.at(DatagramCommand.FPWR, station, 0x0600, mapping))
        if dc:
            send(Datagram.at(DatagramCommand.BWR, 0, 0x0900, bytes(4)))
            times = [
                int.from_bytes(
                    send(Datagram.at(DatagramCommand.FPRD, each, 0x0900, bytes(4))), "little"
                )
                for each in (REFERENCE, station)
            ]
            delay = (times[1] - times[0]).to_bytes(4, "little")
            send(Datagram.at(DatagramCommand.FPWR, station, 0x0928, delay))
            send(Datagram.at(DatagramCommand.FPWR, station, 0x0990, (10**6).to_bytes(8, "little")))
            send(Datagram.at(DatagramCommand.FPWR, station, 0x09A0, CYCLE_NS.to_bytes(4, "little")))
            send(Datagram.at(DatagramCommand.FPWR, station, 0x0981, b"\x03"))
        send(Datagram.at(DatagramCommand.FPWR, station, 0x0120, b"\x04\x00"))
    send(Datagram(DatagramCommand.LRW, 0, bytes(inputs)))
    send(Datagram.at(DatagramCommand.BWR, 0, 0x0120, b"\x08\x00"))
    assert all(slave.state is AlState.OP for slave in segment.slaves)
    return segment


def cyclic_frames(segment: Segment, outputs: bytes, *, dc: bool) -> list[bytes]:
    """The frames of one cycle: as many LRW as needed, the first with the reference time."""
    data = b"".join(outputs[: each.application.output_size] for each in segment.slaves)
    data += bytes(sum(each.application.input_size for each in segment.slaves))
    parts = [
        [Datagram(DatagramCommand.LRW, first, data[first : first + 1400])]
        for first in range(0, len(data), 1400)
    ]
    if dc:
        parts[0].append(Datagram.at(DatagramCommand.FRMW, REFERENCE, 0x0910, bytes(8)))
    return [EthercatFrame(part).encode() for part in parts]


def moving(segment: Segment, *, dc: bool) -> list[list[bytes]]:
    """Enable the drives; the frames of cycles in which they move to and fro in csp."""
    for word in (0x06, 0x07, 0x0F, 0x0F):
        for frame in cyclic_frames(segment, OUTPUTS.pack(word, CSP, 3000, 0, 0, 0), dc=dc):
            segment.process(frame)
    return [
        cyclic_frames(segment, OUTPUTS.pack(0x0F, CSP, 3000, target, 0, 0), dc=dc)
        for target in (*range(0, 5_000, 200), *range(5_000, 0, -200))
    ]


def cost(segment: Segment, cycles: list[list[bytes]], seconds: float) -> tuple[float, float]:
    """Median and 99 % quantile of one cycle in microseconds; batches are the samples."""
    samples = []
    process = segment.process
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        begin = time.perf_counter_ns()
        for frames in cycles:
            for frame in frames:
                process(frame)
        samples.append((time.perf_counter_ns() - begin) / BATCH / 1000.0)
    samples.sort()
    return statistics.median(samples), samples[int(0.99 * (len(samples) - 1))]


def main() -> None:
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 1.0
    print(f"{'slaves':>15} {'frame':>8} {'median µs':>10} {'99 %':>8} {'µs/slave':>9}")
    for kind, applications in KINDS.items():
        for dc in (False, True):
            for count in (1, 8, 32):
                segment = in_op(applications(count), dc=dc)
                if kind == "loopbacks":
                    cycles = [cyclic_frames(segment, bytes(16), dc=dc)] * BATCH
                else:
                    cycles = moving(segment, dc=dc)
                median, late = cost(segment, cycles, seconds)
                assert all(slave.state is AlState.OP for slave in segment.slaves)
                name = "LRW+FRMW" if dc else "LRW"
                print(f"{count:>3} {kind:>11} {name:>8} {median:>10.2f} {late:>8.2f}", end="")
                print(f" {median / count:>9.2f}")


if __name__ == "__main__":
    main()
