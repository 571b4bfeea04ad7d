"""State changes of a slave: request, wait, acknowledge errors.

Source: ETG.1000.4 §6.1.5; 001 §2.4.
"""

from typing import NamedTuple

from achse.codes import AlState
from achse.ethercat.master.errors import StateRefusal, StateTimeout
from achse.ethercat.master.steps import Pause, Steps, now, read, write_number
from achse.ethercat.registers import Register

UPWARD = (AlState.INIT, AlState.PREOP, AlState.SAFEOP, AlState.OP)
"""The states in the order in which a slave climbs."""

_STATE, _ERROR = 0x0F, 0x10
_POLL_NS = 1_000_000
_ACKNOWLEDGED_NS = 200_000_000


class AlReport(NamedTuple):
    """AL status: the state's number, the error bit, the AL status code."""

    state: int
    error: bool
    code: int


def report_of(data: bytes) -> AlReport:
    """Return the report in the 6 bytes from register 0x0130 on."""
    word, code = int.from_bytes(data[:2], "little"), int.from_bytes(data[4:6], "little")
    return AlReport(word & _STATE, bool(word & _ERROR), code)


def read_state(station: int) -> Steps[AlReport]:
    """AL status of a slave."""
    return report_of((yield from read(station, Register.AL_STATUS, 6)))


def acknowledge(station: int) -> Steps[AlReport]:
    """Acknowledge an error; the report once its error bit is off."""
    report = yield from read_state(station)
    start = yield from now()
    while report.error:
        yield from write_number(station, Register.AL_CONTROL, report.state | _ERROR)
        report = yield from read_state(station)
        if report.error:
            if (yield from now()) - start > _ACKNOWLEDGED_NS:
                raise StateTimeout(
                    f"station {station}: error 0x{report.code:04X} stays although acknowledged"
                )
            yield Pause(_POLL_NS)
    return report


def change_state(station: int, target: AlState, allowed_ns: int) -> Steps[None]:
    """Ask for a state and wait for it; raises `StateRefusal` or `StateTimeout`."""
    yield from write_number(station, Register.AL_CONTROL, target)
    start = yield from now()
    while True:
        time_ns = yield from now()
        report = yield from read_state(station)
        if report.error:
            raise StateRefusal(station, target, report.state, report.code)
        if report.state == target:
            return
        if time_ns - start >= allowed_ns:
            raise StateTimeout(
                f"station {station}: {target.name} not reached within"
                f" {allowed_ns // 1_000_000} ms, state {report.state}"
            )
        yield Pause(_POLL_NS)
