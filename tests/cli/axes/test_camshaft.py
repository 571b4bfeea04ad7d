"""`achse camshaft`: the demo's controller, listed, shown and watched."""

import json
from collections.abc import Callable
from typing import Any

from achse.cli.axes.camshaft import camshaft

Lines = Callable[..., list[str]]
Cli = Callable[..., Any]


def test_the_controllers_are_listed(lines: Lines, cli: Cli) -> None:
    assert lines("camshaft", "show") == [
        "name   degrees  1/min  cams  tracks on  errors",
        "Press      0.0      0     0  -          none",
    ]
    [listed] = json.loads(cli("camshaft", "show", "--json").stdout)
    assert (listed["name"], listed["configured_cams"], listed["errors"]) == ("Press", 0, [])


def test_values_and_cams_are_shown(lines: Lines, cli: Cli) -> None:
    zeros = "00000000"
    cam = "0101010001000001" + "5a000000" + "b4000000" + "04000000" + zeros
    cam += "01000000" + "14000000" + "01000000" + zeros + "02000000"
    lines("ads", "raw", "0x1103", "0", cam, "--port", "900")
    shown = lines("camshaft", "show", "press")
    assert any(line.split() == ["and_mask", "4294967295"] for line in shown)
    assert shown[-1] == ("cam 3: way on track 4, 90..180 degrees, forward backward force")
    document = json.loads(cli("camshaft", "show", "press", "--json").stdout)
    assert document["cam"][0]["hysteresis"] == 20
    assert document["parameters"]["box_address"] == 1


def test_another_name_is_reported(cli: Cli) -> None:
    result = cli("camshaft", "show", "Pres", exit_code=1)
    assert "no camshaft 'Pres', there are Press; did you mean 'Press'?" in result.stderr


def test_changes_are_watched(lines: Lines, cli: Cli) -> None:
    assert camshaft.info.help
    [line] = lines("camshaft", "show", "--watch", "--count", "1")
    assert line.split()[1:] == ["Press", "-"]
    report = json.loads(cli("camshaft", "show", "--watch", "--count", "1", "--json").stdout)
    assert report["cams"] == 0
