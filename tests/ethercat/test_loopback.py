"""The smallest application."""

import pytest

from achse.codes import AbortCode, AlState, AlStatus, SdoAbort
from achse.ethercat import Loopback

NO_ERROR = AlStatus.NO_ERROR


def test_outputs_become_inputs_in_the_next_cycle() -> None:
    application = Loopback(2)
    application.enter(AlState.OP, 0, NO_ERROR)
    application.write_outputs(b"ab")
    assert application.read_inputs() == b"\0\0"
    assert application.step(250_000) is NO_ERROR
    assert application.read_inputs() == b"ab"


def test_out_of_op_outputs_are_zero() -> None:
    application = Loopback(1)
    application.write_outputs(b"x")
    application.enter(AlState.SAFEOP, 0, AlStatus.WATCHDOG)
    application.step(250_000)
    assert application.read_inputs() == b"\0"


def test_objects_have_what_their_entries_say() -> None:
    application = Loopback(3)
    for each in application.objects():
        for entry in each.entries:
            value = application.read_object(each.index, entry.subindex)
            if each.index != 0x2000:
                assert len(value) * 8 == entry.bits, (hex(each.index), entry.subindex)


def test_the_mapping_names_objects_that_are_there() -> None:
    application = Loopback(3)
    for mapping in (0x1600, 0x1A00):
        for subindex in (1, 2, 3):
            value = int.from_bytes(application.read_object(mapping, subindex), "little")
            assert value & 0xFF == 8
            application.read_object(value >> 16, value >> 8 & 0xFF)


@pytest.mark.parametrize(
    ("index", "subindex", "data", "code"),
    [
        (0x1000, 0, b"1234", AbortCode.READ_ONLY),
        (0x7000, 1, b"12", AbortCode.LENGTH),
        (0x7000, 9, b"1", AbortCode.NO_SUBINDEX),
        (0x7001, 0, b"1", AbortCode.NO_OBJECT),
    ],
)
def test_refusals(index: int, subindex: int, data: bytes, code: AbortCode) -> None:
    with pytest.raises(SdoAbort) as refusal:
        Loopback().write_object(index, subindex, data)
    assert refusal.value.code is code


def test_faults_happen_once() -> None:
    application = Loopback()
    application.refuse = application.fault = AlStatus.UNSPECIFIED
    answers = [application.enter(AlState.PREOP, 0, NO_ERROR) for _ in range(2)]
    assert answers == [AlStatus.UNSPECIFIED, NO_ERROR]
    assert [application.step(1), application.step(1)] == [AlStatus.UNSPECIFIED, NO_ERROR]
    application.emergencies.append(b"12345678")
    assert [application.take_emergency(), application.take_emergency()] == [b"12345678", None]
