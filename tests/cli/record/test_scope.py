"""`achse scope`: recordings of a running station, files, and what is told when it cannot be."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.cli.record.scope import scope
from achse.client import blocking
from achse.scope import ScopeData
from tests.scope.conftest import recording

Lines = Callable[..., list[str]]
Cli = Callable[..., Any]


def test_channels_are_recorded_as_they_come(lines: Lines, tmp_path: Path) -> None:
    file = tmp_path / "a.scope"
    words = ("MAIN.nCounter", "500:Axes.X.ActPos")
    begun, done = lines("scope", "record", str(file), *words, "--for", "1")
    assert begun.startswith("achse recording scope=")
    assert done == f"{file}: 2 channels, 600 samples"
    data = ScopeData.load(file)
    counts = data["MAIN.nCounter"].values
    assert counts == list(range(counts[0], counts[0] + 100))
    assert lines("scope", "show") == ["1  offline  0 channels  scope"]


def test_a_trigger_is_waited_for(cli: Cli, tmp_path: Path) -> None:
    file = tmp_path / "a.csv"
    result = cli(
        *("scope", "record", str(file), "MAIN.nCounter", "--for", "0.2", "--json"),
        *("--trigger", "MAIN.nCounter above 0", "--pretrigger", "0"),
    )
    events = [json.loads(line) for line in result.stdout.splitlines()]
    assert events[1] == {
        "event": "done", "file": str(file), "channels": 1, "samples": 20, "lost": 0,
    }  # fmt: skip
    assert file.read_text(encoding="utf-8").startswith("Name\ta\n")


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (("record", "a.txt", "MAIN.nCounter"), 2, "expected the ending .csv, .scope, .parquet"),
        (("record", "none/a.csv", "MAIN.nCounter"), 1, "none: no such folder"),
        (("record", "a.csv", "MAIN.nCounte"), 1, "did you mean 'MAIN.nCounter'?"),
        (
            ("record", "a.csv", "MAIN.nCounter", "--trigger", "x up"),
            1,
            "with one of rising, falling",
        ),
        (("record", "a.csv", "9:x"), 1, "no device at port 9"),
        (("record", "a.csv", "500:0x4101:0x50"), 1, "a scope cannot have this value"),
        (("start", "77"), 1, "no scope has the number 77"),
        (("trigger", "1"), 1, "scope 1 does not wait for a trigger: start it"),
        (("trigger", "0"), 2, "at least 1"),
        (("show", "77"), 1, "no scope has the number 77, see `achse scope show`"),
        (("show", "1", "--to", "a.csv"), 1, "scope 1 has recorded nothing"),
        (("show", "none.scope"), 1, "none.scope: No such file"),
        (("show", "notes.scope"), 1, "not a recording in binary form"),
    ],
)
def test_what_cannot_be_is_reported(
    cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    words: tuple[str, ...], code: int, message: str,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    (tmp_path / "notes.scope").write_text("milk, bread")
    result = cli("scope", *words, exit_code=code)
    assert message in " ".join(result.stderr.replace("│", " ").split())
    assert "Traceback" not in result.stderr
    if code == 1:
        error = json.loads(cli("scope", *words, "--json", exit_code=1).stderr)
        assert error["name"] in (
            *("SCOPE", "CANNOT_WRITE", "CANNOT_READ", "NOT_FOUND", "EMPTY", "INVALID_STATE"),
        )


def test_a_scope_that_records_is_shown_and_exported(
    live: Any, lines: Lines, document: Callable[..., Any], tmp_path: Path
) -> None:
    with live.station.scope(["MAIN.nCounter"], length=0.5, name="mine") as scope:
        while len(scope.data()["MAIN.nCounter"]) < 50:
            pass
        assert "MAIN.nCounter" in lines("scope", "show", str(scope.number))[0]
        [row] = document("scope", "show", str(scope.number))["channels"]
        assert (row["samples"], row["type"]) == (50, "UINT32")
        file = tmp_path / "a.parquet"
        [line] = lines("scope", "show", str(scope.number), "--to", str(file))
        assert line == f"{file}: 1 channels, 50 samples"
        assert [each["name"] for each in document("scope", "show")] == ["scope", "mine"]


def test_a_scope_of_the_station_is_started_triggered_and_stopped(
    live: Any, lines: Lines, cli: Cli, document: Callable[..., Any]
) -> None:
    with live.station.scope(["MAIN.nCounter"], length=0.2, name="view") as scope:
        number = str(scope.number)
        assert lines("scope", "stop", number) == [f"scope {number}: offline"]
        assert lines("scope", "start", number) == [f"scope {number}: recording"]
        state = document("scope", "trigger", number)
        assert state == {"scope": scope.number, "state": "triggered"}
        assert "does not wait for a trigger" in cli("scope", "trigger", number, exit_code=1).stderr
    assert lines("scope", "start") == ["scope 1: recording"]
    assert lines("scope", "stop") == ["scope 1: offline"]


def test_a_scope_of_another_client_is_left_alone(live: Any, cli: Cli) -> None:
    with (
        blocking.connect(f"127.0.0.1:{live.tcp_port}") as client,
        client.scope("MAIN.nCounter") as theirs,
    ):
        stderr = cli("scope", "stop", str(theirs.number), exit_code=1).stderr
        assert f"scope {theirs.number} is another client's" in stderr
        assert theirs.facts()["state"] == "recording"


def test_a_file_is_shown_and_written_in_another_form(
    lines: Lines, document: Callable[..., Any], tmp_path: Path
) -> None:
    file = tmp_path / "a.scope"
    recording().save(file)
    assert "level" in lines("scope", "show", str(file))[-1]
    facts = document("scope", "show", str(file))
    assert facts["trigger"] == 0.004
    assert facts["channels"][-1]["last"] == -0.5
    to = tmp_path / "a.csv"
    [line] = lines("scope", "show", str(file), "--to", str(to))
    assert line == f"{to}: 12 channels, 67 samples"
    assert to.exists()
    assert scope.registered_commands
