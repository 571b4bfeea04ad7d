"""`achse plc`: a PLC of a running station is stopped, stepped and looked at."""

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from achse.cli.app import app
from achse.iec import LREAL
from achse.testing import LiveStation

SOURCE = """\
FUNCTION_BLOCK FB_Count
VAR_INPUT
    nStep : INT;
END_VAR
VAR_OUTPUT
    nTotal : DINT;
END_VAR
nTotal := nTotal + nStep;
END_FUNCTION_BLOCK

PROGRAM MAIN
VAR
    fbCount : FB_Count;
    nCycle : INT;
END_VAR
nCycle := nCycle + 1;
fbCount(nStep := nCycle);
END_PROGRAM
"""


@pytest.fixture
def live(tmp_path: Path) -> Iterator[LiveStation]:
    (tmp_path / "main.st").write_text(SOURCE)
    with LiveStation({"plc": [{"sources": str(tmp_path / "main.st")}]}, time="virtual") as station:
        yield station


def outcome(live: LiveStation, *words: str) -> Result:
    target = ["--host", live.host, "--tcp-port", str(live.tcp_port)]
    return CliRunner().invoke(app, ["plc", *words, *target])


def printed(live: LiveStation, *words: str) -> str:
    result = outcome(live, *words)
    assert result.exit_code == 0, result.output
    return result.stdout.strip()


def test_a_session(live: LiveStation, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("achse.cli.plc.plc._PATIENCE", 0.0)
    assert printed(live, "show") == "Port_851: run"
    assert printed(live, "break", "main.st:8", "--if", "nStep = 2") == (
        "1  main.st:8  if nStep = 2  0 hits"
    )
    assert printed(live, "break", "main.st:1") == "2  main.st:8  0 hits"
    assert printed(live, "break", "--clear", "2").startswith("1  main.st:8")
    live.advance(1.0)
    assert printed(live, "show").splitlines() == [
        "Port_851: breakpoint in FB_Count (main.st:8), task PlcTask",
        "  0  FB_Count  main.st:8",
        "  1  MAIN  main.st:17",
    ]
    assert printed(live, "show", "--variables").split() == [
        "nStep",
        "INT",
        "2",
        "nTotal",
        "DINT",
        "1",
    ]
    assert printed(live, "show", "nCycle", "nCycle * 2", "--call", "1").split() == [
        *("nCycle", "INT", "2"),
        *("nCycle", "*", "2", "4"),
    ]
    assert printed(live, "set", "nStep", "-20") == "nStep = -20"
    assert printed(live, "break") == "1  main.st:8  if nStep = 2  1 hits"
    assert printed(live, "step") == "Port_851: run"
    live.advance(0.01)
    assert "step in MAIN (main.st:16)" in printed(live, "show")
    assert "step in MAIN (main.st:17)" in printed(live, "step")
    assert "step in FB_Count (main.st:8)" in printed(live, "step", "--in")
    assert json.loads(printed(live, "show", "--json"))["calls"][0]["routine"] == "FB_Count"
    assert printed(live, "step", "--out") == "Port_851: run"
    live.advance(0.01)
    assert printed(live, "continue") == "Port_851: run"
    assert printed(live, "step") == "Port_851: run"
    live.advance(0.01)
    assert "pause in MAIN" in printed(live, "show")
    assert printed(live, "continue", "--end") == "Port_851: run"
    assert printed(live, "break") == ""


DIVIDES = """\
PROGRAM MAIN
VAR
    nDivisor : INT := 1;
    nCycle : INT;
END_VAR
nCycle := nCycle + 1;
nCycle := nCycle / nDivisor;
END_PROGRAM
"""
COMPLAINT = "exception DIVIDEBYZERO in MAIN (press.st, line 7)"


def test_an_exception_is_reported_everywhere_and_others_go_on(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "press.st").write_text(DIVIDES)
    (tmp_path / "main.st").write_text(SOURCE)
    plcs = [
        {"sources": str(tmp_path / "press.st")},
        {"sources": str(tmp_path / "main.st"), "port": 852},
    ]
    with LiveStation({"plc": plcs, "axis": [{"id": 1, "name": "X"}]}, time="virtual") as live:
        target = ["--host", live.host, "--tcp-port", str(live.tcp_port)]

        def cli(*words: str) -> str:
            result = CliRunner().invoke(app, [*words, *target])
            assert result.exit_code == 0, result.output
            return result.stdout

        with live.connect() as press:
            axis = press.nc.axis("X")
            axis.enable()
            axis.move_velocity(10.0)

            def position() -> float:
                return float(press.at_port(501).read_as(0x4101, 0x0A, LREAL))

            live.advance(1.0)
            assert cli("ads", "state").startswith("RUN")
            other = press.at_port(852)
            cycles, place = other.read("MAIN.nCycle"), position()
            with press.at_port(100).subscribe_as(1, 65535, 255) as messages:
                cli("ads", "write", "MAIN.nDivisor", "0")
                live.advance(1.0)
                samples = [messages.next(10.0), messages.next(10.0)]
            assert COMPLAINT.encode() in b"".join(one.value for one in samples if one is not None)
            assert cli("ads", "state") == "EXCEPTION (19), device state 0\n"
            assert COMPLAINT in cli("plc", "show")
            assert COMPLAINT in json.loads(cli("plc", "show", "--json"))["fault"]
            assert [one.levelname for one in caplog.records if COMPLAINT in one.message] == [
                "ERROR"
            ]
            refused = CliRunner().invoke(app, ["ads", "state", "run", *target])
            assert refused.exit_code == 1
            assert "Traceback" not in refused.output

            assert cli("plc", "show", "--plc", "852") == "Port_852: run\n"
            assert other.read("MAIN.nCycle") == cycles + 100
            assert position() == pytest.approx(place + 10.0)

            assert cli("ads", "state", "reset").startswith("STOP")
            assert cli("plc", "show") == "Port_851: stop\n"
            assert cli("ads", "state", "run").startswith("RUN")
            live.advance(0.1)
            assert press.read("MAIN.nCycle") == 10


def test_in_json(live: LiveStation) -> None:
    assert json.loads(printed(live, "break", "main.st:8", "--json"))["found"]
    assert json.loads(printed(live, "break", "--json"))[0]["line"] == 8
    live.advance(0.1)
    assert json.loads(printed(live, "show", "nStep", "--json"))[0]["value"] == "1"
    assert json.loads(printed(live, "set", "nStep", "7", "--json"))["value"] == "7"
    assert json.loads(printed(live, "continue", "--json"))["state"] == "run"


def test_what_is_wrong(live: LiveStation) -> None:
    for words, says in (
        (("break", "main.st"), "FILE:LINE"),
        (("step", "--in", "--out"), "not both"),
        (("continue",), "no cycle is halted"),
        (("show", "nothing"), "nothing is named"),
        (("set", "MAIN.nCycle", "'a'"), ""),
        (("show", "--plc", "900"), "port 900 is not a PLC"),
        (("break", "--clear", "5"), ""),
        (("break", "main.st:8", "--clear", "5"), "not both"),
    ):
        result = outcome(live, *words)
        assert result.exit_code != 0 or words == ("break", "--clear", "5"), words
        assert says in result.output
        assert "Traceback" not in result.output
    missing = outcome(live, "break", "other.st:1")
    assert missing.exit_code == 1
    assert "no file of this PLC" in missing.stdout


def test_an_editor_is_served_at_a_proper_address_only() -> None:
    wrong = CliRunner().invoke(app, ["plc", "debug", "--listen", "x"])
    assert wrong.exit_code == 2
    everybody = CliRunner().invoke(app, ["plc", "debug", "--listen", "0.0.0.0:0"])
    assert everybody.exit_code == 1
    assert "--let-everybody-in" in everybody.stderr


def test_reload_without_a_plc_fails(live: LiveStation) -> None:
    """A station that restarts has none for a moment: nothing was read, which was no error."""
    assert printed(live, "reload") == "851: 1 online changes"
    with LiveStation({}, time="virtual") as empty:
        result = outcome(empty, "reload")
    assert (result.exit_code, result.stdout) == (1, "")
    assert "no PLC to reload: the station has none" in result.stderr
