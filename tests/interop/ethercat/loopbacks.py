"""A segment of loopback slaves on an interface: `loopbacks.py INTERFACE COUNT [CAPTURE]`."""

import signal
import struct
import sys
import time
from pathlib import Path
from typing import BinaryIO

from achse.ethercat import Loopback, Segment, Slave
from achse.station.fieldbus import answer_promptly, serve_segment
from achse.transport.ethernet import EthernetLink


class Recorder(Segment):
    """A segment that writes each frame to a capture file, as it came and as it went."""

    capture: BinaryIO | None = None

    def process(self, frame: bytes) -> bytes | None:
        reply = super().process(frame)
        if self.capture:
            for packet in (frame, reply):
                if packet is not None:
                    seconds, ns = divmod(time.time_ns(), 10**9)
                    size = len(packet)
                    head = struct.pack("<IIII", seconds, ns // 1000, size, size)
                    self.capture.write(head + packet)
        return reply


def main() -> None:
    interface, count, *capture = sys.argv[1:]
    segment = Recorder(Slave(Loopback(4, serial_number=n)) for n in range(int(count)))
    if capture:
        segment.capture = Path(capture[0]).open("wb", buffering=0)  # noqa: SIM115
        segment.capture.write(struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 0x40000, 1))
    link = EthernetLink(interface)
    running = True

    def stop(*_: object) -> None:
        nonlocal running
        running = False

    signal.signal(signal.SIGTERM, stop)
    answer_promptly()
    print("ready", flush=True)
    serve_segment(segment, link, lambda: running)


if __name__ == "__main__":
    main()
