"""A segment of loopback slaves on an interface: `loopbacks.py INTERFACE COUNT`."""

import signal
import sys

from achse.ethercat import Loopback, Segment, Slave
from achse.station.clocks.priority import answer_promptly
from achse.station.slaves.serving import serve_segment
from achse.transport.ethernet import EthernetLink


def main() -> None:
    interface, count = sys.argv[1:]
    segment = Segment(Slave(Loopback(4, serial_number=n)) for n in range(int(count)))
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
