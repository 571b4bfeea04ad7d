"""An EtherCAT bus of a station on a network interface: slaves of other processes, or real ones.

The interface is opened and its slaves are searched while the station runs: nothing waits for them.
Until they are found, and whenever they are gone, axes are without valid data (0x4655).
"""

import hashlib
import logging
import time
from collections import Counter
from collections.abc import Callable, Sequence

from achse.codes import AlState
from achse.drive import Drive
from achse.ethercat.frame import Datagram, DatagramCommand, EthercatFrame
from achse.ethercat.master import BusConfiguration, BusError, BusJob, BusSlave, Master
from achse.ethercat.master.inspection import match
from achse.ethercat.master.redundancy import Redundancy
from achse.ethercat.master.scanning import ScannedSlave, scan_bus
from achse.ethercat.master.traffic import AcyclicTraffic
from achse.ethercat.registers import Register
from achse.station.buses.ethercat_bus import log_event, slaves_digest
from achse.station.buses.frame_link import BusLink, RoundTrips
from achse.station.buses.interface_pair import BusSocket, InterfacePair
from achse.station.buses.plan import BusPlan
from achse.station.buses.reference_pace import ReferencePace
from achse.station.buses.virtual_drives import make_drives, torque_per_acceleration
from achse.station.configuration.bus import DriveConfig
from achse.transport.ethernet import EthernetLink, LinkError

log = logging.getLogger("achse.bus")

_AGAIN_NS = 1_000_000_000
"""Until the interface is opened, or the bus is searched, once more."""
_LOOK_NS = 100_000_000
_TIMEOUT_NS = 20_000_000
"""Time after which a frame of a search counts as lost."""
_TURN_NS = 250_000
"""Longest wait of a search for a frame; a quarter of the cycle is used for that."""
_SEARCH_PATIENCE_NS = 5_000_000
"""In a ring: how long one copy of a frame of a search waits for the other."""


def open_interface(interface: str) -> BusSocket:
    """Return a raw socket on the interface, which no other master of achse has. Raises
    LinkError."""
    return EthernetLink(interface, alone=True)


class InterfaceBus:
    """One bus on `interface`, a redundant one on `second_interface` too; `slaves` are in
    the order of the drives of `plan`.

    In each cycle `take` brings what has come since the last one, `exchange` sends. `trouble` says
    why the bus does not work as configured, empty if it does. After a search with another result
    than before there is another `master`; `on_renewal` is called.
    """

    faults = None
    """Of drives in another process, or real ones."""

    def __init__(
        self,
        plan: BusPlan,
        interface: str,
        *,
        open_link: Callable[[str], BusSocket] = open_interface,
        make_way: Callable[[Master, BusSocket], BusLink] = BusLink,
        clock: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        """`make_way` joins a master to the open interface; `clock` is that of the computer in ns.

        A test hands another clock in, in both places.
        """
        self.plan = plan
        self.interface = interface
        self.second_interface = plan.bus.redundant if isinstance(plan.bus.redundant, str) else ""
        self._where = " and ".join(filter(None, (interface, self.second_interface)))
        self.cycle_ns = plan.cycle_ns
        self.now_ns = 0
        self.bank = None
        self.drives: Sequence[Drive] = ()
        """None: they are not in this process."""
        self._fault = self.trouble = f"{self._where} is not open yet"
        self.round_trips = RoundTrips()
        self.searches = 0
        """Number of searches that found slaves."""
        self.at_rest: Callable[[], bool] = lambda: True
        """Returns True if nothing moves that a search would stop."""
        self._open_link, self._make_way = open_link, make_way
        self._clock, self._zero_ns = clock, clock()
        self._socket: BusSocket | None = None
        self._way: BusLink | None = None
        """None as long as the slaves are not found."""
        self._search: tuple[AcyclicTraffic, BusJob[list[ScannedSlave]]] | None = None
        self._departing_masters: list[Master] = []
        self._renewals: list[Callable[[], None]] = []
        self.reference = ReferencePace(plan.cycle_ns)
        """Phase of the frames in the cycle of the reference clock."""
        self.steer: Callable[[int], None] | None = None
        """Lets the next cycles of the station begin later, ns; None: its pace is the computer's."""
        self._in_vain = False
        """True if the interface could not be opened, or the last search of it failed."""
        self._again_ns = self._look_ns = 0
        self._misfits: Counter[tuple[int, int, int, int]] = Counter()
        """Identities of slaves that were found and cannot be what the tables say."""
        self._torques = [
            torque_per_acceleration(make_drives([slot.device])[0])
            for slot in plan.slots
            if isinstance(slot.device, DriveConfig)
        ]
        self.master: Master
        self._configure(plan.expected())

    # slaves

    def _configure(self, configuration: BusConfiguration) -> None:
        """Create another master, if the bus is another than before."""
        before = getattr(self, "master", None)
        if before is not None and before.bus == configuration:
            return
        self.master = Master(configuration)
        self.master.now_ns = self._link_ns()
        self.master.on_event = log_event
        state = AlState.OP if before is None else before.requested_state
        self.master.request(state)
        stations = [configuration.stations().index(1001 + slot.place) for slot in self.plan.slots]
        slaves = [self.master.slaves[number] for number in stations]
        self.slaves: Sequence[BusSlave] = slaves[: len(self._torques)]
        self.terminal_slaves: Sequence[BusSlave] = slaves[len(self._torques) :]
        if before is not None:
            before.on_event = None
            self._departing_masters.append(before)
            for renewed in self._renewals:
                renewed()

    def absent(self, slave: BusSlave) -> bool:
        """Return True if the bus was searched, and the slave does not answer."""
        return self.master.absent(slave) if self._way is not None else self._in_vain

    def on_renewal(self, renewed: Callable[[], None]) -> None:
        """Call `renewed` whenever `master` and its slaves are others."""
        self._renewals.append(renewed)

    def torque_per_acceleration(self, number: int) -> float:
        """‰ for an increment a second² at drive `number`, as its [drive.machine] says."""
        return self._torques[number]

    # the cycle

    def _link_ns(self) -> int:
        """Return the time that frames and slaves live by: the computer's, since this bus was made.

        A station that catches up does many cycles in a moment; a slave has not got more time then.
        """
        return self._clock() - self._zero_ns

    def take(self) -> None:
        """Process the frames that came since the last cycle."""
        if self._way is not None:
            self._way.take(self._link_ns())
            if self.steer is not None:
                self.steer(self.reference.take(self.master.cyclic.reference_ns))
        elif self._search is not None:
            self._go_on_searching()

    def exchange(self) -> None:
        """Send outputs and requests; the returning frames are for the next cycle."""
        self.now_ns += self.cycle_ns
        now = self._link_ns()
        if self._way is not None:
            self._way.send(now)
            if now >= self._look_ns:
                self._look_ns = now + _LOOK_NS
                self._look()
        else:
            self.master.poll(now)  # requests end: nothing answers
            if now >= self._again_ns and self._search is None:
                self._begin()
        if self._departing_masters:
            self._end_left()

    def _end_left(self) -> None:
        """End the requests to a master that is gone, each with its error."""
        for master in self._departing_masters:
            master.poll(self._link_ns(), 4)
        self._departing_masters = [
            each for each in self._departing_masters if each.traffic.waiting > 1
        ]

    def _report(self, fault: str) -> None:
        """Say what is wrong, once."""
        self._fault = fault
        pair = self._socket if isinstance(self._socket, InterfacePair) else None
        trouble = "; ".join(filter(None, (fault, pair.trouble if pair else "")))
        if trouble != self.trouble:
            self.trouble = trouble
            if trouble:
                log.warning("%s: %s", self.plan.bus.name, trouble)
            else:
                log.info("%s: complete on %s", self.plan.bus.name, self._where)

    def _open(self) -> BusSocket:
        """Return the interface, or both."""
        if not self.second_interface:
            return self._open_link(self.interface)
        return InterfacePair((self.interface, self.second_interface), self._open_link)

    def _fail(self, trouble: str) -> None:
        """Report that no slave is on the interface."""
        self._in_vain = True
        self._report(trouble)

    def _begin(self) -> None:
        """Open the interface if it is not, and search the slaves."""
        self._again_ns = self._link_ns() + _AGAIN_NS
        if self._socket is not None and self._socket.gone:
            self.close()
        if self._socket is None:
            try:
                self._socket = self._open()
            except LinkError as refusal:
                self._fail(str(refusal))
                return
            except OSError as failure:
                self._fail(f"{self.interface}: {failure.strerror}")
                return
        if isinstance(self._socket, InterfacePair):
            self._socket.begin(Redundancy(), _SEARCH_PATIENCE_NS)
        while self._socket.receive(0.0) is not None:
            pass
        traffic = AcyclicTraffic(max(_TIMEOUT_NS, 4 * self.cycle_ns))
        self._search = traffic, traffic.start(scan_bus(with_objects=self.plan.own_mapping))

    def _go_on_searching(self) -> None:
        """Send frames of the search, as many as about a quarter of the cycle has time for."""
        assert self._search is not None
        assert self._socket is not None
        traffic, job = self._search
        socket = self._socket
        for _ in range(max(self.cycle_ns // (4 * _TURN_NS), 1)):
            while (came := socket.receive(0.0)) is not None:
                traffic.receive(came, self._link_ns())
            frames = traffic.frames(self._link_ns(), 4)
            if job.is_done:
                break
            for frame in frames:
                socket.send(frame)
            if not frames and traffic.idle:
                return
            came = socket.receive(_TURN_NS / 1e9)
            if came is not None:
                traffic.receive(came, self._link_ns())
        if job.is_done:
            self._search = None
            self._take_over(job)

    def _take_over(self, job: BusJob[list[ScannedSlave]]) -> None:
        """Go on with what the search found."""
        try:
            result = job.result()
        except BusError as trouble:
            self._fail(f"{self._where}: {trouble}")
            return
        self._in_vain = False
        configuration, faults = self.plan.configuration_of(result)
        self.searches += 1
        identities = [each.facts.identity for each in result]
        places = match(configuration.slaves, identities)
        self._misfits = Counter(
            each for each, place in zip(identities, places, strict=True) if place is None
        )
        self._configure(configuration)
        assert self._socket is not None
        if isinstance(self._socket, InterfacePair):
            assert self.master.redundancy is not None
            self._socket.begin(self.master.redundancy, 3 * self.cycle_ns // 8)
        self._way = self._make_way(self.master, self._socket)
        self._way.round_trips = self.round_trips
        self._look_ns = self._link_ns() + _LOOK_NS
        self._report("; ".join(faults))

    def _look(self) -> None:
        """Check that the interface still exists, and that no unknown slave has come."""
        assert self._socket is not None
        if self._socket.gone:
            self._leave()
            self.close()
            self._fail(f"{self._where} is gone")
            return
        pair = self._socket if isinstance(self._socket, InterfacePair) else None
        if pair or self.trouble:
            self._report("" if self.master.operational else self._fault)
        supervision = self.master.supervision
        if not Counter(supervision.strangers) - self._misfits:
            return
        if self.at_rest():
            log.info("%s: other slaves than before, searched again", self.plan.bus.name)
            self._leave()
        else:
            self._report(
                f"{self._where} has other slaves than before: searched again when no axis is"
                " enabled"
            )

    def _leave(self) -> None:
        """Stop the frames; the bus is searched again."""
        self._way = None
        self._again_ns = self._link_ns()

    def close(self) -> None:
        """Let go of the interface, the slaves in Init; the next cycle opens it again."""
        if self._search is not None:
            self._search[1].cancel()
            self._search = None
        socket, self._socket = self._socket, None
        self._way = None
        if socket is not None:
            init = Datagram.at(DatagramCommand.BWR, 0, Register.AL_CONTROL, b"\x11\0")
            socket.send(EthercatFrame([init]).encode())
            socket.close()

    def digest(self) -> bytes:
        """States of slaves, and their process data."""
        state = hashlib.blake2b(self.now_ns.to_bytes(8, "little"))
        state.update(slaves_digest(self.master.slaves))
        return state.digest()
