"""Conformance rules for a drive of the manual, checked from its master's side.

Sources: 001 §2.4, 2.5, 2.6.1, 2.8, 2.10.1, §3.1, §3.2.1.
"""

import struct
from collections.abc import Callable, Iterator

from achse.codes import AbortCode, AlState, AlStatus, DataType, SdoAbort
from achse.drive import Mode, PowerState, state_of
from achse.drive.modes import SUPPORTED_MODES
from achse.drive.objects import ROWS, EntryAccess
from achse.drive.objects.communication import DEFAULT_MAPPINGS
from achse.testing.conformance import ConformanceError
from achse.testing.reach import DriveReach

_ACKNOWLEDGE = 0x10
_FAULT_RESET = 0x80
_OUTPUTS = struct.Struct("<HbHiHI")  # 1600h: controlword, mode, max torque, position, probe, …
_INPUTS = struct.Struct("<HHbiHiiI")  # 1A00h: error, statusword, mode, position, …
_PATIENCE_S = 2.0
_WATCHDOG_S, _SILENCE_S = 0.1, 0.15
_PATIENT_S = 6.5
"""The watchdog where it is not what is checked: a master may have to wait for its processor."""

_UP = (AlState.PREOP, AlState.SAFEOP, AlState.OP)


def check_drive(drive: DriveReach, *, motion: bool = True) -> None:
    """Demand what the manual says of a drive; raises ConformanceError with all that is wrong.

    - each object is there with its length, read-only ones refuse writes, ranges are kept, what is
      not in the dictionary is not found;
    - the mapping procedure: each wrong step has its abort code, the right ones succeed;
    - the EtherCAT state machine goes where it may and refuses the rest with the AL status code;
    - the power state machine obeys controlwords, and no shortcut;
    - modes are shown when they are taken, unsupported ones are not;
    - a master that stops sending trips the watchdog, a fault if the drive was enabled.

    The drive's own parameters are not changed; it is left with the default mapping until it is
    switched off. With `motion` it is enabled and turns a little in
    csp and pp: let it move freely, or switch that off.
    """
    check = _Check(drive)
    faults = [
        *check.states(),
        *check.dictionary(),
        *check.mapping(),
        *check.power(motion),
    ]
    if motion:
        faults += [*check.movement(), *check.silence()]
    for state in (AlState.PREOP, AlState.INIT):
        drive.request(state | _ACKNOWLEDGE)
    drive.watchdog(_WATCHDOG_S)
    if faults:
        raise ConformanceError("\n".join(faults))


_Step = tuple[str, int, int, bytes, AbortCode | None]
"""A write and the code it is refused with."""


def _default() -> Iterator[_Step]:
    """Return the procedure that assigns the default mapping, whatever the drive has stored."""
    for assignment, pdo in ((0x1C12, 0x1600), (0x1C13, 0x1A00)):
        entries = DEFAULT_MAPPINGS[pdo]
        yield "assignment off", assignment, 0, b"\0", None
        yield "count off", pdo, 0, b"\0", None
        for number, entry in enumerate(entries, 1):
            yield f"entry {number}", pdo, number, _u32(entry), None
        yield "count on", pdo, 0, bytes((len(entries),)), None
        yield "PDO", assignment, 1, pdo.to_bytes(2, "little"), None
        yield "assignment on", assignment, 0, b"\1", None


class _Check:
    def __init__(self, drive: DriveReach) -> None:
        self._drive = drive
        self._mode = 0
        self._target = 0
        self._inputs: tuple[int, ...] = ()

    # EtherCAT states

    def _go(self, *states: int) -> Iterator[str]:
        """Request states one after the other; what is wrong if one is not reached."""
        for state in states:
            reached, code = self._drive.request(state | _ACKNOWLEDGE)
            if reached != state:
                yield (
                    f"{AlState(state).name} is not reached: AL status 0x{reached:02X},"
                    f" code 0x{code:04X}"
                )

    def states(self) -> Iterator[str]:
        """Check each request in each state, from Init up to SafeOp."""
        yield from self._go(AlState.INIT)
        wrong: tuple[tuple[int, tuple[tuple[int, AlStatus], ...]], ...] = (
            (
                AlState.INIT,
                (
                    (AlState.SAFEOP, AlStatus.INVALID_CHANGE),
                    (AlState.OP, AlStatus.INVALID_CHANGE),
                    (AlState.BOOT, AlStatus.NO_BOOTSTRAP),
                    (0x0F, AlStatus.UNKNOWN_STATE),
                ),
            ),
            (AlState.PREOP, ((AlState.OP, AlStatus.INVALID_CHANGE),)),
        )
        for state, requests in wrong:
            yield from self._go(state)
            for request, expected in requests:
                reached, code = self._drive.request(request)
                if (reached, code) != (state | _ACKNOWLEDGE, expected.number):
                    yield (
                        f"{AlState(state).name} asked for {request}: expected to stay with code"
                        f" 0x{expected.number:04X}, got 0x{reached:02X} and 0x{code:04X}"
                    )
                yield from self._go(state)

    # objects

    def _refusal(self, index: int, subindex: int, data: bytes | None) -> AbortCode | None:
        """Return the abort code of a read (without `data`) or a write; None if it succeeds."""
        try:
            if data is None:
                self._drive.read(index, subindex)
            else:
                self._drive.write(index, subindex, data)
        except SdoAbort as abort:
            return abort.code
        return None

    def _expect(
        self, what: str, index: int, subindex: int, data: bytes | None, code: AbortCode | None
    ) -> Iterator[str]:
        refusal = self._refusal(index, subindex, data)
        if refusal is not code:
            yield (
                f"{index:04X}:{subindex:02X} {what}: expected {_name(code)}, got {_name(refusal)}"
            )

    def dictionary(self) -> Iterator[str]:
        """Check length, access and range of every row in PreOp."""
        for row in ROWS:
            try:
                data = self._drive.read(row.index, row.subindex)
            except SdoAbort as abort:
                yield f"{row.index:04X}:{row.subindex:02X} cannot be read: {_name(abort.code)}"
                continue
            if 8 * len(data) != row.type.bits:
                yield (
                    f"{row.index:04X}:{row.subindex:02X} has {len(data)} bytes,"
                    f" expected {row.type.bits // 8}"
                )
            elif not row.writable:
                yield from self._expect(
                    "is read-only", row.index, row.subindex, data, AbortCode.READ_ONLY
                )
            elif row.access is not EntryAccess.RW_PREOP and row.type is not DataType.F32:
                for value in (row.least - 1, row.most + 1):
                    if row.type.least <= value <= row.type.most:
                        yield from self._expect(
                            f"written with {value}",
                            row.index,
                            row.subindex,
                            row.type.pack(value),
                            AbortCode.VALUE_RANGE,
                        )
        yield from self._expect("is not there", 0x5000, 0, None, AbortCode.NO_OBJECT)
        if (modes := self._number(0x6502)) != SUPPORTED_MODES:
            yield f"6502:00 is 0x{modes:X}, expected 0x{SUPPORTED_MODES:X}"

    def _number(self, index: int, subindex: int = 0) -> int:
        return int.from_bytes(self._drive.read(index, subindex), "little")

    def mapping(self) -> Iterator[str]:
        """Check the procedure of 001 §2.8 on 1600h with a wrong step at every point; in PreOp."""
        refused, absent = AbortCode.UNSUPPORTED_ACCESS, AbortCode.NO_OBJECT
        steps: tuple[_Step, ...] = (
            *_default(),
            ("count while assigned", 0x1600, 0, b"\0", refused),
            ("entry while assigned", 0x1600, 7, _u32(0x607F0020), refused),
            ("count of nine while assigned", 0x1600, 0, b"\x09", AbortCode.VALUE_RANGE),
            ("assignment off", 0x1C12, 0, b"\0", None),
            ("entry while counted", 0x1600, 7, _u32(0x607F0020), refused),
            ("count off", 0x1600, 0, b"\0", None),
            ("unknown object", 0x1600, 7, _u32(0x50000020), absent),
            ("object that cannot be mapped", 0x1600, 7, _u32(0x605A0010), absent),
            ("read-only object received", 0x1600, 7, _u32(0x60640020), absent),
            ("entry", 0x1600, 7, _u32(0x607F0020), None),
            ("count of nine", 0x1600, 0, b"\x09", None),
            ("nine objects assigned", 0x1C12, 0, b"\1", AbortCode.PDO_LENGTH),
            ("count on", 0x1600, 0, b"\x07", None),
            ("PDO that is none", 0x1C12, 1, b"\x04\x16", AbortCode.VALUE_RANGE),
            ("PDO", 0x1C12, 1, b"\x00\x16", None),
            ("assignment on", 0x1C12, 0, b"\1", None),
            *_default(),
        )
        for name, index, subindex, data, code in steps:
            yield from self._expect(name, index, subindex, data, code)

    # power

    def _cycle(self, word: int, cycles: int = 1) -> PowerState:
        for _ in range(cycles):
            outputs = _OUTPUTS.pack(word, self._mode, 1000, self._target, 0, 0)
            self._inputs = _INPUTS.unpack(self._drive.exchange(outputs))
        return state_of(self._inputs[1])

    def _until(self, word: int, condition: Callable[[], object]) -> bool:
        for _ in range(round(_PATIENCE_S / self._drive.cycle_s)):
            self._cycle(word)
            if condition():
                return True
        return False

    def _state(self, word: int, expected: PowerState) -> Iterator[str]:
        before = state_of(self._inputs[1])
        if not self._until(word, lambda: state_of(self._inputs[1]) is expected):
            state = state_of(self._inputs[1])
            yield (
                f"controlword 0x{word:04X} in {before.name}: expected {expected.name},"
                f" got {state.name}"
            )

    def power(self, motion: bool) -> Iterator[str]:
        """Commands of the controlword, in Op with the default mapping."""
        yield from self._go(AlState.SAFEOP)
        self._drive.watchdog(_PATIENT_S)
        self._cycle(0)
        yield from self._go(AlState.OP)
        self._cycle(0, 5)
        self._target = self._inputs[3]
        disabled, ready = PowerState.SWITCH_ON_DISABLED, PowerState.READY_TO_SWITCH_ON
        on, enabled = PowerState.SWITCHED_ON, PowerState.OPERATION_ENABLED
        yield from self._state(0, disabled)
        for word in (0x07, 0x0F):
            if self._cycle(word, 20) is not disabled:
                yield f"controlword 0x{word:04X} left SWITCH_ON_DISABLED, which takes 0x0006"
        walk = [(0x06, ready), (0x00, disabled), (0x06, ready), (0x02, disabled), (0x06, ready)]
        walk += [(0x07, on), (0x06, ready), (0x07, on), (0x00, disabled)]
        for word, expected in walk:
            yield from self._state(word, expected)
        for mode in (Mode.PROFILE_POSITION, Mode.CYCLIC_VELOCITY, Mode.CYCLIC_POSITION):
            self._mode = int(mode)
            if not self._until(0, lambda: self._inputs[2] == self._mode):
                yield f"6061h does not show mode {int(mode)}"
        self._mode = 2
        self._cycle(0, 50)
        if self._inputs[2] != Mode.CYCLIC_POSITION:
            yield f"6061h shows mode {self._inputs[2]} after 6060h asked for 2, which is none"
        self._mode = int(Mode.CYCLIC_POSITION)
        if motion:
            walk = [(0x06, ready), (0x0F, enabled), (0x07, on), (0x0F, enabled), (0x06, ready)]
            walk += [(0x0F, enabled), (0x00, disabled), (0x06, ready), (0x07, on), (0x0F, enabled)]
            for word, expected in walk:
                yield from self._state(word, expected)

    # movement

    def movement(self) -> Iterator[str]:
        """Small moves in csp and pp, the drive being enabled."""
        step = 10
        for _ in range(200):
            self._target += step
            self._cycle(0x0F)
        near = self._until(0x0F, lambda: abs(self._target - self._inputs[3]) <= 50)
        if not near:
            yield f"csp: target {self._target}, position {self._inputs[3]}"
        self._mode = int(Mode.PROFILE_POSITION)
        if not self._until(0x0F, lambda: self._inputs[2] == self._mode):
            yield "pp: 6061h does not show it"
            return
        self._target -= 2000
        self._cycle(0x0F, 2)
        if not self._until(0x1F, lambda: self._inputs[1] & 0x1000):
            yield "pp: the set-point is not acknowledged (statusword bit 12)"
        if not self._until(0x0F, lambda: not self._inputs[1] & 0x1000):
            yield "pp: bit 12 stays when controlword bit 4 is off"
        if not self._until(0x0F, lambda: self._inputs[1] & 0x0400):
            yield f"pp: target {self._target} is not reached, position {self._inputs[3]}"
        self._mode = int(Mode.CYCLIC_POSITION)
        self._target = self._inputs[3]
        self._until(0x0F, lambda: self._inputs[2] == self._mode)

    def silence(self) -> Iterator[str]:
        """Check the watchdog of an enabled drive, its fault, acknowledgement and reset."""
        self._drive.watchdog(_WATCHDOG_S)
        self._drive.pause(_SILENCE_S)
        reached, code = self._drive.request(AlState.SAFEOP)
        expected = (AlState.SAFEOP | _ACKNOWLEDGE, AlStatus.WATCHDOG.number)
        if (reached, code) != expected:
            yield (
                f"after {_SILENCE_S} s of silence: expected AL status 0x14 and code 0x001B,"
                f" got 0x{reached:02X} and 0x{code:04X}"
            )
        self._drive.watchdog(_PATIENT_S)
        yield from self._go(AlState.SAFEOP)
        self._cycle(0)
        if state_of(self._inputs[1]) is not PowerState.FAULT:
            yield "leaving Op while enabled is not a fault"
        if self._number(0x603F) >> 8 != 0xFF:
            yield f"603Fh is 0x{self._number(0x603F):04X} in a fault"
        yield from self._go(AlState.OP)
        self._cycle(0, 5)
        yield from self._state(_FAULT_RESET, PowerState.SWITCH_ON_DISABLED)
        self._cycle(0)


def _u32(number: int) -> bytes:
    return number.to_bytes(4, "little")


def _name(code: AbortCode | None) -> str:
    return "success" if code is None else f"0x{code.number:08X}"
