"""Parameters and states by name, at a station."""

import asyncio
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from achse.ams import AmsAddress, DeviceError
from achse.client import connect
from achse.client.nc import AxisRefused, RemoteNc, UnknownService
from achse.codes import NcError, ReturnCode
from achse.devices.nc.layouts import ONLINE_TC2, ONLINE_TC3
from achse.station import Station
from achse.station.configuration.station_file import parse


def test_read_write_unit_and_range(on_bench: Callable[..., Any]) -> None:
    async def test(bench: Any) -> None:
        value = bench.axis.parameters["Max Velocity"]
        assert await value == 2000.0
        await value.write(500)
        assert await bench.axis.parameters["max_velocity"].read() == 500.0
        assert (value.unit, value.range, value.writable) == ("mm/s", "0.001..1e+20", True)
        assert "max_velocity [mm/s]" in repr(value)
        assert value.description

    on_bench(test)


def test_the_unit_of_the_axis(on_bench: Callable[..., Any]) -> None:
    async def test(bench: Any) -> None:
        c = bench.client.nc.axis("C")
        assert await c.unit() == "degree"
        assert c.parameters["max velocity"].unit == "degree/s"

    on_bench(test)


def test_refusals_say_what_was_expected(on_bench: Callable[..., Any]) -> None:
    async def test(bench: Any) -> None:
        with pytest.raises(AxisRefused, match=r"expected 0\.001\.\.1e\+20") as caught:
            await bench.axis.parameters["max velocity"].write(-1.0)
        assert (caught.value.code, caught.value.axis) == (0x432F, "X")

    on_bench(test)


@pytest.mark.parametrize("value", ["fast", None, [], 1j])
def test_what_is_not_a_number_is_not_sent(on_bench: Callable[..., Any], value: Any) -> None:
    async def test(bench: Any) -> None:
        with pytest.raises(ValueError, match="max_velocity"):
            await bench.axis.parameters["max velocity"].write(value)

    on_bench(test)


def test_choices_by_name(on_bench: Callable[..., Any]) -> None:
    async def test(bench: Any) -> None:
        mode = bench.axis.parameters["encoder reference mode"]
        await bench.axis.disable()
        await mode.write("hardware sync")
        assert (await mode).name == "HARDWARE_SYNC"
        await mode.write(5)
        assert await mode == 5
        assert "2=HARDWARE_SYNC" in mode.range
        with pytest.raises(ValueError, match="2=HARDWARE_SYNC"):
            await mode.write("hardware")

    on_bench(test)


def test_all_of_them_at_once(on_bench: Callable[..., Any]) -> None:
    async def test(bench: Any) -> None:
        parameters, states = await bench.axis.parameters.read(), await bench.axis.states.read()
        assert parameters["max_velocity"] == 2000.0
        assert parameters["axis_name"] == "X"
        assert {"set_position", "actual_position", "set_torque"} <= states.keys()
        assert len(parameters) > 150
        assert "max velocity" in bench.axis.parameters
        assert "colour" not in bench.axis.parameters

    on_bench(test)


def test_what_is_only_shown_and_what_does_not_exist(on_bench: Callable[..., Any]) -> None:
    async def test(bench: Any) -> None:
        with pytest.raises(ValueError, match="for reading only"):
            await bench.axis.states["set position"].write(1.0)
        with pytest.raises(UnknownService, match="did you mean max_velocity"):
            bench.axis.parameters["max velocty"]
        with pytest.raises(ValueError, match="element: expected"):
            bench.axis.parameters.element(9)
        with pytest.raises(AxisRefused):
            await bench.axis.parameters.element(3)["encoder scaling factor"]
        assert await bench.axis.parameters.element(0)["encoder scaling factor"] > 0

    on_bench(test)


class OldNc:
    """An NC that answers the TwinCAT 2 structure, whatever is asked or only if asked for it."""

    address = AmsAddress("1.2.3.4.1.1:500")
    session = SimpleNamespace(losses=0)

    def __init__(self, refuses: bool) -> None:
        self.refuses = refuses
        self.lengths: list[int] = []

    async def read_raw(self, group: int, offset: int, length: int) -> bytes:
        assert (group, offset) == (0x4105, 0)
        self.lengths.append(length)
        if self.refuses and length != ONLINE_TC2.size:
            raise DeviceError(ReturnCode.INVALID_SIZE)
        return b"\x60\x42\0\0" + bytes(ONLINE_TC2.size - 4)


@pytest.mark.parametrize(
    ("refuses", "lengths"),
    [(False, [ONLINE_TC3.size]), (True, [ONLINE_TC3.size, ONLINE_TC2.size])],
)
def test_the_shorter_structure_of_an_older_nc(refuses: bool, lengths: list[int]) -> None:
    old: Any = OldNc(refuses)

    async def read() -> Any:
        return await RemoteNc(old).axis(5).states["axis online structure"]

    online = asyncio.run(read())
    assert online["error_code"] == NcError.CONTROLLER_ENABLE_MISSING.number
    assert "set_acceleration" not in online
    assert old.lengths == lengths


def test_further_elements_have_values_of_their_own() -> None:
    element = {"encoder_scaling_factor": 0.005}
    axes = [{"id": 7, "name": "Z", "encoder_ids": [7, 40], "element": [element]}]
    station = Station(parse({"axis": axes}, ""))

    async def question() -> list[Any]:
        async with connect(station.router, keep_alive=None) as client:
            parameters = client.nc.axis("Z").parameters
            factors = [parameters.element(n)["encoder scaling factor"] for n in (0, 1)]
            before = await factors[1]
            await factors[1].write(0.25)
            return [before, *[await each for each in factors]]

    assert asyncio.run(question()) == [0.005, 0.0001, 0.25]


def test_of_an_element_only_what_it_has_is_listed(on_bench: Callable[..., Any]) -> None:
    async def test(bench: Any) -> None:
        first = {each.name for each in bench.axis.states.element(1)}
        assert first
        assert "set_position" not in first
        every = {each.name for each in bench.axis.parameters}
        assert "max_velocity" in every
        assert not every & {"axis_parameter_structure", "hardware_ams_address"}

    on_bench(test)
