"""The image of a bus: each entry, state and counter has a place and a value."""

from dataclasses import replace
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import NetId
from achse.codes import AlState
from achse.devices.io import ServedBus, default_net_id
from achse.devices.io.image import INPUT_BASE, OUTPUT_BASE, BusImage, ImageVariable, distinct
from achse.ethercat import Loopback, Segment, Slave, describe
from achse.ethercat.description import Pdo, PdoEntry
from achse.ethercat.master import (
    BusConfiguration,
    Master,
    Ring,
    SlaveConfiguration,
    from_description,
)
from achse.ethercat.master.configuration import ProcessSyncManager
from achse.ethercat.ring_segment import RingSegment

STATION = NetId("10.1.2.3.1.1")


def named(image: BusImage) -> dict[str, ImageVariable]:
    return dict(distinct(image.variables))


def test_variables_of_bus_and_boxes(io: Any) -> None:
    image = BusImage(io.up().served)
    result = named(image)
    assert result["InfoData.CfgSlaveCount"].read() == b"\3\0"
    assert result["InfoData.AmsNetId"].read() == bytes(io.served.net_id)
    assert result["Inputs.SlaveCount"].read() == b"\3\0"
    assert result["Inputs.DevState"].read() == b"\0\0"
    assert result["Inputs.Frm0WcState"].read() == b"\0\0"
    assert result["Box 2.WcState.WcState"].read() == b"\0"
    assert result["Box 2.InfoData.State"].read() == b"\x08\0"
    assert result["Box 2.InfoData.AdsAddr"].read() == bytes(io.served.net_id) + b"\xea\3"
    assert result["Box 1.InfoData.DcOutputShift"].read() == (500_000).to_bytes(4, "little")
    assert "Box 2.InfoData.DcOutputShift" not in result
    assert "Inputs.SlaveCount2" not in result
    status = next(
        each
        for name, each in result.items()
        if name.startswith("Box 1.") and (name.endswith("Statusword"))
    )
    io.run()
    assert int.from_bytes(status.read(), "little") == io.master.slaves[0].read_input(0x6041)
    assert status.place == (0xF020, INPUT_BASE + status.bit // 8)
    outputs = [each for each in image.variables if each.output]
    assert {each.place[0] for each in outputs} == {0xF030}
    assert outputs[0].place[1] == OUTPUT_BASE
    toggle = result["Box 1.WcState.InputToggle"]
    before = toggle.read()
    io.run()
    assert toggle.read() != before
    assert toggle.place == (0xF021, 8 * INPUT_BASE + toggle.bit)


def test_contents_are_all_variables_in_their_places(io: Any) -> None:
    image = BusImage(io.up().served)
    for output in (False, True):
        contents = int.from_bytes(image.contents(output), "little")
        taken = 0
        for each in image.variables:
            if each.output == output:
                mask = (1 << each.bits) - 1
                assert not taken >> each.bit & mask, each.name
                taken |= mask << each.bit
                value = int.from_bytes(each.read(), "little")
                assert contents >> each.bit & mask == value, each.name


@given(
    entries=st.lists(
        st.tuples(st.integers(0, 0x1B), st.integers(1, 80), st.sampled_from(["", "a", "b"])),
        min_size=1,
        max_size=12,
    ),
    data=st.binary(min_size=120, max_size=120),
)
def test_entries_of_any_kind(entries: list[tuple[int, int, str]], data: bytes) -> None:
    results = [
        PdoEntry(0x6000 + number, 0, bits, name, kind)
        for number, (kind, bits, name) in enumerate(entries)
    ]
    pdo = Pdo(0x1A00, "in", 3, False, tuple(results))
    slave = SlaveConfiguration(
        "Box", sync_managers=(ProcessSyncManager(3, 0x1000, 0x20, False),), inputs=(pdo,)
    )
    master = Master(BusConfiguration((slave,)))
    master.cyclic.exchanged(0)[:] = data[: len(master.slaves[0].inputs)]
    result = named(BusImage(ServedBus(1, master, default_net_id(STATION, 1))))
    whole = int.from_bytes(data, "little")
    at = 0
    values = [each for name, each in result.items() if name.startswith("Box.in.")]
    assert len(values) == len(entries)
    for variable, (_, bits, _) in zip(values, entries, strict=True):
        assert int.from_bytes(variable.read(), "little") == whole >> at & (1 << bits) - 1
        assert 8 * variable.type.size >= bits
        at += bits


@settings(max_examples=6)
@given(data=st.data(), count=st.integers(1, 5))
def test_a_ring_shows_both_adapters_and_where_it_is_open(data: st.DataObject, count: int) -> None:
    line = [Loopback() for _ in range(count)]
    segment = RingSegment(map(Slave, line))
    slaves = tuple(from_description(describe(each), f"Box {n}") for n, each in enumerate(line))
    master = Master(BusConfiguration(slaves, cycle_ns=1_000_000, redundant=True))
    ring = Ring(master, segment)
    served = ServedBus(1, master, default_net_id(STATION, 1))
    master.request(AlState.OP)
    ring.run(300_000_000)
    result = named(BusImage(served))

    def shown() -> list[int]:
        names = ("SlaveCount", "SlaveCount2", "DevState", "DevState2", "Frm0WcState")
        return [int.from_bytes(result[f"Inputs.{name}"].read(), "little") for name in names]

    for cable in data.draw(st.permutations(range(count + 1)), label="cut in this order"):
        assert shown() == [count, 0, 0, 0, 0]
        segment.cut(cable)
        ring.run(master.now_ns + 20_000_000)
        lost = {0: 0x0001, count: 0x0004}.get(cable, 0)
        reached = [count, 0] if cable == count else [cable, count - cable]
        assert shown() == [*reached, lost | 0x0008, int(cable == count), 0]
        links = [0] * count
        if cable > 0:
            links[cable - 1] |= 0x24
        if cable < count:
            links[cable] |= 0x14
        assert [served.state_bytes(each)[1] for each in master.slaves] == links
        segment.mend(cable)
        ring.run(master.now_ns + data.draw(st.integers(10, 60), label="whole for ms") * 1_000_000)
    assert shown() == [count, 0, 0, 0, 0]


def test_names_that_occur_twice_are_numbered(io: Any) -> None:
    variable = BusImage(io.served).variables[0]
    other = replace(variable, name="other")
    names = [name for name, _ in distinct([variable, variable, other])]
    assert names == [variable.name, f"{variable.name}_2", "other"]
    assert isinstance(io.segment, Segment)
