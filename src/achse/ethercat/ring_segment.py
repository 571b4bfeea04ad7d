"""A ring: a line of slaves whose end is connected to the master's second adapter.

A frame that enters by port 0 of a slave is processed, one that comes the other way passes as it is
until a port without link turns it round. With a cable cut in the middle each adapter has its part
of the slaves.

Source: ETG.1000.4 §6.1.4 for ports and their order; ETG.1500 for cable redundancy.
"""

from collections.abc import Iterable

from achse.ethercat.frame import payload_offset
from achse.ethercat.frame_plan import FramePlan
from achse.ethercat.logical import Plan
from achse.ethercat.registers import Register
from achse.ethercat.segment import HOP_NS, Segment, clocked_of
from achse.ethercat.slave import Slave

_OUT = 1
"""The port to the next slave."""


class RingSegment(Segment):
    """Slaves in a line between two adapters of the master: 0 at port 0 of the first, 1 at the end.

    The cables are counted from 0, before the first slave, to the number of slaves, behind the last.
    """

    def __init__(
        self, slaves: Iterable[Slave] = (), *, cycle_ns: int = 0, hop_ns: int = HOP_NS
    ) -> None:
        self._end_whole = True
        """The cable at the second adapter."""
        self._adapters = [True, True]
        """Link state of each adapter, True with a link."""
        self._closed = False
        """True if the frame passes the whole ring."""
        self._returns = False
        """True if frames of the second adapter reach a slave."""
        self._far: list[Slave] = []
        self._far_plans: dict[tuple[int, int, int], Plan] = {}
        self._far_frame_plans: dict[tuple[int, int], FramePlan] = {}
        self._far_stations: dict[int, list[Slave]] = {}
        self._far_clocked: list[Slave] = []
        self._far_in_step: tuple[int, int, int] | None = None
        super().__init__(slaves, cycle_ns=cycle_ns, hop_ns=hop_ns)

    @property
    def parts(self) -> tuple[int, int]:
        """Number of slaves that process the frames of each adapter."""
        return len(self._order), len(self._far)

    @property
    def whole(self) -> bool:
        """True if the ring is closed."""
        return self._closed

    def cut(self, cable: int) -> None:
        """Cut a cable. ValueError if there is none with that number."""
        if cable == len(self._places):
            self._cut_end()
        else:
            self.break_link(self._slave_behind(cable))

    def mend(self, cable: int) -> None:
        """Mend a cable. ValueError if there is none with that number."""
        if cable == len(self._places):
            self._mend_end()
        else:
            self.repair_link(self._slave_behind(cable))

    def _slave_behind(self, cable: int) -> Slave:
        if not 0 <= cable < len(self._slaves):
            raise ValueError(f"cable: expected 0..{len(self._slaves)}, got {cable}")
        return self._slaves[cable]

    def connect(self, adapter: int, linked: bool) -> None:
        """Set the link state of an adapter (0, 1); without a link its cable counts as cut."""
        if self._adapters[adapter] == linked:
            return
        self._adapters[adapter] = linked
        esc = self._places[-adapter].slave.esc
        if linked:
            esc.open_with_link(adapter)
        else:
            esc.count(Register.LOST_LINKS + adapter)
        self._route()

    def _cut_end(self) -> None:
        if self._end_whole:
            self._end_whole = False
            if self._places:
                self._places[-1].slave.esc.count(Register.LOST_LINKS + _OUT)
            self._route()

    def _mend_end(self) -> None:
        self._end_whole = True
        if self._places:
            self._places[-1].slave.esc.open_with_link(_OUT)
        self._route()

    def process_from(self, adapter: int, frame: bytes) -> tuple[bytes, int] | None:
        """Return a frame of one adapter: as it comes back, and to which one; None if it is lost."""
        if adapter == 0:
            reply = super().process(frame)
            return None if reply is None else (reply, int(self._closed))
        if not self._returns:
            self.counters.lost += 1
            return None
        if self._closed:
            passed = bytearray(frame)
            if payload_offset(frame) is not None:
                passed[6] |= 0x02
            return bytes(passed), 0
        self._swap()
        clock = self.cycle_ns
        if self._far:  # the copies at the first adapter are the clock
            self.cycle_ns = 0
        try:
            reply = super().process(frame)
        finally:
            self.cycle_ns = clock
            self._swap()
        return None if reply is None else (reply, 1)

    def _swap(self) -> None:
        self._order, self._far = self._far, self._order
        self._plans, self._far_plans = self._far_plans, self._plans
        self._frame_plans, self._far_frame_plans = self._far_frame_plans, self._frame_plans
        self._stations, self._far_stations = self._far_stations, self._stations
        self._clocked, self._far_clocked = self._far_clocked, self._clocked
        self._in_step, self._far_in_step = self._far_in_step, self._in_step

    def _remapped(self) -> None:
        super()._remapped()
        self._far_plans.clear()
        self._far_frame_plans.clear()

    def _readdressed(self) -> None:
        self._far_stations.clear()
        super()._readdressed()

    def _route(self) -> None:
        """Update which slaves each adapter reaches, and when frames pass them."""
        places = self._places
        last = len(places) - 1
        linked = [place.whole for place in places]
        linked[:1] = [linked[0] and self._adapters[0]] if places else []
        linked.append(self._end_whole and self._adapters[1])
        opened = [
            place.slave.esc.set_links([linked[number], linked[number + 1], False, False])
            for number, place in enumerate(places)
        ]
        cuts = [number for number in range(len(places)) if not linked[number]]
        self._returns = bool(opened) and opened[last][_OUT]
        self._closed = self._returns and not cuts
        near = places[: cuts[0] if cuts else len(places)]
        far = places[cuts[-1] :] if cuts and self._returns else []
        self._order = [place.slave for place in near]
        self._far = [place.slave for place in far]
        self._clocked, self._far_clocked = clocked_of(self._order), clocked_of(self._far)
        self._in_step = self._far_in_step = None
        self._endless = False
        hop = self.hop_ns
        begin = hop
        for part in (self._order, self._far):
            for number, slave in enumerate(part):
                arrival = begin + number * hop
                back = begin + (2 * len(part) - number - 2) * hop
                behind = number + 1 < len(part) and not self._closed
                slave.esc.clock.arrival_ns = arrival
                slave.esc.clock.port_delays = (arrival, back if behind else None, None, None)
            begin = (len(self._far) + 1) * hop
        self._readdressed()
        self._collect_irq()

    def _collect_irq(self) -> None:
        self._irq = 0
        for slave in (*self._order, *self._far):
            self._irq |= slave.esc.irq
