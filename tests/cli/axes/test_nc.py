"""The axes that commands name, and what they print of them."""

import asyncio
from collections.abc import Callable, Iterable
from typing import Any

import pytest

from achse.cli.axes.nc import NcAxis, axes_of, chosen, motion_state
from achse.client import Client, connect
from achse.client.nc.errors import UnknownAxis
from achse.client.nc.status import flag_names
from achse.codes.axis import StateBit
from achse.station import Station


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
def test_what_can_be_no_axis_is_reported_with_those_there_are(
    ask: Callable[..., Any], wanted: str
) -> None:
    with pytest.raises(UnknownAxis, match="1 X, 2 Y, 3 C"):
        ask(lambda client: chosen(client, ["1", wanted]))


def test_an_id_that_no_axis_has_is_reported_with_the_axes(ask: Callable[..., Any]) -> None:
    """Also where all words are ids, which are not looked up."""
    with pytest.raises(UnknownAxis, match=r"'99': no such axis.*there are: 1 X, 2 Y, 3 C"):
        ask(lambda client: chosen(client, ["1", "99"]))


def test_the_online_structure_by_field(ask: Callable[..., Any]) -> None:
    async def question(client: Client) -> dict[str, Any]:
        [axis] = await chosen(client, ["1"])
        return await axis.online()

    online = ask(question)
    assert online["actual_position"] == 0.0
    assert online["velocity_override"] == 0
    assert online["state_dword"] & StateBit.NOT_MOVING


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
