"""`achse plc draw`: drawn bodies as text, with values of a running station."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from achse.cli.app import app
from achse.testing import LiveStation
from tests.st.graphical.drawings import assign, contact, network, networks, part, series, unit

Lines = Callable[..., list[str]]
Cli = Callable[..., Any]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    rung = assign(series(contact("a"), contact("b")), "q")
    action = part("Action", "Act", networks(network(assign(contact("q"), "a"))))
    main = unit(
        "PROGRAM MAIN\nVAR a : BOOL := TRUE; b, q : BOOL; f : FB_X; END_VAR",
        networks(network(rung)), action,
    )  # fmt: skip
    block = unit(
        "FUNCTION_BLOCK FB_X\nVAR on : BOOL := TRUE; q : BOOL; END_VAR",
        networks(network(assign(contact("on"), "q"))),
    )
    copy = tmp_path / "plc"
    copy.mkdir()
    (copy / "MAIN.TcPOU").write_text(main)
    (copy / "FB_X.TcPOU").write_text(block)
    (copy / "F.st").write_text("PROGRAM T\nEND_PROGRAM\n")
    return copy


def test_drawing_alone(lines: Lines, folder: Path) -> None:
    assert lines("plc", "draw", str(folder), "main") == [
        "network 1",
        "    ├─┤ a ├─┤ b ├─( q )",
    ]
    assert lines("plc", "draw", str(folder), "MAIN.Act")[1].strip() == "├─┤ q ├─( a )"
    (line,) = lines("plc", "draw", str(folder), "FB_X", "--json")
    assert json.loads(line)["language"] == "NWL"


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("Other", "no unit is named Other"),
        ("T", "T has no drawn body"),
        ("MAIN.X", "no drawn body"),
    ],
)
def test_refusals(cli: Cli, folder: Path, name: str, message: str) -> None:
    result = cli("plc", "draw", str(folder), name, exit_code=1)
    assert message in result.output


def test_values_of_a_running_station(folder: Path) -> None:
    def drawn(live: LiveStation, *words: str) -> str:
        target = ["--host", live.host, "--tcp-port", str(live.tcp_port)]
        command = ["plc", "draw", str(folder), *words, "--live", *target]
        return CliRunner().invoke(app, command).output

    with LiveStation({"plc": [{"sources": str(folder)}]}, time="virtual") as live:
        live.advance(0.1)
        assert "├═┤ a ├═┤ b ├─( q ) = False" in drawn(live, "MAIN")
        assert "├═┤ on ├═( q )" in drawn(live, "FB_X", "--of", "MAIN.f")
        assert "name an instance by --of" in drawn(live, "FB_X")
