"""An NC from outside: rows give numbers and layouts, old and new structures are read."""

import asyncio
from collections.abc import Callable, Iterable
from typing import Any

import pytest

from achse.ams import AmsAddress, DeviceError
from achse.cli.nc import (
    CYCLIC,
    FUNCTIONS,
    PARAMETERS,
    NcAxis,
    UnknownAxis,
    axes_of,
    chosen,
    flag_names,
    motion_state,
)
from achse.client import Client, connect
from achse.codes import NcError, ReturnCode
from achse.devices.nc.layouts import ONLINE_TC2, ONLINE_TC3
from achse.motion.states import StartType, StateBit
from achse.station import Station
from achse.station.config import parse


@pytest.fixture
def ask() -> Callable[..., Any]:
    """`ask(question)` runs `question(client)` against the NC of a demo station, in process."""
    station = Station.demo()
    station.advance(0.01)

    def run(question: Callable[[Client], Any]) -> Any:
        async def main() -> Any:
            async with connect(station.router, port=501, keep_alive=None) as client:
                return await question(client)

        return asyncio.run(main())

    return run


def test_all_axes_with_name_and_unit(ask: Callable[..., Any]) -> None:
    axes = ask(axes_of)
    assert [(axis.axis_id, axis.name, axis.unit) for axis in axes] == [
        (1, "X", "mm"),
        (2, "Y", "mm"),
        (3, "C", "degree"),
    ]


@pytest.mark.parametrize(
    ("wanted", "ids"), [(["c", "1"], [3, 1]), (["2"], [2]), ([], [1, 2, 3]), (["X", "x"], [1, 1])]
)
def test_axes_are_chosen_by_id_or_name(
    ask: Callable[..., Any], wanted: list[str], ids: list[int]
) -> None:
    async def question(client: Client) -> list[NcAxis]:
        return await chosen(client, wanted)

    assert [axis.axis_id for axis in ask(question)] == ids


@pytest.mark.parametrize("wanted", ["Q", "0", "256", "70000"])
def test_what_can_be_no_axis_is_told_with_those_there_are(
    ask: Callable[..., Any], wanted: str
) -> None:
    with pytest.raises(UnknownAxis, match="1 X, 2 Y, 3 C"):
        ask(lambda client: chosen(client, ["1", wanted]))


def test_an_id_that_no_axis_has_is_the_errors_of_the_nc(ask: Callable[..., Any]) -> None:
    with pytest.raises(DeviceError, match="axis 9") as refusal:
        ask(lambda client: chosen(client, ["9"]))
    assert refusal.value.code == NcError.AXIS_ID.number


def test_the_online_structure_by_field(ask: Callable[..., Any]) -> None:
    online = ask(lambda client: NcAxis(client, 1).online())
    assert online["actual_position"] == 0.0
    assert online["velocity_override"] == 0
    assert online["state_dword"] & StateBit.NOT_MOVING


def test_services_are_written_and_read_by_name(ask: Callable[..., Any]) -> None:
    async def question(client: Client) -> Any:
        axis = NcAxis(client, 2)
        await axis.write(CYCLIC, "velocity_override", 500_000)
        return await axis.read(CYCLIC, "velocity_override")

    assert ask(question) == 500_000


def test_further_elements_have_values_of_their_own() -> None:
    axes = [
        {
            "id": 7,
            "name": "Z",
            "encoder_ids": [7, 40],
            "element": [{"encoder_scaling_factor": 0.005}],
        }
    ]
    station = Station(parse({"axis": axes}, ""))
    name = "encoder_scaling_factor"

    async def question() -> list[Any]:
        async with connect(station.router, port=501, keep_alive=None) as client:
            axis = NcAxis(client, 7)
            before = await axis.read(PARAMETERS, name, element=1)
            await axis.write(PARAMETERS, name, 0.25, element=1)
            return [before] + [await axis.read(PARAMETERS, name, element=n) for n in (0, 1)]

    assert asyncio.run(question()) == [0.005, 0.0001, 0.25]


def test_a_refusal_names_axis_and_service(ask: Callable[..., Any]) -> None:
    async def question(client: Client) -> Any:
        [axis] = await chosen(client, ["X"])
        start = (StartType.ABSOLUTE, 0, 10.0, 10.0, *[0.0] * 3, 0, *[0.0] * 3)
        return await axis.exchange(FUNCTIONS, "universal_axis_start", *start)

    with pytest.raises(DeviceError, match="X, universal axis start: 0x4260"):
        ask(question)


class OldNc:
    """An NC that answers the TwinCAT 2 structure, whatever is asked or only if asked for it."""

    address = AmsAddress("1.2.3.4.1.1:500")

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
    online = asyncio.run(NcAxis(old, 5).online())
    assert online["error_code"] == NcError.CONTROLLER_ENABLE_MISSING.number
    assert "set_acceleration" not in online
    assert old.lengths == lengths


def _bits(names: str) -> int:
    return sum(StateBit[name] for name in names.split())


@pytest.mark.parametrize(
    ("flags", "state"),
    [
        ("", "Disabled"),
        ("NOT_MOVING HOMED", "Disabled"),
        ("OPERATIONAL", "Standstill"),
        ("CONTROL_LOOP_CLOSED", "Standstill"),
        ("OPERATIONAL HAS_JOB", "DiscreteMotion"),
        ("OPERATIONAL HAS_JOB CONTINUOUS_MOTION", "ContinuousMotion"),
        ("OPERATIONAL HAS_JOB HOMING_BUSY", "Homing"),
        ("OPERATIONAL PROTECTED HAS_JOB", "SynchronizedMotion"),
        ("OPERATIONAL MOTION_COMMANDS_LOCKED HAS_JOB", "Stopping"),
        ("OPERATIONAL MOTION_COMMANDS_LOCKED ERROR", "ErrorStop"),
    ],
)
def test_the_plcopen_state(flags: str, state: str) -> None:
    assert motion_state(_bits(flags)) == state


def test_flags_in_words() -> None:
    names: Iterable[str] = flag_names(_bits("HOMED NOT_MOVING ERROR"))
    assert names == ["homed", "not moving", "error"]
