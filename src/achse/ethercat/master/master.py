"""The EtherCAT master: brings a configured bus up, exchanges process data, watches over it.

It knows neither link nor clock: `transmit` and `poll` give the frames to send now, `receive` takes
those that came. All times are integer nanoseconds of one clock that never goes back.

Source: ETG.1000.4, ETG.1020 for the order of a start; 001 §2.
"""

from collections import deque
from collections.abc import Callable
from typing import TypeVar

from achse.codes import AlState
from achse.ethercat.master.bring_up import BringUp
from achse.ethercat.master.bus_slave import BusSlave, PortCounters
from achse.ethercat.master.configuration import BusConfiguration
from achse.ethercat.master.cyclic import CyclicCounters, CyclicExchange
from achse.ethercat.master.errors import NoMailbox, SlaveNotReady
from achse.ethercat.master.ethernet import BusEthernet
from achse.ethercat.master.events import BusEvent, BusEventKind, EmergencyMessage
from achse.ethercat.master.process_image import ProcessImage
from achse.ethercat.master.redundancy import Redundancy
from achse.ethercat.master.sdo_client import SdoClient
from achse.ethercat.master.steps import Steps
from achse.ethercat.master.supervision import Supervision
from achse.ethercat.master.traffic import ACYCLIC, AcyclicTraffic, BusJob

_FRAME_TIMEOUT_NS = 5_000_000
_MAX_EVENTS = 4096
_INDEX_AT = 17
"""Offset of the first datagram's index in an Ethernet frame."""
_LEAST_FRAME = 28

T = TypeVar("T")


class Master:
    """One bus. `slaves` are the configured ones, in order; `request` says what they shall do.

    In each cycle: `transmit(now)` and send what it gives, hand each frame that comes to `receive`.
    Between the cycles `poll(now)` gives further requests. `events` are kept until `take_events`.
    """

    def __init__(self, bus: BusConfiguration) -> None:
        self.bus = bus
        self.image = ProcessImage(bus)
        self.cyclic = CyclicExchange(self.image)
        self.traffic = AcyclicTraffic(max(2 * bus.cycle_ns, _FRAME_TIMEOUT_NS))
        self.on_event: Callable[[BusEvent], None] | None = None
        """Callback for each event at once, besides `take_events`."""
        self.now_ns = 0
        self.counters_since_ns = 0
        """Time since which the counters count frames, ns."""
        self._events: deque[BusEvent] = deque(maxlen=_MAX_EVENTS)
        self.slaves = tuple(
            BusSlave(
                position,
                station,
                bus.slaves[position],
                self.cyclic.outputs(position),
                self.cyclic.inputs(position),
                (self.image.writes.get(position), self.image.reads.get(position)),
                self._emergency,
            )
            for position, station in enumerate(bus.stations())
        )
        self._by_station = {slave.station: slave for slave in self.slaves}
        self.ethernet = BusEthernet(
            self.slaves, lambda steps, ended: self.traffic.start(steps, lambda job: ended())
        )
        """The network that slaves with EoE and this process share."""
        self.requested_state = AlState.INIT
        self.redundancy = Redundancy() if bus.redundant else None
        """Ring of a redundant bus: it copies frames that leave and accepts copies that return."""
        bring_up = BringUp(bus, self.image, self._reached, self._clock_warning)
        self.supervision = Supervision(
            bus, self.slaves, self.cyclic, self.traffic, bring_up, self._report, self.redundancy
        )
        self.traffic.start(self.supervision.run())

    # frames

    def transmit(self, now_ns: int, acyclic: int = 1) -> list[bytes]:
        """Return the frames of a cycle: process data, then at most `acyclic` frames of requests."""
        self.now_ns = now_ns
        frames = self.cyclic.frames() if self.supervision.cyclic_on else []
        return frames + self.traffic.frames(now_ns, acyclic)

    def poll(self, now_ns: int, acyclic: int = 1) -> list[bytes]:
        """Frames of requests to send now, between the cycles."""
        self.now_ns = now_ns
        return self.traffic.frames(now_ns, acyclic)

    def receive(self, frame: bytes, now_ns: int) -> None:
        """Take a frame that came back. What is not ours, late or broken is counted and left."""
        self.now_ns = now_ns
        if len(frame) < _LEAST_FRAME or frame[_INDEX_AT] >= ACYCLIC.start:
            self.traffic.receive(frame, now_ns)
        else:
            self.cyclic.receive(frame)

    @property
    def quiet_until_ns(self) -> int:
        """Time until which only process data travel if nothing intervenes, ns; 0: not now."""
        if not (self.supervision.cyclic_on and self.traffic.idle and self.traffic.waiting == 1):
            return 0
        return self.supervision.quiet_until_ns if self.operational else 0

    def skip(self, cycles: int) -> None:
        """Count so many cycles that passed without frames; see `CyclicExchange.skip`."""
        elapsed = cycles * self.bus.cycle_ns
        self.now_ns += elapsed
        self.cyclic.skip(cycles, elapsed)

    # states

    def request(self, state: AlState, slave: BusSlave | None = None) -> None:
        """Ask for a state of one slave or of all; a slave that has given up tries again."""
        if slave is None:
            self.requested_state = state
        for each in self.slaves if slave is None else (slave,):
            each.requested_state = state
            self.supervision.retry(each)

    def restart(self, slave: BusSlave) -> None:
        """Lead a slave through Init to the state that it shall have."""
        self.supervision.restart(slave)

    def reset_frames(self) -> None:
        """Count frames from 0."""
        self.cyclic.counters = CyclicCounters()
        self.traffic.sent_frames = self.traffic.lost_frames = self.traffic.strays = 0
        self.counters_since_ns = self.now_ns

    def reset_counters(self) -> None:
        """Count errors of slaves from 0."""
        for slave in self.slaves:
            slave.counters = PortCounters()
            slave.losses = slave.abnormal_changes = 0

    @property
    def state(self) -> int:
        """The lowest state of the slaves that have to be there; 0 if one does not answer."""
        return min(
            (each.state for each in self.slaves if each.present or not each.configuration.optional),
            default=int(self.requested_state),
        )

    @property
    def operational(self) -> bool:
        """True if all slaves are in Op, and their process data are valid."""
        return all(
            each.operational
            for each in self.slaves
            if each.present or not each.configuration.optional
        )

    def absent(self, slave: BusSlave) -> bool:
        """Return True if the bus was searched, and that slave does not answer."""
        return self.supervision.searched and not slave.present

    def slave(self, station: int) -> BusSlave | None:
        """Return the slave with that station address."""
        return self._by_station.get(station)

    # requests

    def run(
        self, steps: Steps[T], finished: Callable[[BusJob[T]], None] | None = None
    ) -> BusJob[T]:
        """Do steps of any kind; the job ends within later frames."""
        return self.traffic.start(steps, finished)

    def upload(
        self,
        slave: BusSlave,
        index: int,
        subindex: int = 0,
        *,
        complete: bool = False,
        response_ns: int = 0,
        finished: Callable[[BusJob[bytes]], None] | None = None,
    ) -> BusJob[bytes]:
        """Read an object of a slave by SDO; the value is little-endian as the slave sends it."""
        return self.run(
            self._with_sdo(
                slave,
                lambda sdo: sdo.upload(index, subindex, complete=complete, response_ns=response_ns),
            ),
            finished,
        )

    def download(
        self,
        slave: BusSlave,
        index: int,
        subindex: int,
        data: bytes,
        *,
        complete: bool = False,
        response_ns: int = 0,
        finished: Callable[[BusJob[None]], None] | None = None,
    ) -> BusJob[None]:
        """Write an object of a slave by SDO."""
        return self.run(
            self._with_sdo(
                slave,
                lambda sdo: sdo.download(
                    index, subindex, data, complete=complete, response_ns=response_ns
                ),
            ),
            finished,
        )

    def _with_sdo(self, slave: BusSlave, request: Callable[[SdoClient], Steps[T]]) -> Steps[T]:
        if slave.sdo is None:
            raise NoMailbox(f"{slave.name} (station {slave.station}) has no CoE")
        if not slave.speaks:
            raise SlaveNotReady(
                f"{slave.name} (station {slave.station}) is in state {slave.state}: CoE needs PreOp"
            )
        return (yield from request(slave.sdo))

    # events

    def take_events(self) -> list[BusEvent]:
        """Return the events since the last call, the oldest first."""
        events = list(self._events)
        self._events.clear()
        return events

    def _report(
        self, kind: BusEventKind, slave: BusSlave | None, number: int, text: str, data: bytes = b""
    ) -> None:
        station = slave.station if slave else 0
        event = BusEvent(self.now_ns, kind, station, number, text, data)
        self._events.append(event)
        if self.on_event is not None:
            self.on_event(event)

    def _emergency(self, slave: BusSlave, data: bytes) -> None:
        message = EmergencyMessage.decode(data)
        text = f"{slave.name}: emergency 0x{message.code:04X}"
        self._report(BusEventKind.EMERGENCY, slave, message.code, text, data)

    def _reached(self, slave: BusSlave, state: AlState) -> None:
        self._report(BusEventKind.STATE, slave, state, f"{slave.name}: {state.name}")

    def _clock_warning(self, slave: BusSlave) -> None:
        self._report(
            BusEventKind.CLOCK,
            slave,
            slave.clock_difference_ns,
            f"{slave.name}: clock is {slave.clock_difference_ns} ns from the reference",
        )
