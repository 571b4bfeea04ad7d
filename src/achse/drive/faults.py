"""Faults on demand: alarms, warnings and broken signals, switched from tests, CLI or scripts.

A fault that is switched on stays until it is switched off; the drive's own reset then clears the
alarm it caused, and not before.
"""

from typing import Protocol

from achse.drive.alarms import Alarm, Warn
from achse.drive.record import DriveFields
from achse.drive.signals import InputBit


class _Faulty(Protocol):
    local: bool

    @property
    def record(self) -> DriveFields: ...


class FaultSwitches:
    """The switches behind one drive."""

    def __init__(self, drive: _Faulty) -> None:
        self._drive = drive
        self._alarms: dict[Alarm, None] = {}

    @property
    def _record(self) -> DriveFields:
        return self._drive.record

    def alarm(self, alarm: Alarm, *, lasting: bool = True) -> None:
        """Raise an alarm. A `lasting` cause has to be cleared before a fault reset succeeds."""
        self._record.alarm_request = alarm.code
        if lasting:
            self._alarms[alarm] = None
            self._record.alarm_forced = alarm.code

    def clear(self, alarm: Alarm | None = None) -> None:
        """Take the cause of one alarm away, or of all that were raised here."""
        if alarm is None:
            self._alarms.clear()
        else:
            self._alarms.pop(alarm, None)
        self._record.alarm_forced = next(reversed(self._alarms)).code if self._alarms else 0

    @property
    def alarms(self) -> tuple[Alarm, ...]:
        """Alarms whose cause persists, oldest first."""
        return tuple(self._alarms)

    def warning(self, warning: Warn, on: bool = True) -> None:
        """Show a warning, or no longer; what the drive itself sees is shown beside it."""
        name = "warnings_forced_1" if warning.index == 0x3110 else "warnings_forced_2"
        bits = getattr(self._record, name)
        setattr(self._record, name, bits | warning.mask if on else bits & ~warning.mask)

    def encoder_loss(
        self, on: bool = True, alarm: Alarm = Alarm.ENCODER_COMMUNICATION_ERROR
    ) -> None:
        """Silence the encoder: the motor coasts, the drive reports `alarm`."""
        self._record.encoder_fault = alarm.code if on else 0

    def main_power(self, on: bool) -> None:
        """Switch main power; while enabled its loss is an under voltage alarm."""
        self._record.main_power = int(on)

    def safety(self, sf1: bool, sf2: bool) -> None:
        """Set the safety inputs; both off is STO, unequal ones for long an alarm."""
        self._record.safety_1 = int(sf1)
        self._record.safety_2 = int(sf2)

    def sto(self, on: bool = True) -> None:
        """Request STO through both safety inputs, or release it."""
        self.safety(not on, not on)

    def input(self, bit: InputBit, state: bool | None) -> None:
        """Hold a bit of 60FDh on or off; None leaves it to the machine again."""
        record = self._record
        record.inputs_on &= ~bit.value
        record.inputs_off &= ~bit.value
        if state is True:
            record.inputs_on |= bit.value
        elif state is False:
            record.inputs_off |= bit.value

    def overtravel(self, *, positive: bool, on: bool = True) -> None:
        """Let a limit switch report overtravel wherever the machine is."""
        bit = InputBit.POSITIVE_LIMIT if positive else InputBit.NEGATIVE_LIMIT
        self.input(bit, True if on else None)

    def probe(self, on: bool) -> None:
        """Set the signal EXT-PROBE1."""
        self._record.probe_input = int(on)

    def load(self, permille: float) -> None:
        """Apply external load, thousandths of rated torque, against positive direction."""
        self._record.external_load = float(permille)

    def jam(self, on: bool = True) -> None:
        """Block the machine at its position, or free it again."""
        self._record.jammed = int(on)

    def yaw_alarm(self, on: bool = True) -> None:
        """Report an alarm of the gantry's other drive."""
        self._record.yaw_alarm = int(on)

    def local_control(self, on: bool = True) -> None:
        """Operate the drive at its panel: it leaves communication for Init (0x8000)."""
        self._drive.local = on
