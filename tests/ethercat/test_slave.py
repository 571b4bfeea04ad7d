"""A slave's states, checks, watchdog and local cycle, seen by a master."""

from collections.abc import Callable
from typing import Any

import pytest

from achse.codes import AlState, AlStatus, ErrorLight
from achse.ethercat import Datagram, DatagramCommand, Loopback, Slave
from achse.ethercat.statemachine import TRANSITIONS, Light, Transition
from achse.ethercat.statemachine import request as meaning_of

I, P, S, O = AlState.INIT, AlState.PREOP, AlState.SAFEOP, AlState.OP  # noqa: E741
STATION = 0x1001
ERROR, ACKNOWLEDGE, IDENTIFY = 0x10, 0x10, 0x20


# every request in every state


@pytest.mark.parametrize("state", [I, P, S, O])
@pytest.mark.parametrize("number", range(16))
def test_each_request_in_each_state(line: Callable[..., Any], state: AlState, number: int) -> None:
    master = line(1)
    master.bring(state)
    if state is I:
        master.mailboxes()
    if state is P:
        master.process_data()
    if state is S:
        master.send(Datagram(DatagramCommand.LWR, 0, bytes(4)))
    meaning = meaning_of(state, number)
    if meaning is Transition.IB:  # 001 table 2.10.1: there is no Bootstrap
        meaning = AlStatus.NO_BOOTSTRAP
    if isinstance(meaning, Transition):
        assert master.request(number) == (number, 0)
        assert master.line[0].state == number
    elif meaning is AlStatus.NO_ERROR:
        assert master.request(number) == (state, 0)
    else:
        # from Op to bootstrap: the manual's table ends in SafeOp, there is no "O + E" for it
        result = S if (state, meaning) == (O, AlStatus.INVALID_CHANGE) else state
        assert master.request(number) == (result | ERROR, meaning.number)
        assert master.line[0].state == result


@pytest.mark.parametrize("state", [I, P, S, O])
@pytest.mark.parametrize("number", range(16))
def test_with_an_error_pending_nothing_happens_without_acknowledgement(
    line: Callable[..., Any], state: AlState, number: int
) -> None:
    master = line(1)
    master.bring(state)
    before = master.request(0)
    assert before == (state | ERROR, AlStatus.UNKNOWN_STATE.number)
    assert master.request(number) == before
    assert master.request(state | ACKNOWLEDGE) == (state, 0)


@pytest.mark.parametrize(
    "pair",
    [
        key
        for key, row in TRANSITIONS.items()
        if row in set(Transition) - {Transition.IB, Transition.BI}
    ],
)
def test_acknowledgement_and_request_go_together(
    line: Callable[..., Any], pair: tuple[AlState, AlState]
) -> None:
    state, wanted = pair
    master = line(1)
    master.bring(state)
    master.mailboxes() if state is I else master.process_data()
    if wanted is O:
        master.send(Datagram(DatagramCommand.LWR, 0, bytes(4)))
    master.request(0)
    assert master.request(wanted | ACKNOWLEDGE) == (wanted, 0)


@pytest.mark.parametrize("state", [P, S, O])
def test_the_application_may_refuse_the_way_up(line: Callable[..., Any], state: AlState) -> None:
    master = line(1)
    below = {P: I, S: P, O: S}[state]
    master.bring(below)
    master.mailboxes() if below is I else master.process_data()
    if state is O:
        master.send(Datagram(DatagramCommand.LWR, 0, bytes(4)))
    master.line[0].refuse = AlStatus.SYNC_CYCLE
    assert master.request(state) == (below | ERROR, 0x0035)
    assert master.request(state | ACKNOWLEDGE) == (state, 0)


def test_the_way_down_is_always_open(line: Callable[..., Any]) -> None:
    master = line(1)
    master.bring(O)
    for state in (S, P, I):
        master.line[0].refuse = AlStatus.UNSPECIFIED
        assert master.request(state) == (state, 0)


@pytest.mark.parametrize("state", [P, S, O])
def test_out_of_communication_mode_the_slave_goes_to_init(
    line: Callable[..., Any], state: AlState
) -> None:
    master = line(1)
    master.bring(state)
    master.line[0].fault = AlStatus.NOT_IN_COMMUNICATION_MODE
    master.advance(1)
    assert master.status() == (I | ERROR, 0x8000)


def test_out_of_communication_mode_the_way_up_ends_in_init(line: Callable[..., Any]) -> None:
    master = line(1)
    master.bring(P)
    master.process_data()
    master.line[0].refuse = AlStatus.NOT_IN_COMMUNICATION_MODE
    assert master.request(S) == (I | ERROR, 0x8000)


@pytest.mark.parametrize("code", [code for code in AlStatus if code is not AlStatus.NO_ERROR])
@pytest.mark.parametrize("state", [I, P, S, O])
def test_an_error_found_by_the_application_leads_to_its_result_state(
    line: Callable[..., Any], state: AlState, code: AlStatus
) -> None:
    master = line(1)
    master.bring(state)
    master.line[0].fault = code
    master.advance(0.5)
    expected = state if code.result is None else min(state, code.result)
    assert master.status() == (expected | ERROR, code.number)
    assert master.line[0].state == expected
    if expected != state:
        assert master.line[0].cause is code


def test_lights(line: Callable[..., Any]) -> None:
    master = line(1)
    slave = master.segment.slaves[0]
    for state, light in (
        (I, Light.OFF),
        (P, Light.BLINKING),
        (S, Light.SINGLE_FLASH),
        (O, Light.ON),
    ):
        fresh = line(1)
        fresh.bring(state)
        assert fresh.segment.slaves[0].run_light is light
    assert slave.error_light is ErrorLight.OFF
    slave.fail(AlStatus.WATCHDOG)
    assert slave.error_light is ErrorLight.DOUBLE_FLASH
    slave.esc.eeprom.image[3] ^= 1
    slave.reset()
    assert slave.error_light is ErrorLight.FLICKERING


def test_the_alias_can_be_requested_in_al_status() -> None:
    from achse.ethercat import Segment

    segment = Segment([Slave(Loopback(), alias=0x42)])
    slave = segment.slaves[0]
    slave.al_control(I | IDENTIFY)
    assert bytes(slave.esc.memory[0x0130:0x0136]) == bytes.fromhex("2100 0000 4200")
    slave.al_control(I)
    assert bytes(slave.esc.memory[0x0130:0x0136]) == bytes.fromhex("0100 0000 0000")


# process data


@pytest.mark.parametrize("state", [S, O])
@pytest.mark.parametrize(("offset", "code"), [(0x0810, 0x001D), (0x0818, 0x001E)])
def test_changing_process_data_while_it_runs_drops_to_preop(
    line: Callable[..., Any], state: AlState, offset: int, code: int
) -> None:
    master = line(1)
    master.bring(state)
    master.write(offset + 2, b"\x07\x00")
    assert master.status() == (P | ERROR, code)
    assert master.line[0].cause.number == code


def test_no_process_data_before_safeop(line: Callable[..., Any]) -> None:
    master = line(1)
    master.bring(P)
    master.process_data()
    assert master.exchange(bytes(4))[1] == 0
    assert master.write(0x1200, bytes(4)) == 0
    master.request(S)
    assert master.exchange(bytes(4))[1] == 2


# outputs and watchdog


def test_outputs_reach_the_application_in_op_only(line: Callable[..., Any]) -> None:
    master = line(1)
    application = master.line[0]
    master.bring(S)
    master.exchange(b"safe")
    assert application.read_object(0x7000, 1) == b"\0"
    master.request(O)
    assert application.read_object(0x7000, 1) == b"s"  # the last before Op
    master.exchange(b"oper")
    assert application.read_object(0x7000, 1) == b"o"
    assert master.write(0x1200, b"byte") == 1
    assert application.read_object(0x7000, 1) == b"b"


def test_op_waits_for_outputs(line: Callable[..., Any]) -> None:
    master = line(1)
    master.bring(S)
    assert master.request(O) == (S, 0)
    master.advance(50)
    assert master.status() == (S, 0)
    master.exchange(bytes(4))
    assert master.status() == (O, 0)


def test_op_is_refused_if_no_outputs_come(line: Callable[..., Any]) -> None:
    master = line(1)
    master.bring(S)
    master.request(O)
    master.advance(101)
    assert master.status() == (S | ERROR, 0x001B)
    master.exchange(bytes(4))
    assert master.status() == (S | ERROR, 0x001B)


def test_old_outputs_do_not_count(line: Callable[..., Any]) -> None:
    master = line(1)
    master.bring(S)
    master.exchange(bytes(4))
    master.advance(150)
    assert master.request(O) == (S, 0)
    master.exchange(bytes(4))
    assert master.status() == (O, 0)


def test_another_request_ends_the_waiting(line: Callable[..., Any]) -> None:
    master = line(1)
    master.bring(S)
    master.request(O)
    assert master.request(S) == (S, 0)
    master.exchange(bytes(4))
    assert master.status() == (S, 0)


@pytest.mark.parametrize(("after_ms", "expected"), [(99, (O, 0)), (101, (S | ERROR, 0x001B))])
def test_the_watchdog(line: Callable[..., Any], after_ms: float, expected: tuple[int, int]) -> None:
    master = line(1)
    master.bring(O)
    for _ in range(20):
        master.advance(10)
        assert master.exchange(bytes(4))[1] == 2
    master.advance(after_ms)
    assert master.status() == expected
    expired = expected[0] != O
    assert master.number(0x0440, 1) == (not expired)
    assert master.number(0x0442, 1) == expired
    assert master.line[0].cause is (AlStatus.WATCHDOG if expired else AlStatus.NO_ERROR)


def test_after_the_watchdog_the_master_acknowledges_and_goes_on(line: Callable[..., Any]) -> None:
    master = line(1)
    master.bring(O)
    master.advance(200)
    assert master.request(O) == (S | ERROR, 0x001B)
    assert master.request(S | ACKNOWLEDGE) == (S, 0)
    master.exchange(bytes(4))
    assert master.request(O) == (O, 0)
    assert master.number(0x0440, 1) == 1


@pytest.mark.parametrize("ticks", [1, 20, 5000])
def test_the_watchdog_time_is_the_masters(line: Callable[..., Any], ticks: int) -> None:
    master = line(1)
    master.bring(S)
    master.write(0x0420, ticks.to_bytes(2, "little"))
    master.exchange(bytes(4))
    master.request(O)
    master.advance(0.1 * ticks - 0.05)
    assert master.status() == (O, 0)
    master.advance(0.35)
    assert master.status() == (S | ERROR, 0x001B)


@pytest.mark.parametrize("how", ["time 0", "no trigger"])
def test_the_watchdog_can_be_off(line: Callable[..., Any], how: str) -> None:
    master = line(1)
    master.bring(P)
    master.process_data()
    if how == "time 0":
        master.write(0x0420, bytes(2))
    else:
        master.write(0x0814, b"\x24")
    master.request(S)
    master.exchange(bytes(4))
    master.request(O)
    master.advance(10_000)
    assert master.status() == (O, 0)


def test_reading_inputs_does_not_feed_the_watchdog(line: Callable[..., Any]) -> None:
    master = line(1)
    master.bring(O)
    for _ in range(12):
        master.advance(10)
        master.send(Datagram(DatagramCommand.LRD, 0x100, bytes(4)))
    assert master.status() == (S | ERROR, 0x001B)


# local cycle


def test_free_run_steps_by_the_local_timer(master: Any) -> None:
    application = master.line[0]
    for _ in range(8):
        master.advance(0.125)
    assert (application.cycles, application.elapsed_ns) == (4, 1_000_000)
    master.advance(3600_000)
    assert application.elapsed_ns == 1_000_000 + 3600 * 10**9
    assert application.cycles < 10  # what nothing interrupts passes at once


def test_after_a_pause_the_watchdog_expires_where_it_should(line: Callable[..., Any]) -> None:
    master = line(1)
    master.bring(O)
    application = master.line[0]
    stepped: list[tuple[int, AlState]] = []
    slave = master.segment.slaves[0]
    step = application.step

    def noted(ns: int) -> Any:
        stepped.append((ns, application.state))
        return step(ns)

    slave._step = noted
    master.advance(1000)
    in_op = sum(ns for ns, state in stepped if state is O)
    assert 99_750_000 <= in_op <= 100_250_000
    assert sum(ns for ns, _ in stepped) == pytest.approx(1000_000_000, abs=250_000)


def test_time_does_not_go_back(master: Any) -> None:
    master.advance(5)
    master.segment.advance(1)
    assert master.segment.time.now_ns == 5_000_000


def test_a_slave_joins_a_segment_at_its_present_time(master: Any) -> None:
    master.advance(1000)
    late = Slave(Loopback())
    master.segment.attach(late)
    master.advance(1)
    assert late.application.elapsed_ns == 1_000_000  # type: ignore[attr-defined]
