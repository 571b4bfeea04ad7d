"""Slaves with other SyncManagers than four: several of a direction, none for a mailbox."""

from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import AlState, AlStatus
from achse.ethercat import (
    Datagram,
    DatagramCommand,
    EthercatFrame,
    Loopback,
    Segment,
    Slave,
    build_sii,
    describe,
)
from achse.ethercat.description import SiiUse, SlaveMemory, SyncManagerArea
from achse.ethercat.eeprom import checksum
from achse.ethercat.process_buffers import process_buffers
from achse.ethercat.registers import DIGITAL_OUTPUTS, FMMU_BASE, SM_BASE, Register

BOOT = SyncManagerArea(0x1000, 128, 0x26)


class Outputs(Loopback):
    """Outputs in two SyncManagers, inputs in a third."""

    def __init__(self) -> None:
        super().__init__()
        self.images = {0: b"", 1: b""}

    def buffer_size(self, number: int) -> int:
        return (1, 2, 3)[number]

    def buffer_writer(self, number: int) -> Callable[[bytes], None]:
        return lambda data: self.images.update({number: data})

    def buffer_reader(self, number: int) -> Callable[[], bytes]:
        return lambda: bytes((number, 0xAA, 0x55))


def memory(start: int = DIGITAL_OUTPUTS) -> SlaveMemory:
    outputs = [SyncManagerArea(start, 1, 0x44), SyncManagerArea(0x1100, 2, 0x44)]
    inputs = SyncManagerArea(0x1000, 3, 0x00)
    managers = [*((SiiUse.OUTPUTS, each) for each in outputs), (SiiUse.INPUTS, inputs)]
    return SlaveMemory(tuple(managers), BOOT, BOOT)


def slave(*, emulated: bool = False) -> Slave:
    image = bytearray(build_sii(describe(Loopback())))
    image[1] |= emulated
    image[14] = checksum(image)
    return Slave(Outputs(), sii=bytes(image), memory=memory(), coe=False)


def request(device: Slave, state: int) -> None:
    device.esc.write(Register.AL_CONTROL, bytes((state, 0)))


def open_managers(device: Slave, lengths: tuple[int, ...] = (1, 2, 3)) -> None:
    for number, ((_, area), length) in enumerate(zip(device.memory.managers, lengths, strict=True)):
        head = area.start.to_bytes(2, "little") + length.to_bytes(2, "little")
        registers = head + bytes((area.control, 0, 1, 0))
        device.esc.write(SM_BASE + 8 * number, registers)


def test_each_manager_has_its_buffer() -> None:
    buffers = process_buffers(Outputs(), memory())
    assert [(each.number, each.output, each.size()) for each in buffers] == [
        (0, True, 1), (1, True, 2), (2, False, 3),
    ]  # fmt: skip
    assert [each.fault for each in buffers[1:]] == [
        AlStatus.OUTPUT_CONFIGURATION,
        AlStatus.INPUT_CONFIGURATION,
    ]


def test_plain_application_has_one_buffer_of_each_direction() -> None:
    buffers = process_buffers(Loopback(2), memory())
    assert [(each.number, each.size()) for each in buffers] == [(0, 2), (2, 2)]


def test_slave_without_mailbox_goes_to_op_with_all_outputs() -> None:
    device = slave()
    request(device, AlState.PREOP)
    open_managers(device)
    request(device, AlState.SAFEOP)
    assert (device.state, device.error) == (AlState.SAFEOP, AlStatus.NO_ERROR)
    request(device, AlState.OP)
    assert device.esc.write(DIGITAL_OUTPUTS, b"\x07")
    assert device.state is AlState.SAFEOP, "outputs of the second SyncManager are missing"
    assert device.esc.write(0x1100, b"\x01\x02")
    assert device.state is AlState.OP
    assert isinstance(device.application, Outputs)
    assert device.application.images == {0: b"\x07", 1: b"\x01\x02"}
    assert device.esc.read(0x1000, 3) == b"\x02\xaa\x55"
    request(device, AlState.INIT)
    assert device.esc.write(0x1100, b"\x01\x02") is False


@given(place=st.integers(0, 2), length=st.integers(0, 9))
def test_wrong_length_is_an_al_status_code(place: int, length: int) -> None:
    lengths = [1, 2, 3]
    good = lengths[place] == length
    lengths[place] = length
    device = slave()
    request(device, AlState.PREOP)
    open_managers(device, tuple(lengths))
    request(device, AlState.SAFEOP)
    fault = AlStatus.INPUT_CONFIGURATION if place == 2 else AlStatus.OUTPUT_CONFIGURATION
    assert device.error is (AlStatus.NO_ERROR if good else fault)
    assert device.state is (AlState.SAFEOP if good else AlState.PREOP)


@given(states=st.lists(st.sampled_from(list(AlState)), min_size=1, max_size=6))
def test_controller_without_a_program_takes_over_each_state(states: list[AlState]) -> None:
    device = slave(emulated=True)
    for state in states:
        request(device, state | 0x10)
        status = device.esc.look(Register.AL_STATUS, 6)
        assert (device.state, status) == (state, bytes((state, 0, 0, 0, 0, 0)))


def test_outputs_of_a_controller_without_a_program_are_off_once_they_stop() -> None:
    device = slave(emulated=True)
    segment = Segment([device])
    open_managers(device)
    request(device, AlState.OP)
    fmmu = (0).to_bytes(4, "little") + (2).to_bytes(2, "little") + b"\0\x07\0\x11\0\x02\x01\0\0\0"
    device.esc.write(FMMU_BASE, fmmu)
    assert isinstance(device.application, Outputs)
    images = device.application.images
    for value in (b"\x01\x02", b"\x03\x04"):
        frame = EthercatFrame((Datagram(DatagramCommand.LWR, 0, value),)).encode()
        assert segment.process(frame) is not None
        assert images[1] == value
        assert device.esc.memory[Register.PROCESS_WATCHDOG_STATUS] == 1
        segment.advance(segment.time.now_ns + 150_000_000)
        assert (device.state, images[1]) == (AlState.OP, bytes(2))
        assert device.esc.memory[Register.PROCESS_WATCHDOG_STATUS] == 0


@given(lengths=st.tuples(st.integers(0, 4), st.integers(0, 4), st.integers(0, 6)))
def test_hardware_without_a_program_takes_any_length(lengths: tuple[int, int, int]) -> None:
    device = slave(emulated=True)
    segment = Segment([device])
    open_managers(device, lengths)
    request(device, AlState.OP)
    data = bytes(range(1, lengths[1] + 1))
    assert isinstance(device.application, Outputs)
    if data:
        assert device.esc.write(0x1100, data)
        assert device.application.images[1] == data[:2].ljust(2, b"\0")
    if lengths[2]:
        head = bytes(4) + bytes((lengths[2], 0)) + b"\0\x07\0\x10\0\x01\x01\0\0\0"
        device.esc.write(FMMU_BASE, head)
        frame = EthercatFrame((Datagram(DatagramCommand.LRD, 0, bytes(lengths[2])),)).encode()
        for _ in range(2):
            reply = segment.process(frame)
            assert reply is not None
            (back,) = EthercatFrame.decode(reply).datagrams
            assert back.data == b"\x02\xaa\x55"[: lengths[2]].ljust(lengths[2], b"\0")


@pytest.mark.parametrize("number", [0, 1])
def test_mailbox_needs_both_directions(number: int) -> None:
    areas = [(SiiUse.MAILBOX_OUT, BOOT), (SiiUse.MAILBOX_IN, BOOT)]
    assert SlaveMemory(tuple(areas), BOOT, BOOT).mailbox() == ((0, BOOT), (1, BOOT))
    assert SlaveMemory((areas[number],), BOOT, BOOT).mailbox() is None
