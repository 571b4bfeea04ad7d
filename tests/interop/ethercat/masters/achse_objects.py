"""Objects of the first slave through our master and its ADS device; JSON on stdout.

`achse_objects.py INTERFACE MS FILE`: FILE has index and subindex of each entry. Each is read at
group 0xF302 of the slave's port; of what is refused the abort code at 0xF303 is given.
"""

import json
import struct
import sys
import time
from pathlib import Path

from achse.ams import AmsAddress, Command, Flags, Frame, NetId
from achse.codes import AlState
from achse.devices.io import AttachedBuses, ServedBus, default_net_id
from achse.ethercat.master import BusConfiguration, Master
from achse.ethercat.master.events import BusEventKind
from achse.ethercat.master.scanning import scan_bus
from achse.router import Router
from achse.station.buses.frame_link import BusLink, do_steps
from achse.station.clocks.priority import answer_promptly
from achse.transport.ethernet import EthernetLink

CYCLE_NS = 1_000_000
SDO, SDO_ERROR = 0xF302, 0xF303
LONGEST = 4096
WITHIN = 120 * 10**9
STATION = NetId("10.9.8.7.1.1")


class Client:
    """Asks the ADS device of a slave while the bus runs."""

    def __init__(self, bus: BusLink, master: Master) -> None:
        self.bus, self.master = bus, master
        self.router = Router(STATION)
        served = ServedBus(1, master, default_net_id(STATION, 1))
        self.net_id = served.net_id
        self.attached = AttachedBuses(self.router, [served], clock=time.monotonic_ns)
        self.answers: list[Frame] = []
        self.address = self.router.register(0, self)
        self.begin = time.monotonic_ns()

    def deliver(self, frame: Frame) -> bool:
        self.answers.append(frame)
        return True

    def run(self) -> None:
        """One cycle."""
        time.sleep(CYCLE_NS / 1e9)
        now = time.monotonic_ns() - self.begin
        if now > WITHIN:
            raise TimeoutError(str(self.master.take_events()[-5:]))
        self.bus.exchange(now)

    def read(self, group: int, offset: int) -> tuple[int, bytes]:
        """Result and bytes of a Read at the first slave."""
        self.answers.clear()
        target = AmsAddress.of(self.net_id, self.master.slaves[0].station)
        data = struct.pack("<III", group, offset, LONGEST)
        request = Frame(
            target, self.address, Command.READ, Flags.ADS_COMMAND, invoke_id=1, data=data
        )
        self.router.deliver(request)
        while not self.answers:
            self.run()
        answer = self.answers[0]
        return struct.unpack_from("<I", answer.data)[0], answer.data[8:]

    def value(self, index: int, subindex: int) -> str:
        result, data = self.read(SDO, index << 16 | subindex)
        if not result:
            return data.hex()
        _, error = self.read(SDO_ERROR, 0)
        return f"{int.from_bytes(error[8:12], 'little'):08X}"


def main() -> None:
    interface, _, file = sys.argv[1:]
    link = EthernetLink(interface)
    answer_promptly()
    slaves = do_steps(link, scan_bus(with_objects=False))
    configured = tuple(each.configuration for each in slaves)
    master = Master(BusConfiguration(configured, cycle_ns=CYCLE_NS))
    client = Client(BusLink(master, link, wait_s=0.02), master)
    master.request(AlState.PREOP)
    while master.slaves[0].state != AlState.PREOP:
        client.run()
        if any(event.kind is BusEventKind.STATE_FAILED for event in master.take_events()):
            master.request(AlState.PREOP)  # a reply came after its 20 ms: the machine is busy
    entries = json.loads(Path(file).read_text())
    print(json.dumps([[*entry, client.value(*entry)] for entry in entries]))
    link.close()


if __name__ == "__main__":
    main()
