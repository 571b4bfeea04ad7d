"""`achse channel`: a part program of the demo station from the command line."""

from collections.abc import Callable
from typing import Any, cast

from achse.ams import DeviceError
from achse.cli.programs.channel import _place, channel
from achse.client import Client

Lines = Callable[..., list[str]]
Cli = Callable[..., Any]


def test_channels_are_listed(lines: Lines, document: Callable[..., Any]) -> None:
    assert channel.info.help
    assert [line.split()[:4] for line in lines("channel", "show")] == [
        ["channel", "name", "type", "group"],
        ["1", "Interpolation", "interpreter", "11"],
        ["2", "Axes", "standard", "1"],
    ]
    assert document("channel", "show")[0]["group"] == 11


def until(document: Callable[..., Any], name: str, value: object) -> None:
    """Ask until the state of the channel says so."""
    for _ in range(3000):
        if document("channel", "show", "1")[name] == value:
            return
    raise AssertionError(f"{name} never was {value!r}")


def test_a_program_runs_stops_and_is_reset(
    lines: Lines, cli: Cli, document: Callable[..., Any]
) -> None:
    for axis in ("X", "Y"):
        lines("axis", "enable", axis)
    [line] = lines("channel", "assign", "X", "Y")
    assert line.endswith("= 1 2 - - - - - -")
    assert lines("channel", "start", "plate.nc", "--load-only") == ["channel 1: ready, plate.nc"]
    assert "plate.nc" in lines("channel", "start")[0]
    refused = cli("channel", "start", "plate.nc", exit_code=1)
    assert "0x4109" in refused.stderr
    lines("channel", "stop")
    lines("channel", "reset")
    until(document, "state", "idle")
    assert lines("channel", "assign")[0].endswith("= - - - - - - - -")


def test_an_m_function_is_confirmed(lines: Lines, document: Callable[..., Any]) -> None:
    for axis in ("X", "Y"):
        lines("axis", "enable", axis)
    lines("channel", "assign", "X", "Y")
    lines("channel", "start", "plate.nc")
    until(document, "m_function", 40)
    assert "M40 waits: achse channel confirm" in lines("channel", "show", "1")[0]
    assert "M40" not in lines("channel", "confirm")[0]
    lines("channel", "reset")
    until(document, "state", "idle")
    lines("channel", "assign")


def test_what_cannot_be(cli: Cli) -> None:
    assert "0x4110" in cli("channel", "start", "none.nc", exit_code=1).stderr
    assert "--load-only" in cli("channel", "start", "--load-only", exit_code=2).stderr
    assert "0x4010" in cli("channel", "show", "9", exit_code=1).stderr
    assert "NoAxis" in cli("channel", "assign", "NoAxis", exit_code=1).stderr
    assert "8 at most" in cli("channel", "assign", *"XXXXXXXXX", exit_code=1).stderr


def test_offsets_and_tools(lines: Lines, document: Callable[..., Any]) -> None:
    assert lines("channel", "show", "--offsets")[0].split() == ["shift", "X", "Y", "Z"]
    assert document("channel", "show", "--offsets")["offsets"]["G54_FINE"] == [0.0, 0.0, 0.0]
    lines("ads", "raw", "0x2001", "0x40302", "0000000000804b40", "--port", "501")
    assert lines("channel", "show", "1", "--tools")[-1].split()[:4] == [
        "D3",
        "0.0000",
        "0.0000",
        "55.0000",
    ]
    assert document("channel", "show", "1", "--tools")["tools"][0]["length"] == 55.0


async def test_a_controller_without_places_has_none() -> None:
    class Other:
        async def read_raw(self, *_: int) -> bytes:
            raise DeviceError(0x703)

    assert await _place(cast("Client", Other()), 1) is None
