"""Slaves made from ESI files, brought to Op by our master as the file or a scan describes them."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from achse.codes import AbortCode, AlState, AlStatus
from achse.ethercat import Segment
from achse.ethercat.master import (
    BusConfiguration,
    Master,
    Ring,
    SlaveConfiguration,
)
from achse.ethercat.master.esi_reader import EsiDevice, from_esi, read_esi
from achse.ethercat.master.scanning import scan_bus
from achse.ethercat.registers import Register
from achse.ethercat.virtual import LoopBack, VirtualSlave, make_slave
from tests.ethercat.virtual.esi_text import (
    ANALOG,
    DIGITAL_IN,
    DIGITAL_OUT,
    device,
    drawn_devices,
    esi,
    pdo,
)

CYCLE_NS = 1_000_000


def read_one(text: str, name: str = "") -> EsiDevice:
    devices = read_esi(esi(text))
    return next(each for each in devices if not name or each.type_name == name)


class Bus:
    """A master on slaves in one process."""

    def __init__(
        self, slaves: list[VirtualSlave], configurations: list[SlaveConfiguration]
    ) -> None:
        self.segment = Segment(slaves)
        self.master = Master(BusConfiguration(tuple(configurations), cycle_ns=CYCLE_NS))
        self.ring = Ring(self.master, self.segment)

    def run(self, cycles: int = 1) -> None:
        for _ in range(cycles):
            self.ring.exchange(self.segment.time.now_ns + CYCLE_NS)

    def up(self) -> "Bus":
        self.master.request(AlState.OP)
        for _ in range(3000):
            self.run()
            if self.master.operational:
                return self
        pytest.fail(str([each.last_trouble for each in self.master.slaves]))

    def do(self, steps: Any) -> Any:
        job = self.master.run(steps)
        for _ in range(5000):
            if job.is_done:
                return job.result()
            self.run()
        pytest.fail("not done")


def bus_of(*slaves: VirtualSlave) -> Bus:
    return Bus(list(slaves), [from_esi(each.device.esi, cycle_ns=CYCLE_NS) for each in slaves])


@given(text=drawn_devices(), serial=st.integers(0, 0xFFFF_FFFF), data=st.data())
def test_any_device_goes_to_op_and_exchanges_its_data(
    text: str, serial: int, data: st.DataObject
) -> None:
    slave = make_slave(read_one(text), serial_number=serial)
    bus = bus_of(slave).up()
    (mine,) = bus.master.slaves
    result = slave.device
    assert (len(mine.outputs), len(mine.inputs)) == (result.output_size, result.input_size)
    sent = data.draw(st.binary(min_size=len(mine.outputs), max_size=len(mine.outputs)))
    inputs = data.draw(st.binary(min_size=len(mine.inputs), max_size=len(mine.inputs)))
    mine.outputs[:] = sent
    result.write_all_inputs(inputs)
    bus.run(2)
    assert (result.all_outputs(), bytes(mine.inputs)) == (sent, inputs)
    assert slave.state is AlState.OP


@given(text=drawn_devices())
def test_scan_finds_what_the_file_says(text: str) -> None:
    described = read_one(text)
    slave = make_slave(described)
    bus = Bus([slave], [])
    steps = scan_bus()
    result = None
    try:
        back = next(steps)
        now = 0
        while True:
            back, now = play(bus.segment, steps, back, now)
    except StopIteration as end:
        (result,) = end.value
    assert not result.trouble
    assert result.facts.identity[:3] == (0xE51, 0x1001, 0x10000)
    mapped = from_esi(described)
    for output in (True, False):
        wanted = sum(mapped.bits(m) for m in mapped.sync_managers if m.output == output)
        mine = result.configuration
        assert sum(mine.bits(m) for m in mine.sync_managers if m.output == output) == wanted


def play(segment: Segment, steps: Any, request: Any, now: int) -> tuple[Any, int]:
    """One step of a request on a segment without a master."""
    from achse.ethercat import EthercatFrame
    from achse.ethercat.master.steps import Round, Trip

    now += 50_000 if isinstance(request, Trip) else request.ns
    segment.advance(now)
    datagrams: Any = ()
    if isinstance(request, Trip):
        reply = segment.process(EthercatFrame(request.datagrams).encode())
        assert reply is not None
        datagrams = EthercatFrame.decode(reply).datagrams
    return steps.send(Round(datagrams, now)), now


def test_inputs_are_set_and_outputs_read_by_name() -> None:
    switches, lamps = make_slave(read_one(DIGITAL_IN)), make_slave(read_one(DIGITAL_OUT))
    bus = bus_of(switches, lamps).up()
    switches.device.set_input("PDO 1A02.Input", True)
    bus.master.slaves[1].outputs[0] = 0x81
    bus.run(2)
    assert bytes(bus.master.slaves[0].inputs) == b"\x04"
    assert [n for n in range(8) if lamps.device.output(f"Lamp {n}")] == [0, 7]
    bus.master.request(AlState.SAFEOP)
    bus.run(100)
    assert lamps.device.output("Lamp 7") is False


def test_alternative_is_assigned_and_its_values_stay() -> None:
    esi_device = read_one(ANALOG)
    slave = make_slave(esi_device)
    slave.device.set_input("PDO 1A01.Value", -5)
    slave.device.set_input("Level", 2.5)
    bus = Bus([slave], [from_esi(esi_device, pdos=[0x1600, 0x1A01, 0x1A02])]).up()
    assert bytes(bus.master.slaves[0].inputs) == b"\xfb\xff\x00\x00\x20\x40"
    assert slave.device.input("Value") == -5


@pytest.mark.parametrize(
    ("pdos", "code"),
    [([0x1A00, 0x1A01], AbortCode.NOT_MAPPABLE), ([0x1600], AbortCode.NOT_MAPPABLE)],
)
def test_assignment_that_cannot_be_is_refused(pdos: list[int], code: AbortCode) -> None:
    slave = make_slave(read_one(ANALOG))
    bus = bus_of(slave)
    bus.master.request(AlState.PREOP)
    bus.run(200)
    write = slave.device.write_object
    write(0x1C13, 0, b"\0")
    for number, index in enumerate(pdos, 1):
        write(0x1C13, number, index.to_bytes(2, "little"))
    with pytest.raises(Exception, match=f"{code.number:08X}"):
        write(0x1C13, 0, bytes((len(pdos),)))


def test_wrong_length_of_a_sync_manager_is_an_al_status_code() -> None:
    from dataclasses import replace

    slave = make_slave(read_one(ANALOG))
    configuration = from_esi(slave.device.esi)
    short = replace(configuration, inputs=(), assign=False)
    bus = Bus([slave], [short])
    bus.master.request(AlState.OP)
    bus.run(500)
    assert (slave.state, slave.error) == (AlState.PREOP, AlStatus.INPUT_CONFIGURATION)
    assert bus.master.slaves[0].al_code == AlStatus.INPUT_CONFIGURATION.number


def test_mailbox_refuses_protocols_that_the_file_does_not_name() -> None:
    plain = device(
        ANALOG.partition("<GroupType>Boxes</GroupType>")[2]
        .partition("</Device>")[0]
        .replace('<CoE SdoInfo="1" PdoAssign="1" PdoConfig="1" CompleteAccess="1"/>', "")
    )
    slave = make_slave(read_one(plain))
    bus = bus_of(slave).up()
    message = b"\x0a\0\0\0\0\x13" + b"\0\x20\x40\0\x10\0" + bytes(4)
    assert slave.esc.write(0x1000, message.ljust(128, b"\0"))
    answer = slave.esc.read(0x1080, 128)
    assert answer is not None
    assert (answer[5] & 0x0F, answer[6:10]) == (0, b"\x01\x00\x02\x00")
    assert bus.master.operational


@given(alias=st.integers(1, 0xFFFF))
def test_identification_by_status_by_alias_and_in_memory(alias: int) -> None:
    body = "<Info><IdentificationAdo>#x1002</IdentificationAdo></Info>" + pdo("RxPdo", 0x1600, [])
    slave = make_slave(read_one(device(body)), alias=alias)
    number = alias.to_bytes(2, "little")
    for _ in range(2):
        assert slave.esc.read(0x1002, 2) == number
        assert slave.esc.look(Register.STATION_ALIAS, 2) == number
        slave.esc.write(Register.AL_CONTROL, b"\x21\0")
        assert slave.esc.look(Register.AL_STATUS, 6)[4:] == number
        slave.reset()


def test_loop_back_gives_outputs_as_inputs() -> None:
    slave = make_slave(read_one(ANALOG), behaviour=LoopBack())
    bus = bus_of(slave).up()
    bus.master.slaves[0].outputs[:] = b"\x34\x12"
    bus.run(3)
    assert bytes(bus.master.slaves[0].inputs) == b"\x34\x12\x00\x00"


def test_slave_that_was_not_there_joins() -> None:
    """Hot connect: an optional slave comes to Op once its cable is plugged in."""
    from dataclasses import replace

    first, second = make_slave(read_one(DIGITAL_IN)), make_slave(read_one(ANALOG))
    parts = [from_esi(each.device.esi) for each in (first, second)]
    bus = Bus([first, second], [parts[0], replace(parts[1], optional=True)])
    bus.segment.break_link(second)
    bus.master.request(AlState.OP)
    bus.run(500)
    assert (first.state, second.state) == (AlState.OP, AlState.INIT)
    bus.segment.repair_link(second)
    bus.run(3000)
    assert second.state is AlState.OP
