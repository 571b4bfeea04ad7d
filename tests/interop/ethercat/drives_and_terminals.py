"""Two drives and a digital terminal on an interface: `drives_and_terminals.py INTERFACE`.

Lines on stdin do harm: `alarm`, `hang` (in SafeOp) and `mend` act on the first drive. What the
terminal has at its outputs is at its inputs.
"""

import os
import select
import signal
import sys

from achse.codes import AlStatus
from achse.drive import Drive
from achse.drive.alarms import Alarm
from achse.ethercat import Segment, Slave
from achse.ethercat.terminals import DigitalTerminal
from achse.station.clocks.priority import answer_promptly
from achse.station.slaves.serving import serve_segment
from achse.transport.ethernet import EthernetLink


def main() -> None:
    drives = [Drive(), Drive()]
    terminal = DigitalTerminal(16, 16, "T")
    segment = Segment([*map(Slave, drives), Slave(terminal)])
    link = EthernetLink(sys.argv[1])
    running = True

    def stop(*_: object) -> None:
        nonlocal running
        running = False

    def harm() -> None:
        if not select.select([sys.stdin], [], [], 0)[0]:
            return
        first = segment.slaves[0]
        for word in os.read(sys.stdin.fileno(), 100).decode().split():
            if word == "alarm":
                drives[0].faults.alarm(Alarm.OVER_VOLTAGE, lasting=False)
            elif word == "hang":
                first.hang()
                first.fail(AlStatus.WATCHDOG)
            else:
                first.hang(False)

    def between() -> None:
        for channel in range(16):
            terminal.set_input(channel, terminal.output(channel))
        harm()

    signal.signal(signal.SIGTERM, stop)
    answer_promptly()
    print("ready", flush=True)
    serve_segment(segment, link, lambda: running, between)


if __name__ == "__main__":
    main()
