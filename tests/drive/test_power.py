"""Power drive system: each state with each command gives the table's state, nothing else does."""

import csv
import itertools
from pathlib import Path

import pytest

from achse.codes import AlState, AlStatus
from achse.drive import Alarm, Mode, PowerState, VirtualDrive, state_of
from achse.drive.power import COMMANDS, TRANSITIONS, PowerEvent, advance
from achse.drive.record import DriveSlots

# Tables 3.2.1.1 and 3.2.1.2 of the manual once more, by hand: state -> command -> state.
S = PowerState
EXPECTED = {
    (S.SWITCH_ON_DISABLED, "shutdown"): (S.READY_TO_SWITCH_ON, 2),
    (S.READY_TO_SWITCH_ON, "switch on"): (S.SWITCHED_ON, 3),
    (S.READY_TO_SWITCH_ON, "enable operation"): (S.SWITCHED_ON, 3),
    (S.SWITCHED_ON, "enable operation"): (S.OPERATION_ENABLED, 4),
    (S.OPERATION_ENABLED, "switch on"): (S.SWITCHED_ON, 5),
    (S.SWITCHED_ON, "shutdown"): (S.READY_TO_SWITCH_ON, 6),
    (S.READY_TO_SWITCH_ON, "quick stop"): (S.SWITCH_ON_DISABLED, 7),
    (S.READY_TO_SWITCH_ON, "disable voltage"): (S.SWITCH_ON_DISABLED, 7),
    (S.OPERATION_ENABLED, "shutdown"): (S.READY_TO_SWITCH_ON, 8),
    (S.OPERATION_ENABLED, "disable voltage"): (S.SWITCH_ON_DISABLED, 9),
    (S.SWITCHED_ON, "quick stop"): (S.SWITCH_ON_DISABLED, 10),
    (S.SWITCHED_ON, "disable voltage"): (S.SWITCH_ON_DISABLED, 10),
    (S.OPERATION_ENABLED, "quick stop"): (S.QUICK_STOP_ACTIVE, 11),
    (S.QUICK_STOP_ACTIVE, "disable voltage"): (S.SWITCH_ON_DISABLED, 12),
    (S.FAULT, "fault reset"): (S.SWITCH_ON_DISABLED, 15),
}
WORDS = {
    "shutdown": 0x0006,
    "switch on": 0x0007,
    "enable operation": 0x000F,
    "disable voltage": 0x0000,
    "quick stop": 0x0002,
    "fault reset": 0x0080,
}


def _at(state: PowerState) -> DriveSlots:
    record = DriveSlots()
    record.power_state = state
    record.communication = AlState.OP
    record.standing = 0
    return record


@pytest.mark.parametrize(
    ("state", "command"), list(itertools.product(PowerState, WORDS)), ids=lambda value: str(value)
)
def test_every_state_with_every_command(state: PowerState, command: str) -> None:
    if state is S.NOT_READY_TO_SWITCH_ON:
        expected = (S.SWITCH_ON_DISABLED, 1)  # leaves by itself
    else:
        expected = EXPECTED.get((state, command), (state, 0))
    record = _at(state)
    record.controlword = WORDS[command]
    number = advance(record, 0, 0)
    state = next(each for each in PowerState if each == record.power_state)
    assert (state, number) == expected


@pytest.mark.parametrize("state", list(PowerState))
def test_an_error_leads_every_state_but_fault_into_the_fault_reaction(state: PowerState) -> None:
    record = _at(state)
    number = advance(record, Alarm.OVER_VOLTAGE.code, Alarm.OVER_VOLTAGE.code)
    if state in (S.FAULT_REACTION_ACTIVE, S.FAULT):
        assert number == 0
    else:
        assert (record.power_state, number) == (S.FAULT_REACTION_ACTIVE, 13)


@pytest.mark.parametrize(
    ("state", "target", "number"),
    [
        (S.QUICK_STOP_ACTIVE, S.SWITCH_ON_DISABLED, 12),
        (S.FAULT_REACTION_ACTIVE, S.FAULT, 14),
    ],
)
def test_the_end_of_a_stop_goes_on_by_itself(
    state: PowerState, target: PowerState, number: int
) -> None:
    record = _at(state)
    record.controlword = 0x0F
    assert advance(record, 0, 0) == 0
    record.standing = 1
    assert (advance(record, 0, 0), record.power_state) == (number, target)


@pytest.mark.parametrize(
    ("state", "number"),
    [
        (S.READY_TO_SWITCH_ON, 7),
        (S.SWITCHED_ON, 10),
        (S.OPERATION_ENABLED, 9),
        (S.QUICK_STOP_ACTIVE, 12),
        (S.SWITCH_ON_DISABLED, 0),
        (S.FAULT, 0),
        (S.FAULT_REACTION_ACTIVE, 0),
    ],
)
def test_init_leads_to_switch_on_disabled_and_keeps_faults(state: PowerState, number: int) -> None:
    record = _at(state)
    record.communication = AlState.INIT
    record.controlword = 0x0F
    assert advance(record, 0, 0) == number
    assert record.power_state == (S.SWITCH_ON_DISABLED if number else state)


def test_transitions_3_and_4_need_power() -> None:
    for state, word in ((S.READY_TO_SWITCH_ON, 7), (S.SWITCHED_ON, 15)):
        for missing in ("main_power", "safety"):
            record = _at(state)
            record.controlword = word
            if missing == "safety":
                record.safety_1 = record.safety_2 = 0
            else:
                record.main_power = 0
            assert (advance(record, 0, 0), record.power_state) == (0, state)


def test_fault_reset_is_an_edge_and_needs_the_cause_gone() -> None:
    record = _at(S.FAULT)
    record.controlword = record.previous_controlword = 0x80
    assert advance(record, 0, 0) == 0
    record.previous_controlword = 0x0F
    assert advance(record, 0, 1) == 0
    assert advance(record, 0, 0) == 15


def test_a_held_reset_bit_is_no_command() -> None:
    record = _at(S.SWITCH_ON_DISABLED)
    record.controlword = record.previous_controlword = 0x86
    assert advance(record, 0, 0) == 0


def test_all_numbers_of_the_manual_are_in_the_table() -> None:
    assert {row.number for row in TRANSITIONS} == set(range(1, 16))
    assert {row.event for row in COMMANDS} | {PowerEvent.FAULT_RESET} <= set(PowerEvent)


@pytest.mark.parametrize("state", list(PowerState))
def test_statuswords_distinguish_the_states(state: PowerState) -> None:
    others = 0x3F90 if state.mask == 0x4F else 0x3F90 & ~0x20
    assert state_of(state.word) is state
    assert state_of(state.word | others & ~state.mask) is state


def test_no_state_is_refused() -> None:
    with pytest.raises(ValueError, match="no state"):
        state_of(0x004F)


def test_the_walk_of_a_master(drive: VirtualDrive) -> None:
    drive.put(0x6060, Mode.CYCLIC_POSITION)
    words = [drive.control(word) & 0x6F for word in (0x00, 0x06, 0x07, 0x0F)]
    assert words == [0x40, 0x21, 0x23, 0x27]
    drive.control(0x00)
    drive.control(0x06)
    assert drive.control(0x0F) & 0x6F == 0x23, "0x0F runs 3 and then 4 by itself"
    assert drive.control(0x0F) & 0x6F == 0x27
    assert drive.control(0x00) & 0x6F == 0x40
    assert drive.control(0x0F) & 0x6F == 0x40, "never straight from switch on disabled"


def test_the_controlword_is_obeyed_from_preop_on() -> None:
    drive = VirtualDrive()
    drive.bring_up(AlState.INIT)
    assert drive.control(0x06) & 0x026F == 0x0040
    drive.bring_up(AlState.PREOP)
    assert drive.control(0x06) & 0x026F == 0x0221


@pytest.mark.parametrize("state", [AlState.SAFEOP, AlState.PREOP, AlState.INIT])
def test_leaving_op_while_enabled_is_a_fault(drive: VirtualDrive, state: AlState) -> None:
    drive.enable(Mode.CYCLIC_POSITION)
    drive.enter(state, 0, AlStatus.WATCHDOG)
    drive.cycle(3)
    assert drive.power_state is S.FAULT
    assert drive.get(0x603F) == Alarm.FIELDBUS_COMMUNICATION_FAULT.code


def test_a_communication_fault_is_reset_once_op_is_back(drive: VirtualDrive) -> None:
    drive.enable(Mode.CYCLIC_POSITION)
    drive.enter(AlState.SAFEOP, 0, AlStatus.WATCHDOG)
    drive.cycle(3)
    drive.control(0)
    drive.control(0x80)
    assert drive.power_state is S.FAULT
    drive.control(0)
    drive.bring_up(AlState.OP)
    drive.control(0x80)
    assert drive.power_state is S.SWITCH_ON_DISABLED


@pytest.mark.parametrize("state", [AlState.PREOP, AlState.SAFEOP, AlState.OP])
def test_every_state_of_communication_but_init_allows_operation(state: AlState) -> None:
    """001 table 2.4.3; below Op the controlword comes by SDO."""
    drive = VirtualDrive()
    drive.bring_up(state)
    seen = set()
    for word in (0x06, 0x07, 0x0F):
        drive.control(word, 2)
        seen.add(drive.power_state)
    assert seen == {S.READY_TO_SWITCH_ON, S.SWITCHED_ON, S.OPERATION_ENABLED}


HOLDS = {
    S.SWITCH_ON_DISABLED: 0x0000,
    S.READY_TO_SWITCH_ON: 0x0006,
    S.SWITCHED_ON: 0x0007,
    S.OPERATION_ENABLED: 0x000F,
    S.QUICK_STOP_ACTIVE: 0x0002,
    S.FAULT_REACTION_ACTIVE: 0x000F,
    S.FAULT: 0x000F,
}
"""A controlword that keeps a state."""

_TABLE = Path(__file__).parents[1] / "data" / "esm_pds_allowed.tsv"
ALLOWED = {
    (row["pds_state"].upper().replace(" ", "_"), column.upper()): row[column] == "yes"
    for row in csv.DictReader(_TABLE.read_text(encoding="utf-8").splitlines(), delimiter="\t")
    for column in ("init", "preop", "safeop", "op")
} | {
    # missing from table 2.4.3; as the other states with a command
    ("QUICK_STOP_ACTIVE", name): name != "INIT"
    for name in ("INIT", "PREOP", "SAFEOP", "OP")
}
"""001 table 2.4.3: which power states there are in which state of communication."""


@pytest.mark.parametrize(
    ("state", "communication"),
    list(itertools.product(HOLDS, (AlState.INIT, AlState.PREOP, AlState.SAFEOP, AlState.OP))),
    ids=str,
)
def test_each_power_state_in_each_state_of_communication(
    state: PowerState, communication: AlState
) -> None:
    record = _at(state)
    record.communication = communication
    record.controlword = HOLDS[state]
    advance(record, 0, 0)
    stays = ALLOWED[state.name, communication.name]
    assert record.power_state == (state if stays else S.SWITCH_ON_DISABLED)


@pytest.mark.parametrize("communication", [AlState.INIT, AlState.PREOP, AlState.SAFEOP, AlState.OP])
def test_not_ready_to_switch_on_is_left_in_each_state_of_communication(
    communication: AlState,
) -> None:
    """After power-on it is Init, after a reset in Op it is Op: the table allows it in those two."""
    record = _at(S.NOT_READY_TO_SWITCH_ON)
    record.communication = communication
    assert advance(record, 0, 0) == 1


def test_leaving_op_while_not_enabled_is_none(drive: VirtualDrive) -> None:
    drive.control(0x06, 2)
    drive.enter(AlState.SAFEOP, 0, AlStatus.NO_ERROR)
    drive.cycle(3)
    assert drive.power_state is S.READY_TO_SWITCH_ON
    drive.enter(AlState.PREOP, 0, AlStatus.NO_ERROR)
    drive.enter(AlState.INIT, 0, AlStatus.NO_ERROR)
    drive.cycle(2)
    assert drive.power_state is S.SWITCH_ON_DISABLED
