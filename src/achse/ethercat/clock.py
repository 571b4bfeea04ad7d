"""Distributed clock of one slave: local time, system time, SYNC0/1 and latches.

Times are integer nanoseconds. All slaves of a segment see one true time; each has its own local
time, which may start elsewhere, drift and jitter.

Source: ETG.1000.4 §6.8, tables 60 and 61.
"""

from collections.abc import Callable
from random import Random

from achse.ethercat.registers import Register

_U32 = 0xFFFF_FFFF
_U64 = 0xFFFF_FFFF_FFFF_FFFF

_TIME, _DIFFERENCE = Register.SYSTEM_TIME.place, Register.SYSTEM_TIME_DIFFERENCE.place
"""Written in each cycle of the bus, where looking up a member would take as long as the rest."""

_CYCLIC = 0x01
_SYNC0 = 0x02
_SYNC1 = 0x04

_MAX_CORRECTION = 1000
"""The time loop moves the system time by at most this much per comparison."""

_ASTRAY = 4
"""A difference of more than this part of the SYNC0 cycle: SYNC0 and process data fall apart."""

_PROPORTIONAL = 4
_INTEGRAL = 64
"""Divisors of the time loop: a difference dies out within some ten comparisons."""


class Instant:
    """The present true time, shared by all slaves of a segment.

    No slave has anything to do before `due_ns`. `changes` counts what changes the difference
    between a clock and the reference, but for time itself.
    """

    __slots__ = ("changes", "due_ns", "now_ns")

    def __init__(self) -> None:
        self.now_ns = self.due_ns = self.changes = 0


class DistributedClock:
    """The clock registers in `memory`; `offset_ns`, `drift_ppb` and `jitter_ns` disturb it.

    `reschedule` is called when the time of the next SYNC0 event has changed.
    """

    def __init__(self, memory: bytearray, time: Instant, reschedule: Callable[[], None]) -> None:
        self.time = time
        self._own_offset = 0
        self.jitter_ns = 0
        self.port_delays: tuple[int | None, ...] = (0, None, None, None)
        """Delays after which each port receives a frame that enters the segment now, ns."""
        self.arrival_ns = 0
        """The same for port 0: when a frame that is processed now passes here."""
        self.cycle_ns = 0
        """Cycle of SYNC0 while it is switched on, else 0."""
        self.sync0_due_ns: int | None = None
        """True time of the next SYNC0 event, None if there will be none."""
        self.astray = False
        """True if the clock was further than a quarter of the SYNC0 cycle from the reference, at
        the last comparison."""
        self._memory = memory
        self._reschedule = reschedule
        self._dice = Random(0)
        self._drift_ppb = 0
        self._drift_since = 0
        self._drifted = 0
        self._offset = self._delay = 0
        self._correction = self._rate = self._difference = 0
        self._jumped = False
        self._next_sync0: int | None = None
        self._next_sync1: int | None = None
        """The first SYNC1 event that the device has not seen."""
        self._sync1_period = 0

    def reset(self) -> None:
        """Apply the registers' defaults."""
        self._offset = self._delay = 0
        self._correction = self._rate = self._difference = 0
        self.astray = False
        self.activate()

    # local and system time

    @property
    def offset_ns(self) -> int:
        """Lead of the local time over the true time at the start, ns."""
        return self._own_offset

    @offset_ns.setter
    def offset_ns(self, value: int) -> None:
        self._own_offset = value
        self.time.changes += 1

    @property
    def drift_ppb(self) -> int:
        """Drift of the local time, 10⁻⁹; above 0 it runs fast."""
        return self._drift_ppb

    @drift_ppb.setter
    def drift_ppb(self, value: int) -> None:
        self._drifted = self._drift(self.time.now_ns)
        self._drift_since = self.time.now_ns
        self._drift_ppb = value
        self._move()

    def jump(self, by_ns: int) -> None:
        """Change the local time at once; SYNC0 comes at the next of its times."""
        self.offset_ns += by_ns
        self._jumped = True
        if self._next_sync0 is not None and self.cycle_ns:
            self._next_sync0 = self._after(self._next_sync0, self.cycle_ns)
        self._move()

    @property
    def steady(self) -> bool:
        """True if the clock neither drifts nor is corrected, and no frame has to see that it
        jumped."""
        return not (self._drift_ppb or self._difference or self._rate or self._jumped)

    def _drift(self, now_ns: int) -> int:
        return self._drifted + (now_ns - self._drift_since) * self._drift_ppb // 10**9

    def local_time(self, now_ns: int) -> int:
        return now_ns + self._own_offset + self._drift(now_ns)

    def system_time(self, now_ns: int) -> int:
        """Return the local copy of the system time at a true time."""
        drift = self._drift(now_ns) if self._drift_ppb else self._drifted
        return now_ns + self._own_offset + drift + self._offset + self._correction & _U64

    def registers_written(self) -> None:
        """Apply system time offset or delay, which have been written."""
        memory = self._memory
        self._offset = Register.SYSTEM_TIME_OFFSET.get(memory)
        self._delay = Register.SYSTEM_TIME_DELAY.get(memory)
        self._move()

    def passing_time(self) -> int:
        """System time when the frame that is processed now passes here."""
        return self.system_time(self.time.now_ns + self.arrival_ns)

    def latch_receive_times(self) -> None:
        """Note when the frame that writes receive time port 0 passes each port and the unit."""
        memory = self._memory
        jitter = self._dice.randint(-self.jitter_ns, self.jitter_ns) if self.jitter_ns else 0
        now_ns = self.time.now_ns + jitter
        for port, delay in enumerate(self.port_delays):
            if delay is not None:
                local = self.local_time(now_ns + delay) & _U32
                first = Register.RECEIVE_TIME_PORT_0 + 4 * port
                memory[first : first + 4] = local.to_bytes(4, "little")
        local = self.local_time(now_ns + self.arrival_ns) & _U64
        Register.RECEIVE_TIME_UNIT.set(memory, local)

    def feed(self, data: bytes | bytearray) -> None:
        """Compare the reference time of a passing write, and steer the system time."""
        self.compare(int.from_bytes(data, "little"), 8 * len(data))

    def compare(self, reference: int, bits: int = 64) -> bool:
        """Return the same with the lowest `bits` bits of the reference time as a number.

        False if the next comparison is as this one unless `changes` of the time count on: there is
        no difference, and the clock does not drift.
        """
        difference = self.passing_time() - reference - self._delay & (1 << bits) - 1
        if difference >> bits - 1:
            difference -= 1 << bits
        self._difference = difference
        self._jumped = False
        if difference or self._rate:
            self.time.changes += 1
            self._correction -= _clamped(difference // _PROPORTIONAL + self._rate)
            self._rate = _clamped(self._rate + difference // _INTEGRAL)
            self.astray = _ASTRAY * abs(difference) > self.cycle_ns > 0
            self._schedule()
            return True
        return self._drift_ppb != 0

    def restart_loop(self) -> None:
        """Reset the time loop: the speed counter start has been written."""
        self._rate = self._difference = 0
        self.astray = False

    def live_blocks(self) -> dict[int, Callable[[int, int], None]]:
        """Blocks of 16 bytes of registers that are brought up to date before they are read."""
        return {
            Register.SYSTEM_TIME >> 4: lambda _, __: self.refresh_times(),
            Register.SYSTEM_TIME_DIFFERENCE >> 4: lambda _, __: self.refresh_times(),
            Register.START_TIME >> 4: lambda _, __: self.refresh_start(),
        }

    def refresh_times(self) -> None:
        """Bring system time and its difference up to date."""
        memory = self._memory
        self._jumped = False
        memory[_TIME] = self.passing_time().to_bytes(8, "little")
        difference = min(abs(self._difference), 0x7FFF_FFFF)
        if self._difference < 0:
            difference |= 0x8000_0000
        memory[_DIFFERENCE] = difference.to_bytes(4, "little")

    # SYNC0

    def activate(self) -> None:
        """Arm SYNC0 for its start time, which must be in the future: activation was written."""
        memory = self._memory
        self.cycle_ns = 0
        self._next_sync0 = self._next_sync1 = None
        if self.sync0_on:
            self.cycle_ns = Register.SYNC0_CYCLE.get(memory)
            start = Register.START_TIME.get(memory)
            if self.cycle_ns and start >= self.system_time(self.time.now_ns):
                self._next_sync0 = start
                if memory[Register.ACTIVATION] & _SYNC1:
                    self._activate_sync1(start)
        self._move()

    def _activate_sync1(self, start: int) -> None:
        """Arm SYNC1: it follows a SYNC0 event by its cycle time; the next SYNC0 starts it again."""
        delay = Register.SYNC1_CYCLE.get(self._memory)
        self._sync1_period = (delay // self.cycle_ns + 1) * self.cycle_ns
        self._next_sync1 = start + delay

    @property
    def sync0_on(self) -> bool:
        """True if the master has switched SYNC0 on, even before the first SYNC0."""
        return self._memory[Register.ACTIVATION] & (_CYCLIC | _SYNC0) == _CYCLIC | _SYNC0

    def _move(self) -> None:
        """Note another time of the next event."""
        self.time.changes += 1
        self._schedule()
        self._reschedule()

    def _schedule(self) -> None:
        """Find the true time of the next event."""
        if self._next_sync0 is None:
            self.sync0_due_ns = None
            return
        now_ns = self.time.now_ns
        ahead = self._next_sync0 - self.system_time(now_ns)
        if self._drift_ppb:
            ahead = -(-ahead * 10**9 // (10**9 + self._drift_ppb))
        self.sync0_due_ns = now_ns + max(ahead, 0)

    def sync0(self, elapsed_ns: int) -> int | None:
        """SYNC0 events of `elapsed_ns`, a multiple of the cycle, happen: when the next is due."""
        if self._next_sync0 is not None and self.sync0_due_ns is not None:
            self._next_sync0 += elapsed_ns
            if self._drift_ppb:
                self._schedule()
            else:
                self.sync0_due_ns += elapsed_ns
        return self.sync0_due_ns

    def refresh_start(self) -> None:
        """Update start time and next SYNC1 to the next events, while they run."""
        if self._next_sync0 is not None:
            Register.START_TIME.set(self._memory, self._next_sync0 & _U64)
        if self._next_sync1 is not None:
            value = self._after(self._next_sync1, self._sync1_period) & _U64
            Register.NEXT_SYNC1.set(self._memory, value)

    def _after(self, event: int, period: int) -> int:
        """Return the next event from now on of those that come every `period`."""
        behind = self.system_time(self.time.now_ns) - event
        return event if behind < 0 else event + (behind // period + 1) * period

    @property
    def sync0_pending(self) -> bool:
        """True if a SYNC0 event came that the device has not seen."""
        return self._pending(self._next_sync0)

    @property
    def sync1_pending(self) -> bool:
        """True if a SYNC1 event came that the device has not seen."""
        return self._pending(self._next_sync1)

    def _pending(self, event: int | None) -> bool:
        return event is not None and event <= self.system_time(self.time.now_ns)

    def sync0_seen(self) -> None:
        """Note that the device has seen SYNC0 events up to now."""
        if self._next_sync0 is not None and self.cycle_ns:
            self._next_sync0 = self._after(self._next_sync0, self.cycle_ns)
            self._move()

    def sync1_seen(self) -> None:
        """Note that the device has seen SYNC1 events up to now."""
        if self._next_sync1 is not None:
            self._next_sync1 = self._after(self._next_sync1, self._sync1_period)

    # latches

    def latch(self, unit: int, rising: bool) -> bool:
        """Return an edge at latch input 0 or 1; True if its time was taken."""
        edge = 0 if rising else 1
        memory = self._memory
        bit = 1 << edge
        single = memory[Register.LATCH_CONTROL + unit] & bit
        if single and memory[Register.LATCH_STATUS + unit] & bit:
            return False
        memory[Register.LATCH_STATUS + unit] |= bit
        address = Register.LATCH_TIMES + 16 * unit + 8 * edge
        system = self.system_time(self.time.now_ns)
        memory[address : address + 8] = system.to_bytes(8, "little")
        return True

    @property
    def latched(self) -> bool:
        """True if a latch time waits to be read."""
        return bool(Register.LATCH_STATUS.get(self._memory) & 0x0303)

    def latch_times_read(self, first: int, end: int) -> None:
        """Release the times whose first byte the master read with `first` to `end` - 1."""
        for slot in range(4):
            if first <= Register.LATCH_TIMES + 8 * slot < end:
                self._memory[Register.LATCH_STATUS + slot // 2] &= ~(1 << slot % 2)


def _clamped(value: int) -> int:
    return max(-_MAX_CORRECTION, min(_MAX_CORRECTION, value))
