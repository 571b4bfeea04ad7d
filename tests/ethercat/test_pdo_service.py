"""PDOs by mailbox, the slave's end: what is mapped, as it is mapped."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import AbortCode, AlState, AlStatus, SdoAbort
from achse.drive import Drive
from achse.ethercat import Loopback
from achse.ethercat.application import Application
from achse.ethercat.pdo_service import RX_PDO, TX_PDO, PdoService
from achse.ethercat.terminals import DigitalTerminal


def service(application: Application) -> PdoService:
    return PdoService(application, {each.index: each for each in application.objects()})


@given(st.lists(st.booleans(), min_size=1, max_size=64))
def test_bits_are_packed_as_in_process_data(channels: list[bool]) -> None:
    terminal = DigitalTerminal(len(channels), 1)
    for number, on in enumerate(channels):
        terminal.set_input(number, on)
    assert service(terminal).read(TX_PDO) == terminal.input_image


@given(st.integers(-(2**31), 2**31 - 1), st.integers(0, 2**16 - 1))
def test_what_is_written_is_read(target: int, torque: int) -> None:
    """In PreOp, where process data do not flow; padding is passed over."""
    entries = (0x607A_0020, 0x0000_0008, 0x6072_0010)
    drive = Drive(mapping={0x1600: entries}, strict_mapping=False)
    drive.enter(AlState.PREOP, 0, AlStatus.NO_ERROR)
    pdos = service(drive)
    data = struct.pack("<ixH", target, torque % 3001)
    pdos.write(RX_PDO, data)
    assert drive.get(0x607A) == target
    assert pdos.read(RX_PDO) == data


def test_refusals() -> None:
    pdos = service(Loopback(4))
    assert pdos.read(TX_PDO) == bytes(4)
    for refused, code in (
        (lambda: pdos.read(TX_PDO + 9), AbortCode.NO_OBJECT),
        (lambda: pdos.write(RX_PDO, bytes(3)), AbortCode.LENGTH),
    ):
        with pytest.raises(SdoAbort) as abort:
            refused()
        assert abort.value.code is code
