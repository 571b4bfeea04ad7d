"""Steps: what they send, and what they make of the working counter."""

from collections.abc import Generator
from typing import Any

import pytest

from achse.ethercat import Datagram, DatagramCommand
from achse.ethercat.master import steps
from achse.ethercat.master.errors import NoAnswer
from achse.ethercat.registers import Register


def answer(running: Generator[Any, Any, Any], data: bytes, counter: int) -> tuple[Datagram, Any]:
    """What the steps send, and their value after one answer."""
    sent = next(running).datagrams[0]
    back = Datagram(sent.command, sent.address, data, counter=counter)
    try:
        running.send(steps.Round([back], 7))
    except StopIteration as end:
        return sent, end.value
    raise AssertionError("the steps go on")


def test_a_register_is_read_by_station() -> None:
    sent, value = answer(steps.read_number(1001, Register.AL_STATUS), b"\x08\x00", 1)
    assert (sent.command, sent.adp, sent.ado) == (DatagramCommand.FPRD, 1001, Register.AL_STATUS)
    assert (value, len(sent.data)) == (8, 2)


def test_positions_count_down_from_zero() -> None:
    sent, _ = answer(steps.write_position(2, Register.STATION_ADDRESS, b"\x01\x00"), b"\0\0", 1)
    assert (sent.command, sent.adp) == (DatagramCommand.APWR, 0xFFFE)
    sent, value = answer(steps.read_position(0, Register.TYPE, 1), b"\x11", 1)
    assert (sent.adp, value) == (0, b"\x11")
    sent, _ = answer(steps.read_position(3, Register.TYPE, 1), b"\x11", 1)
    assert (sent.command, sent.adp, sent.ado) == (DatagramCommand.APRD, 0xFFFD, Register.TYPE)
    for step in (steps.read_position(3, 0x10, 1), steps.write_position(3, 0x10, b"\1")):
        with pytest.raises(NoAnswer) as failure:
            answer(step, b"\0", 0)
        assert (failure.value.station, failure.value.address) == (-3, 0x10)


def test_lost_datagram_is_sent_three_times_unless_said_otherwise() -> None:
    for step in (
        steps.read(1001, 0x10, 1),
        steps.write(1001, 0x10, b"\1"),
        steps.read_position(1, 0x10, 1),
        steps.broadcast_read(0x10, 1),
    ):
        assert next(step).tries == 3  # type: ignore[union-attr]
    for step in (steps.read(1001, 0x10, 1, tries=1), steps.write(1001, 0x10, b"\1", tries=1)):
        assert next(step).tries == 1  # type: ignore[union-attr]


def test_broadcasts_go_to_position_0() -> None:
    read, _ = answer(steps.broadcast_read(Register.TYPE, 3), b"\x11", 5)
    assert (read.command, read.adp, read.ado, read.data) == (DatagramCommand.BRD, 0, 0, bytes(3))
    write, _ = answer(steps.broadcast_write(Register.RX_ERRORS, b"\7"), b"\0", 4)
    assert (write.command, write.adp, write.data) == (DatagramCommand.BWR, 0, b"\7")


@pytest.mark.parametrize("counter", [0, 2])
def test_a_wrong_counter_is_an_error(counter: int) -> None:
    with pytest.raises(NoAnswer, match=f"working counter {counter}"):
        answer(steps.read(1001, Register.TYPE, 1), b"\0", counter)
    with pytest.raises(NoAnswer):
        answer(steps.write_number(1001, Register.AL_CONTROL, 2), b"\x02\0", counter)
    for step in (steps.read_position(2, 0, 1), steps.write_position(2, 0, b"\1")):
        with pytest.raises(NoAnswer):
            answer(step, b"\0", counter)


def test_broadcasts_report_how_many() -> None:
    assert answer(steps.broadcast_read(Register.TYPE, 1), b"\x11", 5)[1] == (b"\x11", 5)
    assert answer(steps.broadcast_write(Register.RX_ERRORS, b"\0"), b"\0", 4)[1] == 4


def test_now_takes_no_datagram() -> None:
    running = steps.now()
    assert next(running) == steps.Pause(0)
    with pytest.raises(StopIteration) as end:
        running.send(steps.Round((), 99))
    assert end.value.value == 99
