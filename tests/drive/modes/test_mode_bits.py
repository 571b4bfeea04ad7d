"""Controlword and statusword bit by bit, in each mode, as the manual lists them."""

import csv
from collections.abc import Callable
from pathlib import Path

import pytest

from achse.codes import AlState
from achse.drive import Alarm, InputBit, Mechanics, Mode, PowerState, Switches, VirtualDrive, Warn
from tests.drive.machine_code import fast_drive

_TABLE = Path(__file__).parents[2] / "data" / "drive_mode_bits.tsv"
LISTED = list(csv.DictReader(_TABLE.read_text(encoding="utf-8").splitlines(), delimiter="\t"))
IDLE = [row for row in LISTED if row["name"] in ("not used", "reserved")]
ACTING = [row for row in LISTED if row not in IDLE]

MODES = {
    "pp": Mode.PROFILE_POSITION,
    "pv": Mode.PROFILE_VELOCITY,
    "tq": Mode.PROFILE_TORQUE,
    "hm": Mode.HOMING,
    "csp": Mode.CYCLIC_POSITION,
    "csv": Mode.CYCLIC_VELOCITY,
    "cst": Mode.CYCLIC_TORQUE,
}
REMOTE, LIMIT, REACHED, BIT_12, BIT_13 = 0x0200, 0x0800, 0x0400, 0x1000, 0x2000
S = PowerState


def bits(text: str) -> int:
    """The mask of "4,5,6,9" or "10-15"."""
    mask = 0
    for part in text.split(","):
        first, _, last = part.partition("-")
        for bit in range(int(first), int(last or first) + 1):
            mask |= 1 << bit
    return mask


def enabled(mode: Mode, machine: Mechanics | None = None, **parameters: int) -> VirtualDrive:
    drive = fast_drive(machine, parameters={int(k[1:], 16): v for k, v in parameters.items()})
    drive.enable(mode)
    return drive


def moving(mode: Mode, word: int = 0x0F) -> VirtualDrive:
    """Under way to where pp, pv, tq or a cyclic mode is told to go."""
    drive = enabled(mode, x6087=10_000)
    drive.put(0x607A, 10_000_000 if mode is Mode.PROFILE_POSITION else 1_000)
    drive.put(0x60FF, 500_000)
    drive.put(0x6071, 100)
    drive.control(word | 0x10 if mode is Mode.PROFILE_POSITION else word, 300)
    return drive


def halted(mode: Mode, cycles: int) -> VirtualDrive:
    drive = moving(mode)
    drive.control(0x010F, cycles)
    return drive


def speed(drive: VirtualDrive) -> float:
    return abs(drive.record.motor_velocity)


# what is not used or reserved


@pytest.mark.parametrize(
    ("mode", "mask"),
    [
        (mode, bits(row["bit"]))
        for row in IDLE
        if row["word"] == "controlword"
        for mode in (MODES if row["mode"] == "all" else [row["mode"]])
    ]
    + [(mode, 1 << 8) for mode in ("csp", "csv", "cst")],
)
def test_bits_of_the_controlword_without_a_meaning_do_nothing(mode: str, mask: int) -> None:
    plain, crowded = moving(MODES[mode]), moving(MODES[mode], 0x0F | mask)
    assert speed(plain) > 0 or mode in ("hm", "csp")
    assert crowded.record.motor_position == plain.record.motor_position
    assert crowded.statusword == plain.statusword


@pytest.mark.parametrize(
    ("mode", "mask"),
    [
        (mode, bits(row["bit"]))
        for row in IDLE
        if row["word"] == "statusword"
        for mode in (MODES if row["mode"] == "all" else [row["mode"]])
    ],
)
def test_bits_of_the_statusword_without_a_meaning_stay_0(mode: str, mask: int) -> None:
    drive = moving(MODES[mode])
    assert drive.statusword & mask == 0
    assert drive.control(0x010F, 50) & mask == 0
    drive.faults.encoder_loss()
    assert drive.control(0, 5) & mask == 0


# what has one: each row of the list, and a drive that shows it

Row = tuple[str, str, str, str]
PROOFS: dict[Row, Callable[[], object]] = {}


def shows(
    mode: str, word: str, bit: str, value: str = ""
) -> Callable[[Callable[[], object]], Callable[[], object]]:
    """Register the proof of a row: a function that is true if the drive does as listed."""

    def register(proof: Callable[[], object]) -> Callable[[], object]:
        PROOFS[mode, word, bit, value] = proof
        return proof

    return register


def walked(*words: int) -> VirtualDrive:
    drive = fast_drive()
    for word in words:
        drive.control(word, 2)
    return drive


CONTROL, STATUS = "controlword", "statusword"

for _bit, _words, _before, _after in (
    ("0", (0x06, 0x07), S.READY_TO_SWITCH_ON, S.SWITCHED_ON),
    ("1", (0x0F, 0x0D), S.OPERATION_ENABLED, S.SWITCH_ON_DISABLED),
    ("2", (0x07, 0x03), S.SWITCHED_ON, S.SWITCH_ON_DISABLED),
    ("3", (0x07, 0x0F), S.SWITCHED_ON, S.OPERATION_ENABLED),
):

    @shows("all", CONTROL, _bit)
    def _command(
        words: tuple[int, ...] = _words, before: PowerState = _before, after: PowerState = _after
    ) -> bool:
        drive = walked(0x06, words[0])
        was = drive.power_state
        drive.control(words[1], 2)
        return (was, drive.power_state) == (before, after)


@shows("all", CONTROL, "7", "0->1")
def _fault_reset() -> bool:
    drive = fast_drive()
    drive.faults.alarm(Alarm.OVER_VOLTAGE, lasting=False)
    drive.control(0x80, 3)  # the edge comes too early and is not an edge afterwards
    before = drive.power_state
    drive.control(0)
    drive.control(0x80)
    return (before, drive.power_state) == (S.FAULT, S.SWITCH_ON_DISABLED)


for _mode in ("all", "pp", "pv", "tq", "hm"):

    @shows(_mode, CONTROL, "8", "1")
    def _halt(mode: str = _mode) -> bool:
        if mode == "hm":
            drive = homing(0x1F, 200)
            drive.control(0x011F, 300)
        else:
            drive = halted(MODES["pv" if mode == "all" else mode], 3_000)
        return drive.power_state is S.OPERATION_ENABLED and drive.record.demand_velocity == 0


for _mode in ("pp", "pv", "tq"):

    @shows(_mode, CONTROL, "8", "0")
    def _resume(mode: str = _mode) -> bool:
        drive = halted(MODES[mode], 3_000)
        stood = drive.record.demand_velocity == 0
        drive.control(0x0F, 200)
        return stood and speed(drive) > 50_000

    @shows(_mode, STATUS, "10", "0")
    def _not_reached(mode: str = _mode) -> bool:
        drive = enabled(MODES[mode], x6087=100)
        drive.put(0x607A, 10_000_000)
        drive.put(0x60FF, 1_000_000)
        drive.put(0x6071, 200)
        under_way = drive.control(0x1F, 20)
        braking = halted(MODES[mode], 1).statusword
        return not (under_way | braking) & REACHED

    @shows(_mode, STATUS, "10", "1")
    def _reached(mode: str = _mode) -> bool:
        drive = enabled(MODES[mode])
        drive.put(0x607A, 1_000)
        drive.put(0x60FF, 100_000)
        drive.put(0x6071, 50)
        there = drive.control(0x1F, 500)
        return bool(there & halted(MODES[mode], 3_000).statusword & REACHED)


@shows("all", STATUS, "10", "0")
def _all_not_reached() -> object:
    return PROOFS["pv", STATUS, "10", "0"]()


@shows("all", STATUS, "10", "1")
def _all_reached() -> object:
    return PROOFS["pv", STATUS, "10", "1"]()


# the power drive system

for _bit, _states in (
    ("0", {0x06: 1, 0x07: 1, 0x0F: 1, 0x00: 0}),
    ("1", {0x06: 0, 0x07: 1, 0x0F: 1, 0x00: 0}),
    ("2", {0x06: 0, 0x07: 0, 0x0F: 1, 0x00: 0}),
    ("6", {0x06: 0, 0x07: 0, 0x0F: 0, 0x00: 1}),
):

    @shows("all", STATUS, _bit)
    def _state(bit: int = int(_bit), states: dict[int, int] = _states) -> bool:
        drive = fast_drive()
        return all(drive.control(word, 2) >> bit & 1 == on for word, on in states.items())


@shows("all", STATUS, "3")
def _fault() -> bool:
    drive = fast_drive()
    before = drive.statusword
    drive.faults.alarm(Alarm.OVER_VOLTAGE)
    drive.cycle(3)
    return not before & 8 and drive.statusword & 8 != 0


@shows("all", STATUS, "4", "0")
def _voltage() -> bool:
    drive = fast_drive()
    normal = drive.statusword
    drive.faults.main_power(False)
    drive.cycle()
    return not normal & 0x10 and drive.statusword & 0x10 != 0


@shows("all", STATUS, "5", "0")
def _quick_stop() -> bool:
    drive = moving(Mode.PROFILE_VELOCITY)
    before = drive.statusword
    drive.control(0x0B)
    return before & 0x20 != 0 and not drive.statusword & 0x20


@shows("all", STATUS, "7", "1")
def _warning() -> bool:
    drive = moving(Mode.PROFILE_VELOCITY)
    drive.faults.warning(Warn.INTERNAL_FAN_STOP)
    drive.cycle(50)
    return drive.statusword & 0xEF == 0xA7 and speed(drive) > 400_000


@shows("all", STATUS, "9", "1")
def _remote() -> bool:
    drive = fast_drive()
    drive.bring_up(AlState.INIT)
    early = drive.control(0x06, 2)
    drive.bring_up(AlState.PREOP)
    return not early & REMOTE and drive.control(0x06, 2) & (REMOTE | 1) == REMOTE | 1


# internal limit


def _limit_by_switch(mode: str) -> bool:
    """A limit switch, servo on or off."""
    drive = fast_drive()
    drive.put(0x6060, MODES[mode])
    drive.cycle()
    drive.faults.overtravel(positive=True)
    drive.cycle()
    off = drive.statusword
    drive.enable(MODES[mode])
    return off & drive.statusword & LIMIT != 0


def _limit_by_torque(mode: str) -> bool:
    """The torque limit, servo on alone."""
    drive = fast_drive(parameters={0x6087: 10**6, 0x6098: 34})
    drive.faults.jam()
    drive.enable(MODES[mode])
    drive.put(0x6072, 20)
    for index, value in ((0x60FF, 100_000), (0x6071, 100), (0x607A, 5_000)):
        drive.put(index, value)
    on = drive.control(0x1F, 200)
    return on & LIMIT != 0 and not drive.control(0, 5) & LIMIT


for _mode in MODES:

    @shows(_mode, STATUS, "11", "1")
    def _limit(mode: str = _mode) -> bool:
        if mode == "hm":
            return _limit_by_torque(mode) and not _limit_by_switch(mode)
        limits = _limit_by_switch(mode) and _limit_by_torque(mode)
        if mode == "csp":
            drive = enabled(Mode.CYCLIC_POSITION)
            drive.put(0x607A, 20_000)  # 6000 1/min are 13,107 counts in 1 ms
            drive.cycle()
            limits = limits and drive.statusword & LIMIT != 0
        return limits


@shows("all", STATUS, "11", "1")
def _all_limits() -> bool:
    return all(PROOFS[mode, STATUS, "11", "1"]() for mode in MODES)


# pp: set-points

FIRST = 1_000_000


def two_setpoints(second: int, word: int) -> list[tuple[int, float]]:
    """Demanded positions and velocities of a set-point and, 100 ms later, of the next."""
    drive = enabled(Mode.PROFILE_POSITION)
    seen = []
    for target, bits_, cycles in ((FIRST, 0x0F, 100), (second, word, 2_500)):
        drive.put(0x607A, target)
        drive.control(bits_ | 0x10)
        for _ in range(cycles):
            drive.control(bits_)
            seen.append((int(drive.get(0x6062)), drive.record.demand_velocity))
    assert seen[-1] == (second, 0)
    return seen


@shows("pp", CONTROL, "4", "0->1")
def _new_setpoint() -> bool:
    drive = enabled(Mode.PROFILE_POSITION)
    drive.put(0x607A, 5_000)
    drive.control(0x0F, 50)
    before = drive.get(0x6062)
    drive.control(0x1F, 500)
    drive.put(0x607A, 9_000)
    drive.control(0x1F, 500)  # no edge
    return (before, drive.get(0x6062)) == (0, 5_000)


@shows("pp", CONTROL, "9,5,4", "bit9=0, bit5=0, bit4 0->1")
def _one_after_the_other() -> bool:
    near = [v for position, v in two_setpoints(2 * FIRST, 0x0F) if abs(position - FIRST) < 100]
    return abs(min(near, key=abs)) <= 10_000  # the profile's velocity after one cycle


@shows("pp", CONTROL, "5", "1")
@shows("pp", CONTROL, "9,5,4", "bit9=X, bit5=1, bit4 0->1")
def _at_once() -> bool:
    return all(
        max(position for position, _ in two_setpoints(-FIRST, word)) < FIRST // 2
        for word in (0x2F, 0x22F)
    )


@shows("pp", CONTROL, "9", "1")
@shows("pp", CONTROL, "9,5,4", "bit9=1, bit5=0, bit4 0->1")
def _on_set_point() -> bool:
    seen = two_setpoints(2 * FIRST, 0x20F)
    past = [velocity for position, velocity in seen if FIRST // 2 < position < 3 * FIRST // 2]
    return min(past) == max(past) > 0


for _value, _ends in (("0", 8_000), ("1", 13_000)):

    @shows("pp", CONTROL, "6", _value)
    def _relative(relative: int = int(_value), ends: int = _ends) -> bool:
        drive = enabled(Mode.PROFILE_POSITION)
        drive.move_to(5_000)
        drive.move_to(8_000, relative=bool(relative))
        return drive.get(0x6062) == ends


@shows("pp", STATUS, "12", "0")
def _free() -> bool:
    drive = enabled(Mode.PROFILE_POSITION)
    drive.control(0x1F)
    return not drive.control(0x0F) & BIT_12


@shows("pp", STATUS, "12", "1")
def _acknowledged() -> bool:
    drive = enabled(Mode.PROFILE_POSITION)
    drive.put(0x607A, FIRST)
    taken = drive.control(0x1F)
    for _ in range(2):  # one runs, two wait
        drive.control(0x0F)
        drive.control(0x1F)
    return bool(taken & drive.control(0x0F) & BIT_12)


for _mode in ("pp", "csp"):
    for _value in ("0", "1"):

        @shows(_mode, STATUS, "13", _value)
        def _following(mode: str = _mode, value: str = _value) -> bool:
            drive = enabled(MODES[mode], x6065=500)
            if value == "1":
                drive.faults.jam()
            drive.put(0x607A, 5_000)
            return drive.control(0x1F, 100) & BIT_13 == BIT_13 * int(value)


# pv


@shows("pv", STATUS, "12", "0")
def _turns() -> bool:
    return not moving(Mode.PROFILE_VELOCITY).statusword & BIT_12


@shows("pv", STATUS, "12", "1")
def _stands() -> bool:
    return enabled(Mode.PROFILE_VELOCITY).statusword & BIT_12 != 0


@shows("pv", STATUS, "13")
def _slippage_has_no_meaning() -> bool:
    drive = moving(Mode.PROFILE_VELOCITY)
    drive.faults.jam()
    return not drive.control(0x0F, 20) & BIT_13


# hm


def homing(word: int = 0x0F, cycles: int = 1, **parameters: int) -> VirtualDrive:
    switches = Switches(negative_limit=-(10**6), home=(0, 30_000), positive_limit=10**6)
    machine = Mechanics(switches=switches, position=-500_000)
    drive = enabled(Mode.HOMING, machine, **({"x6098": 7} | parameters))
    drive.control(word, cycles)
    return drive


def home_state(drive: VirtualDrive) -> int:
    return drive.statusword & (BIT_13 | BIT_12 | REACHED)


@shows("hm", CONTROL, "4", "0")
def _no_start() -> bool:
    return speed(homing(0x0F, 100)) == 0


@shows("hm", CONTROL, "4", "1")
def _start() -> bool:
    return speed(homing(0x1F, 100)) > 0


@shows("hm", CONTROL, "8", "0")
def _obeys() -> bool:
    drive = homing(0x011F, 100)
    stood = speed(drive)
    drive.control(0x1F, 100)
    return stood == 0 < speed(drive)


@shows("hm", STATUS, "13,12,10", "13=0,12=0,10=0")
def _homing_runs() -> bool:
    return home_state(homing(0x1F, 50)) == 0


@shows("hm", STATUS, "13,12,10", "13=0,12=0,10=1")
def _interrupted() -> bool:
    stopped = homing(0x1F, 50)
    stopped.control(0x0F, 500)
    return home_state(homing()) == home_state(stopped) == REACHED


def _seen_until_done() -> list[int]:
    drive = homing(0x1F)
    seen = [home_state(drive)]
    while seen[-1] != BIT_12 | REACHED:
        drive.cycle()
        seen.append(home_state(drive))
    return seen


@shows("hm", STATUS, "13,12,10", "13=0,12=1,10=0")
def _attained() -> bool:
    return BIT_12 in _seen_until_done()


@shows("hm", STATUS, "13,12,10", "13=0,12=1,10=1")
def _finished() -> bool:
    return _seen_until_done()[-1] == BIT_12 | REACHED


@shows("hm", STATUS, "13,12,10", "13=1,12=0,10=0")
def _error_in_motion() -> bool:
    drive = homing()
    drive.faults.input(InputBit.HOME, False)  # neither there nor on the way back
    drive.control(0x1F)
    drive.wait(lambda: drive.statusword & BIT_13, 20)
    return home_state(drive) == BIT_13 and speed(drive) > 0


@shows("hm", STATUS, "13,12,10", "13=1,12=0,10=1")
def _error_at_rest() -> bool:
    return home_state(homing(0x1F, 5, x6098=3)) == BIT_13 | REACHED


@shows("hm", STATUS, "13,12,10", "13=1,12=1,10=X")
def _reserved() -> bool:
    seen = {*_seen_until_done(), home_state(homing(0x1F, 5, x6098=3))}
    return not any(state & BIT_13 and state & BIT_12 for state in seen)


@shows("hm", STATUS, "12", "0")
def _forgotten() -> bool:
    drive = homing(0x1F)
    drive.wait(lambda: home_state(drive) == BIT_12 | REACHED, 20)
    drive.put(0x6060, Mode.PROFILE_POSITION)
    drive.cycle(3)
    drive.put(0x6060, Mode.HOMING)
    drive.control(0x0F, 3)
    return not drive.statusword & BIT_12


# cyclic modes

for _mode in ("csp", "csv", "cst"):

    @shows(_mode, STATUS, "12", "1")
    def _follows(mode: str = _mode) -> bool:
        return moving(MODES[mode]).statusword & BIT_12 != 0

    @shows(_mode, STATUS, "12", "0")
    def _ignores(mode: str = _mode) -> bool:
        drive = moving(MODES[mode])
        drive.faults.overtravel(positive=True)
        drive.put(0x607A, 2_000)
        stopped = drive.control(0x0F, 5)
        return not (stopped | drive.control(0x07, 2)) & BIT_12

    @shows(_mode, STATUS, "10")
    def _within(mode: str = _mode) -> bool:
        drive = enabled(MODES[mode])
        drive.faults.jam()
        drive.put(0x607A, 1_000)
        drive.put(0x60FF, 100_000)
        blocked = drive.control(0x0F, 50)
        free = moving(MODES[mode])
        free.control(0x0F, 500)
        return free.statusword & REACHED != 0 and (mode == "cst" or not blocked & REACHED)


@pytest.mark.parametrize(
    "row", ACTING, ids=lambda row: f"{row['mode']}-{row['word']}-{row['bit']}={row['value']}"
)
def test_each_bit_does_what_is_listed(row: dict[str, str]) -> None:
    assert PROOFS[row["mode"], row["word"], row["bit"], row["value"]]()


def test_nothing_is_proved_that_is_not_listed() -> None:
    listed = {(row["mode"], row["word"], row["bit"], row["value"]) for row in ACTING}
    assert PROOFS.keys() == listed
