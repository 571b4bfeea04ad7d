"""VirtualDrive: a drive together with the simplest master, for tests and for trying things out.

Time is virtual: `run` lets it pass, and whatever waits does so in that time.
"""

from collections.abc import Callable
from typing import Any

from achse.codes import AlState, AlStatus
from achse.codes.cia import Number
from achse.drive.drive import Drive
from achse.drive.modes import Mode
from achse.drive.objects import find
from achse.drive.power import PowerState

_UPWARD = (AlState.INIT, AlState.PREOP, AlState.SAFEOP, AlState.OP)
_FAULT_RESET = 0x80
_START = 0x10


class DriveTimeout(TimeoutError):
    """Time-out while waiting for a condition of the drive."""


class VirtualDrive(Drive):
    """A drive that is in Op at once, with one call for what a master does in many cycles.

    `cycle` is the communication cycle in seconds. Arguments are those of `Drive`.
    """

    def __init__(self, *arguments: Any, cycle: float = 0.001, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.cycle_ns = round(cycle * 1e9)
        self.time_ns = 0
        self.bring_up()

    def bring_up(self, state: AlState = AlState.OP, sync0_ns: int = 0) -> None:
        """Lead communication to `state`, step by step."""
        while self.state > state:
            self.enter(_UPWARD[_UPWARD.index(self.state) - 1], sync0_ns, AlStatus.NO_ERROR)
            self.cycle()
        while self.state < state:
            self.enter(_UPWARD[_UPWARD.index(self.state) + 1], sync0_ns, AlStatus.NO_ERROR)
            self.cycle()

    def put(self, index: int, value: Number, subindex: int = 0) -> None:
        """Write an object as process data do: at once, whatever the mapping holds."""
        row = find(index, subindex)
        row.check(value)
        setattr(self.record, row.place, value)

    def cycle(self, count: int = 1) -> None:
        """Let communication cycles pass, each with fresh outputs."""
        for _ in range(count):
            self.record.fresh_outputs = 1
            self.step(self.cycle_ns)
            self.time_ns += self.cycle_ns

    def run(self, seconds: float) -> None:
        """Let time pass, in whole communication cycles."""
        self.cycle(round(seconds * 1e9 / self.cycle_ns))

    def wait(self, condition: Callable[[], object], seconds: float, what: str = "") -> None:
        """Let time pass until the condition holds; `DriveTimeout` if it does not."""
        end = self.time_ns + round(seconds * 1e9)
        while not condition():
            if self.time_ns >= end:
                raise DriveTimeout(f"{what or 'condition'} not met within {seconds} s: {self!r}")
            self.cycle()

    def control(self, word: int, cycles: int = 1) -> int:
        """Send a controlword; the statusword after so many cycles."""
        self.put(0x6040, word)
        self.cycle(cycles)
        return self.statusword

    @property
    def statusword(self) -> int:
        return self.record.statusword

    @property
    def position(self) -> int:
        """6064h, inc."""
        return self.record.position_actual

    def enable(self, mode: Mode) -> None:
        """Choose a mode and enable operation; csp targets start at the present position."""
        if self.power_state == PowerState.FAULT:
            self.reset_fault()
        self.put(0x6060, mode)
        self.put(0x607A, self.position)
        self.control(0x06, 2)
        self.control(0x07)
        self.put(0x6040, 0x0F)
        self.wait(lambda: self.power_state == PowerState.OPERATION_ENABLED, 0.1, "enabling")

    def disable(self) -> None:
        """Disable voltage."""
        self.control(0)

    def reset_fault(self) -> None:
        """Run one rising edge of bit 7; `DriveTimeout` if the fault stays."""
        self.control(0)
        self.control(_FAULT_RESET)
        self.control(0)
        if self.power_state == PowerState.FAULT:
            raise DriveTimeout(f"fault {self.record.error_code:#06x} stays: {self!r}")

    def move_to(self, position: int, *, relative: bool = False, seconds: float = 60.0) -> None:
        """Do a whole move in pp, with its handshake, until target reached."""
        self.put(0x607A, position)
        self.control(0x0F)
        self.control(0x5F if relative else 0x1F)
        self.control(0x0F)
        self.wait(lambda: self.statusword & 0x0400, seconds, "target reached")

    def home(self, method: int, *, offset: int = 0, seconds: float = 60.0) -> None:
        """Do a whole homing in hm. Raises `DriveTimeout`, also on a homing error."""
        self.put(0x6098, method)
        self.put(0x607C, offset)
        self.control(0x0F)
        self.control(0x0F | _START)
        self.wait(lambda: self.statusword & 0x3400 in (0x1400, 0x2400), seconds, "homing")
        if self.statusword & 0x2000:
            raise DriveTimeout(f"homing method {method} failed: {self!r}")
