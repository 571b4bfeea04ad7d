"""Faults of drives on a bus: each kind, what it takes, and what it does to a slave or to frames.

The same kinds are read by Python, by scripts (TOML) and by the command line.
"""

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from typing import Annotated, Literal, TypeVar

from pydantic import model_validator

from achse.drive import Alarm, Drive, InputBit, Warn
from achse.ethercat import Disturbance, Segment, Slave
from achse.ethercat.ring_segment import RingSegment
from achse.faults.fault import FaultError, FaultKinds, FieldUnit, LastingFault, Undo, number, text

ENDLESS = 1 << 60
"""More frames, and more nanoseconds, than there will ever be."""

_BROKEN_CHECKSUM = 14
"""The byte of the EEPROM that is damaged."""

_NO_EFFECT = frozenset({"kind", "at", "lasting", "count", "drive", "code"})

Amount = Annotated[float, number(float, -1e6, 1e6)]
Lateness = Annotated[float, number(float, 0, 1e6), FieldUnit("s")]
"""Seconds."""


class DriveFault(LastingFault):
    """A fault of a bus of drives."""

    @property
    def meaning(self) -> object:
        """Object that `code` names; None without a code."""
        return None

    @property
    def place(self) -> tuple[str, object]:
        """Key of the disturbed object: of several faults with one key, the latest is effective."""
        return (self.kind, self.meaning)

    @property
    def effect(self) -> tuple[object, ...]:
        """Key of the effect: two faults with one key are the same fault."""
        fields = type(self).model_fields.keys() - _NO_EFFECT
        return (self.kind, self.meaning, *(getattr(self, name) for name in sorted(fields)))


class SlaveFault(DriveFault):
    """A fault of one slave; without `drive` it hits all."""

    drive: Annotated[int, number(int, 1)] | None = None
    """Number of the slave, from 1 along the cable; empty: all slaves."""

    def targets(self, segment: Segment) -> Sequence[Slave | None]:
        """Return the slaves that it hits; None is the cable behind the last one.

        FaultError if there are fewer.
        """
        slaves = segment.slaves
        if self.drive is None:
            return slaves
        if self.drive > len(slaves):
            raise FaultError(f"drive: there are {len(slaves)}, got {self.drive}")
        return slaves[self.drive - 1 : self.drive]

    def begin(self, target: Slave | None, segment: Segment) -> Undo | None:
        """Begin at one of the targets; what ends it, None if nothing began."""
        return None if target is None else self.hit(target, segment)

    def hit(self, slave: Slave, segment: Segment) -> Undo | None:
        """Begin; what ends it, None if the slave is not a drive."""
        drive = slave.application
        return self.hit_drive(drive) if isinstance(drive, Drive) else None

    def hit_drive(self, drive: Drive) -> Undo:
        """Begin inside a drive; what ends it."""
        raise NotImplementedError


class CableFault(DriveFault):
    """A fault of the frames, which the segment counts by itself."""

    count: Annotated[int, number(int, 1), FieldUnit("frames")] | None = None
    """It ends after so many frames."""

    def disturb(self, disturbance: Disturbance, count: int) -> None:
        """Begin."""
        raise NotImplementedError

    def left(self, disturbance: Disturbance) -> int:
        """Frames still to be hit."""
        raise NotImplementedError

    def end(self, disturbance: Disturbance) -> None:
        raise NotImplementedError


K = TypeVar("K", Alarm, Warn)


def _named(rows: Iterable[K]) -> Mapping[str, K]:
    """By name and by panel number."""
    return {key: each for each in rows for key in (each.name, each.panel.upper())}


def _alarm(code: str) -> Alarm:
    with suppress(ValueError):
        alarm = Alarm.of(int(code, 0))
        if alarm is not None:
            return alarm
    expected = "a name, AL. and three digits, or a number of 603Fh (0xFF10)"
    return _of(_named(Alarm), code, expected)


M = TypeVar("M")


def _of(table: Mapping[str, M], code: str, expected: str) -> M:
    member = table.get(code.upper())
    if member is None:
        raise ValueError(f"code: expected {expected}; got {code!r}")
    return member


class AlarmFault(SlaveFault):
    """The drive has the alarm `code`: number in 603Fh, panel number (AL.720) or name. Its cause
    stays until the fault ends; then the master resets it."""

    kind: Literal["alarm"] = "alarm"
    code: Annotated[str, text()]
    """Name of the alarm, or its number on the panel: AL.510."""

    @model_validator(mode="after")
    def _known(self) -> "AlarmFault":
        _alarm(self.code)
        return self

    @property
    def meaning(self) -> Alarm:
        return _alarm(self.code)

    def hit_drive(self, drive: Drive) -> Undo:
        alarm = self.meaning
        drive.faults.alarm(alarm)
        return lambda: drive.faults.clear(alarm)


class WarningFault(SlaveFault):
    """The drive shows the warning `code`, a panel number (AL.910) or name, in 3110h, 3111h."""

    kind: Literal["warning"] = "warning"
    code: Annotated[str, text()]
    """Name of the warning, or its number on the panel."""

    @model_validator(mode="after")
    def _known(self) -> "WarningFault":
        _ = self.meaning
        return self

    @property
    def meaning(self) -> Warn:
        return _of(_named(Warn), self.code, "a name or AL. and three digits")

    def hit_drive(self, drive: Drive) -> Undo:
        warning = self.meaning
        drive.faults.warning(warning)
        return lambda: drive.faults.warning(warning, False)


class EncoderLoss(SlaveFault):
    """The encoder answers no longer: the motor coasts, with an encoder alarm (`code`)."""

    kind: Literal["encoder_loss"] = "encoder_loss"
    code: Annotated[str, text()] = ""
    """Name or panel number of the alarm that the drive shows; empty: its usual one."""

    @model_validator(mode="after")
    def _known(self) -> "EncoderLoss":
        _ = self.meaning
        return self

    @property
    def meaning(self) -> Alarm | None:
        return _alarm(self.code) if self.code else None

    @property
    def place(self) -> tuple[str, object]:
        return ("encoder", None)

    def hit_drive(self, drive: Drive) -> Undo:
        alarm = self.meaning
        if alarm is None:
            drive.faults.encoder_loss()
        else:
            drive.faults.encoder_loss(alarm=alarm)
        return lambda: drive.faults.encoder_loss(False)


class Sto(SlaveFault):
    """Both safety inputs are off: STO."""

    kind: Literal["sto"] = "sto"

    @property
    def place(self) -> tuple[str, object]:
        return ("safety", None)

    def hit_drive(self, drive: Drive) -> Undo:
        drive.faults.sto()
        return lambda: drive.faults.sto(False)


class Safety(SlaveFault):
    """One of the two safety inputs is off."""

    kind: Literal["safety"] = "safety"

    @property
    def place(self) -> tuple[str, object]:
        return ("safety", None)

    def hit_drive(self, drive: Drive) -> Undo:
        drive.faults.safety(False, True)
        return lambda: drive.faults.safety(True, True)


class Overtravel(SlaveFault):
    """The limit switch at `side` (positive, negative) is on, wherever the machine is."""

    kind: Literal["overtravel"] = "overtravel"
    side: Annotated[str, text("positive", "negative")] = ""
    """positive or negative; empty: positive."""

    @property
    def place(self) -> tuple[str, object]:
        negative = self.side == "negative"
        return ("input", InputBit.NEGATIVE_LIMIT if negative else InputBit.POSITIVE_LIMIT)

    def hit_drive(self, drive: Drive) -> Undo:
        positive = self.side != "negative"
        drive.faults.overtravel(positive=positive)
        return lambda: drive.faults.overtravel(positive=positive, on=False)


class Input(SlaveFault):
    """The input `code` (HOME, I1 to I8) is held `side`: on or off."""

    kind: Literal["input"] = "input"
    code: Annotated[str, text()]
    """HOME, I1 to I8."""
    side: Annotated[str, text("on", "off")] = ""
    """on or off; empty: on."""

    @model_validator(mode="after")
    def _known(self) -> "Input":
        _ = self.meaning
        return self

    @property
    def meaning(self) -> InputBit:
        names = {bit.name or "": bit for bit in InputBit}
        return _of(names, self.code, ", ".join(names))

    def hit_drive(self, drive: Drive) -> Undo:
        bit = self.meaning
        drive.faults.input(bit, self.side != "off")
        return lambda: drive.faults.input(bit, None)


class ProbeInput(SlaveFault):
    """The signal of touch probe 1 (EXT-PROBE1) is on beside that of the machine, or falls."""

    kind: Literal["probe"] = "probe"
    side: Annotated[str, text("on", "off")] = ""
    """on or off; empty: on."""

    def hit_drive(self, drive: Drive) -> Undo:
        drive.faults.probe(self.side != "off")
        return lambda: drive.faults.probe(False)


class MainPower(SlaveFault):
    """Main power is off."""

    kind: Literal["main_power"] = "main_power"

    def hit_drive(self, drive: Drive) -> Undo:
        drive.faults.main_power(False)
        return lambda: drive.faults.main_power(True)


class LoadTorque(SlaveFault):
    """An external load of `by` ‰ of rated torque against positive direction."""

    kind: Literal["load"] = "load"
    by: Annotated[Amount, FieldUnit("‰")]
    """‰ of rated torque."""

    def hit_drive(self, drive: Drive) -> Undo:
        drive.faults.load(self.by)
        return lambda: drive.faults.load(0.0)


class Jam(SlaveFault):
    """The machine is blocked at its position."""

    kind: Literal["jam"] = "jam"

    def hit_drive(self, drive: Drive) -> Undo:
        drive.faults.jam()
        return lambda: drive.faults.jam(False)


class YawAlarm(SlaveFault):
    """The other drive of the gantry has an alarm."""

    kind: Literal["yaw_alarm"] = "yaw_alarm"

    def hit_drive(self, drive: Drive) -> Undo:
        drive.faults.yaw_alarm()
        return lambda: drive.faults.yaw_alarm(False)


class LocalControl(SlaveFault):
    """The drive is operated at its panel: not in communication mode, it falls to Init with AL
    status code 0x8000 and does not leave it."""

    kind: Literal["local_control"] = "local_control"

    def hit_drive(self, drive: Drive) -> Undo:
        drive.faults.local_control()
        return lambda: drive.faults.local_control(False)


class MailboxDelay(SlaveFault):
    """Mailbox answers come `by` seconds late."""

    kind: Literal["mailbox_delay"] = "mailbox_delay"
    by: Lateness
    """Delay of the answers, s."""

    def hit(self, slave: Slave, segment: Segment) -> Undo:
        slave.mailbox_delay_ns = round(self.by * 1e9)
        return lambda: setattr(slave, "mailbox_delay_ns", 0)


class Hang(SlaveFault):
    """The drive's program hangs: frames pass and count, but nothing is done or answered, and the
    PDI watchdog expires."""

    kind: Literal["hang"] = "hang"

    def hit(self, slave: Slave, segment: Segment) -> Undo:
        slave.hang()
        return lambda: slave.hang(False)


class LostFrames(CableFault):
    """Frames do not come back: the next `count`, or all."""

    kind: Literal["lost_frames"] = "lost_frames"

    def disturb(self, disturbance: Disturbance, count: int) -> None:
        disturbance.lose = max(disturbance.lose, count)

    def left(self, disturbance: Disturbance) -> int:
        return disturbance.lose

    def end(self, disturbance: Disturbance) -> None:
        disturbance.lose = 0


class WrongCounter(CableFault):
    """The working counters of the next `count` frames, or of all, are wrong by `by`."""

    kind: Literal["wrong_counter"] = "wrong_counter"
    by: Amount
    """Added to the counter."""

    def disturb(self, disturbance: Disturbance, count: int) -> None:
        disturbance.counter = round(self.by)
        disturbance.counter_frames = max(disturbance.counter_frames, count)

    def left(self, disturbance: Disturbance) -> int:
        return disturbance.counter_frames

    def end(self, disturbance: Disturbance) -> None:
        disturbance.counter_frames = 0


class LinkBreak(SlaveFault):
    """The cable before the drive is broken: it and all behind it are out of reach. A ring is open
    there, and has one cable more, back to the second adapter: the number behind the last drive."""

    kind: Literal["link_break"] = "link_break"

    def targets(self, segment: Segment) -> Sequence[Slave | None]:
        if isinstance(segment, RingSegment) and self.drive == len(segment.slaves) + 1:
            return (None,)
        return super().targets(segment)

    def begin(self, target: Slave | None, segment: Segment) -> Undo | None:
        if target is not None:
            return self.hit(target, segment)
        assert isinstance(segment, RingSegment)
        end = len(segment.slaves)
        segment.cut(end)
        return lambda: segment.mend(end)

    def hit(self, slave: Slave, segment: Segment) -> Undo:
        segment.break_link(slave)
        return lambda: segment.repair_link(slave)


class EepromChecksum(SlaveFault):
    """The checksum of the EEPROM is wrong. The drive sees it when the controller is reset or loads
    the EEPROM again, and comes back when it does so after the fault."""

    kind: Literal["eeprom"] = "eeprom"

    def hit(self, slave: Slave, segment: Segment) -> Undo:
        image = slave.esc.eeprom.image
        image[_BROKEN_CHECKSUM] ^= 0xFF
        return lambda: image.__setitem__(_BROKEN_CHECKSUM, image[_BROKEN_CHECKSUM] ^ 0xFF)


class ClockDrift(SlaveFault):
    """The drive's own clock runs `by` ppm too fast; the distributed clocks have to follow."""

    kind: Literal["clock_drift"] = "clock_drift"
    by: Annotated[Amount, FieldUnit("ppm")]
    """ppm."""

    def hit(self, slave: Slave, segment: Segment) -> Undo:
        clock = slave.esc.clock
        clock.drift_ppb = round(self.by * 1000)
        return lambda: setattr(clock, "drift_ppb", 0)


class ClockJump(SlaveFault):
    """The drive's own clock is `by` seconds ahead at once, and back when the fault ends."""

    kind: Literal["clock_jump"] = "clock_jump"
    by: Annotated[float, number(float, -1.0, 1.0), FieldUnit("s")]
    """Seconds; below 0 it is behind."""

    def hit(self, slave: Slave, segment: Segment) -> Undo:
        clock, by_ns = slave.esc.clock, round(self.by * 1e9)
        clock.jump(by_ns)
        return lambda: clock.jump(-by_ns)


class ClockJitter(SlaveFault):
    """Receive times are off by up to `by` seconds."""

    kind: Literal["clock_jitter"] = "clock_jitter"
    by: Lateness
    """Seconds at most."""

    def hit(self, slave: Slave, segment: Segment) -> Undo:
        clock = slave.esc.clock
        clock.jitter_ns = round(self.by * 1e9)
        return lambda: setattr(clock, "jitter_ns", 0)


DRIVE_FAULTS: FaultKinds[DriveFault] = FaultKinds(
    AlarmFault,
    WarningFault,
    EncoderLoss,
    Sto,
    Safety,
    Overtravel,
    Input,
    ProbeInput,
    MainPower,
    LoadTorque,
    Jam,
    YawAlarm,
    LocalControl,
    MailboxDelay,
    Hang,
    LostFrames,
    WrongCounter,
    LinkBreak,
    EepromChecksum,
    ClockDrift,
    ClockJump,
    ClockJitter,
    last=("drive", "code", "side", "by"),
)
"""Every kind of fault that a bus of drives can have."""
