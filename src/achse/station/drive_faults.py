"""Faults of drives on a bus: the kinds, what each does to a segment, and the list of what is on.

The same table is read by Python, by scripts (TOML) and by the command line. A fault begins and ends
at times of the segment, so that a test in virtual time sees it at the same cycle every time.
"""

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from typing import Any, ClassVar, Self

from achse.drive import Alarm, Drive, InputBit, Warn
from achse.ethercat import Disturbance, Segment, Slave
from achse.station.fault import FaultError, FaultFields, FaultKind, seconds

__all__ = ["DRIVE_FAULT_KINDS", "ActiveDriveFault", "DriveFault", "DriveFaults"]

_DRIVE = frozenset({"drive"})
_ENDLESS = 1 << 60
_BROKEN_CHECKSUM = 14
"""The byte of the EEPROM that is damaged."""

DRIVE_FAULT_KINDS: Mapping[str, FaultKind] = {
    kind.name: kind
    for kind in (
        FaultKind(
            "alarm",
            _DRIVE | {"code"},
            "The drive has the alarm `code`: number in 603Fh, panel number (AL.720) or name. Its"
            " cause stays until the fault ends; then the master resets it.",
            ("code",),
        ),
        FaultKind(
            "warning",
            _DRIVE | {"code"},
            "The drive shows the warning `code`, a panel number (AL.910) or name, in 3110h, 3111h.",
            ("code",),
        ),
        FaultKind(
            "encoder_loss",
            _DRIVE | {"code"},
            "The encoder answers no longer: the motor coasts, with an encoder alarm (`code`).",
        ),
        FaultKind("sto", _DRIVE, "Both safety inputs are off: STO."),
        FaultKind("safety", _DRIVE, "One of the two safety inputs is off."),
        FaultKind(
            "overtravel",
            _DRIVE | {"side"},
            "The limit switch at `side` (positive, negative) is on, wherever the machine is.",
        ),
        FaultKind(
            "input",
            _DRIVE | {"code", "side"},
            "The input `code` (HOME, I1 to I8) is held `side`: on or off.",
            ("code",),
        ),
        FaultKind("main_power", _DRIVE, "Main power is off."),
        FaultKind(
            "load",
            _DRIVE | {"by"},
            "Something pushes against positive direction with `by` ‰ of rated torque.",
            ("by",),
        ),
        FaultKind("jam", _DRIVE, "The machine is blocked where it stands."),
        FaultKind("yaw_alarm", _DRIVE, "The other drive of the gantry has an alarm."),
        FaultKind(
            "local_control",
            _DRIVE,
            "Somebody operates the drive at its panel: not in communication mode, it falls to Init"
            " with AL status code 0x8000 and does not leave it.",
        ),
        FaultKind(
            "mailbox_delay", _DRIVE | {"by"}, "Mailbox answers come `by` seconds late.", ("by",)
        ),
        FaultKind(
            "hang",
            _DRIVE,
            "The drive's program hangs: frames pass and count, but nothing is done or answered, and"
            " the PDI watchdog expires.",
        ),
        FaultKind(
            "lost_frames",
            frozenset({"count"}),
            "Frames do not come back: the next `count`, or all.",
        ),
        FaultKind(
            "wrong_counter",
            frozenset({"count", "by"}),
            "The working counters of the next `count` frames, or of all, are wrong by `by`.",
            ("by",),
        ),
        FaultKind(
            "link_break",
            _DRIVE,
            "The cable before the drive is broken: it and all behind it are out of reach.",
        ),
        FaultKind(
            "eeprom",
            _DRIVE,
            "The checksum of the EEPROM is wrong. The drive sees it when the controller is reset"
            " or loads the EEPROM anew, and comes back when it does so after the fault.",
        ),
        FaultKind(
            "clock_drift",
            _DRIVE | {"by"},
            "The drive's own clock runs `by` ppm too fast; the distributed clocks have to follow.",
            ("by",),
        ),
        FaultKind(
            "clock_jitter", _DRIVE | {"by"}, "Receive times are off by up to `by` seconds.", ("by",)
        ),
    )
}
"""Every kind of fault a bus of drives can have."""

_CODES = {
    "input": ", ".join(bit.name or "" for bit in InputBit),
    "warning": "a name or AL. and three digits",
    "alarm": "a name, AL. and three digits, or a number of 603Fh (0xFF10)",
}
_SIDES = {"overtravel": ("positive", "negative"), "input": ("on", "off")}


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class DriveFault(FaultFields):
    """One fault of a bus of drives; without `drive` it hits all."""

    kinds: ClassVar[Mapping[str, FaultKind]] = DRIVE_FAULT_KINDS

    drive: int | None = None
    """Which one, counted from 1 along the cable."""
    code: str = ""
    side: str = ""
    by: float | None = None

    @classmethod
    def of_table(cls, table: Mapping[str, Any]) -> Self:
        """From a table of a file, where times may be texts like "50ms"; raises FaultError."""
        fields = dict(table)
        for name in ("at", "lasting", "by"):
            if isinstance(text := fields.get(name), str):
                try:
                    fields[name] = seconds(text)
                except ValueError:
                    raise FaultError(f"{name}: expected a number, got {text!r}") from None
        return cls.of(fields)

    def check_values(self) -> None:
        """Raise FaultError for a value that a field cannot have."""
        least = 0 if self.kind in ("mailbox_delay", "clock_jitter") else -1e6
        self.within(("drive", 1, None), ("by", least, 1e6))
        sides = _SIDES.get(self.kind, ())
        if self.side and self.side not in sides:
            raise FaultError(f"side: expected {' or '.join(sides)}, got {self.side!r}")
        if self.code:
            self.meaning()

    @property
    def effect(self) -> tuple[object, ...]:
        """What it does to a drive."""
        return (self.kind, self.meaning(), self.side, self.by)

    @property
    def place(self) -> tuple[str, object]:
        """What of a drive it acts on: of several faults there, the latest holds."""
        match self.kind:
            case "sto" | "safety":
                return ("safety", None)
            case "encoder_loss":
                return ("encoder", None)
            case "overtravel":
                negative = self.side == "negative"
                return (
                    "input",
                    InputBit.NEGATIVE_LIMIT if negative else InputBit.POSITIVE_LIMIT,
                )
            case _:
                return (self.kind, self.meaning())

    def meaning(self) -> Alarm | Warn | InputBit | None:
        """What `code` stands for; raises FaultError."""
        if not self.code:
            return None
        table: dict[str, Alarm | Warn | InputBit]
        if self.kind == "input":
            table = {bit.name or "": bit for bit in InputBit}
        elif self.kind == "warning":
            table = _named(Warn)
        else:
            table = _named(Alarm)
            with suppress(ValueError):
                alarm = Alarm.of(int(self.code, 0))
                if alarm is not None:
                    return alarm
        found = table.get(self.code.upper())
        if found is None:
            expected = _CODES.get(self.kind, _CODES["alarm"])
            raise FaultError(f"code: expected {expected}; got {self.code!r}")
        return found


def _named(kind: type[Alarm] | type[Warn]) -> dict[str, Alarm | Warn | InputBit]:
    """By name and by panel number."""
    return {key: each for each in kind for key in (each.name, each.panel.upper())}


@dataclasses.dataclass(slots=True)
class ActiveDriveFault:
    """A fault that waits for its time or is at work."""

    number: int
    fault: DriveFault
    begins_ns: int
    state: str = "waiting"
    """`waiting`, `active`, `over`."""
    ends_ns: int = _ENDLESS
    undos: dict[Slave | None, Callable[[], None]] = dataclasses.field(default_factory=dict)
    """What ends it, for each slave that it hits; None is the segment."""
    left: Callable[[], int] | None = None
    """Frames still to be hit."""

    def facts(self) -> dict[str, Any]:
        """As JSON has it."""
        hits = 0
        if self.left is not None:
            hits = (self.fault.count or _ENDLESS) - self.left()
        elif self.state == "active":
            hits = 1
        fields = self.fault.fields()
        return {"number": self.number, "state": self.state, "hits": hits, "fault": fields}


class DriveFaults:
    """The faults of the drives of one segment: `faults.add("sto", drive=2, lasting=1.5)`.

    Times are those of the segment; `tick` begins and ends what is due.
    """

    def __init__(self, segment: Segment) -> None:
        self._segment = segment
        self._faults: dict[int, ActiveDriveFault] = {}
        self._last = 0

    def __iter__(self) -> Iterator[ActiveDriveFault]:
        """Those that wait or are at work."""
        self.tick()
        return iter(tuple(self._faults.values()))

    def __len__(self) -> int:
        return len(self._faults)

    def add(self, fault: DriveFault | str, /, **fields: Any) -> ActiveDriveFault:
        """Add a fault, or one of this kind with these fields; raises FaultError.

        It begins before this returns unless `at` lies ahead.
        """
        if isinstance(fault, str):
            fault = DriveFault.of({"kind": fault, **fields})
        if fault.drive is not None and fault.drive > len(self._segment.slaves):
            raise FaultError(f"drive: there are {len(self._segment.slaves)}, got {fault.drive}")
        now = self._segment.time.now_ns
        begins = now if fault.at is None else round(fault.at * 1e9)
        self._last += 1
        active = self._faults[self._last] = ActiveDriveFault(self._last, fault, begins)
        self.tick()
        return active

    def clear(self, number: int | None = None) -> None:
        """End one fault, or all. KeyError if there is none with this number."""
        for active in list(self._faults.values()) if number is None else [self._faults[number]]:
            self._finish(active)

    def tick(self) -> None:
        """Begin and end what is due now."""
        now = self._segment.time.now_ns
        for active in tuple(self._faults.values()):
            if active.state == "waiting" and active.begins_ns <= now:
                active.state = "active"
                if active.fault.lasting is not None:
                    active.ends_ns = now + round(active.fault.lasting * 1e9)
                self._begin(active)
            if active.state == "active" and (
                now >= active.ends_ns or (active.left is not None and active.left() <= 0)
            ):
                self._finish(active)

    def _finish(self, active: ActiveDriveFault) -> None:
        active.state = "over"
        self._faults.pop(active.number, None)
        undos, active.undos = active.undos, {}
        for slave, undo in undos.items():
            other = self._same(active, slave)
            if other is None:
                undo()
            elif slave is not None and other.fault.effect != active.fault.effect:
                undo()
                self._hit(other.fault, slave)

    def _same(self, active: ActiveDriveFault, slave: Slave | None) -> ActiveDriveFault | None:
        """The latest other fault at the same place of the slave."""
        found = None
        for each in self._faults.values():
            if (
                each is not active
                and slave in each.undos
                and each.fault.place == active.fault.place
            ):
                found = each
        return found

    def _begin(self, active: ActiveDriveFault) -> None:
        fault = active.fault
        if fault.kind in ("lost_frames", "wrong_counter"):
            self._disturb(active)
            return
        slaves = self._segment.slaves
        hit = slaves if fault.drive is None else slaves[fault.drive - 1 : fault.drive]
        for slave in hit:
            other = self._same(active, slave)
            shared = other is not None and other.fault.effect == fault.effect
            undo = other.undos[slave] if other and shared else self._hit(fault, slave)
            if undo is not None:
                active.undos[slave] = undo

    def _disturb(self, active: ActiveDriveFault) -> None:
        """Faults of the frames, which the segment counts by itself."""
        segment, fault = self._segment, active.fault
        disturbance = segment.disturbance = segment.disturbance or Disturbance()
        count = fault.count or _ENDLESS
        if fault.kind == "lost_frames":
            disturbance.lose = max(disturbance.lose, count)
            active.left = lambda: disturbance.lose
        else:
            disturbance.counter = round(fault.by or 0)
            disturbance.counter_frames = max(disturbance.counter_frames, count)
            active.left = lambda: disturbance.counter_frames

        def undo() -> None:
            if fault.kind == "lost_frames":
                disturbance.lose = 0
            else:
                disturbance.counter_frames = 0
            if disturbance.lose <= 0 and disturbance.counter_frames <= 0:
                segment.disturbance = None

        active.undos[None] = undo

    def _hit(self, fault: DriveFault, slave: Slave) -> Callable[[], None] | None:
        """Begin a fault of one slave; what ends it."""
        by = fault.by or 0.0
        clock = slave.esc.clock
        match fault.kind:
            case "mailbox_delay":
                slave.mailbox_delay_ns = round(by * 1e9)
                return lambda: setattr(slave, "mailbox_delay_ns", 0)
            case "hang":
                slave.hang()
                return lambda: slave.hang(False)
            case "link_break":
                self._segment.break_link(slave)
                return lambda: self._segment.repair_link(slave)
            case "eeprom":
                image = slave.esc.eeprom.image
                image[_BROKEN_CHECKSUM] ^= 0xFF
                return lambda: image.__setitem__(_BROKEN_CHECKSUM, image[_BROKEN_CHECKSUM] ^ 0xFF)
            case "clock_drift":
                clock.drift_ppb = round(by * 1000)
                return lambda: setattr(clock, "drift_ppb", 0)
            case "clock_jitter":
                clock.jitter_ns = round(by * 1e9)
                return lambda: setattr(clock, "jitter_ns", 0)
        drive = slave.application
        return _hit_drive(fault, drive) if isinstance(drive, Drive) else None


def _hit_drive(fault: DriveFault, drive: Drive) -> Callable[[], None]:
    """Begin a fault inside a drive; what ends it."""
    faults, meaning = drive.faults, fault.meaning()
    match fault.kind, meaning:
        case "alarm", Alarm() as alarm:
            faults.alarm(alarm)
            return lambda: faults.clear(alarm)
        case "warning", Warn() as warning:
            faults.warning(warning)
            return lambda: faults.warning(warning, False)
        case "encoder_loss", Alarm() as alarm:
            faults.encoder_loss(alarm=alarm)
            return lambda: faults.encoder_loss(False)
        case "encoder_loss", _:
            faults.encoder_loss()
            return lambda: faults.encoder_loss(False)
        case "sto", _:
            faults.sto()
            return lambda: faults.sto(False)
        case "safety", _:
            faults.safety(False, True)
            return lambda: faults.safety(True, True)
        case "overtravel", _:
            positive = fault.side != "negative"
            faults.overtravel(positive=positive)
            return lambda: faults.overtravel(positive=positive, on=False)
        case "input", InputBit() as bit:
            faults.input(bit, fault.side != "off")
            return lambda: faults.input(bit, None)
        case "main_power", _:
            faults.main_power(False)
            return lambda: faults.main_power(True)
        case "load", _:
            faults.load(fault.by or 0.0)
            return lambda: faults.load(0.0)
        case "jam", _:
            faults.jam()
            return lambda: faults.jam(False)
        case "yaw_alarm", _:
            faults.yaw_alarm()
            return lambda: faults.yaw_alarm(False)
        case "local_control", _:
            faults.local_control()
            return lambda: faults.local_control(False)
    raise FaultError(f"kind: {fault.kind} is no fault of a drive")
