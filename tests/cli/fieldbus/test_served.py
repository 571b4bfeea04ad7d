"""`achse bus state|sdo --served` and `achse fault --served`: beside the master of served drives."""

import json
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from achse.cli.app import app
from tests.warm_commands import WarmCommands

SERVE = [
    *("drive", "serve", "--code", "plain", "--ordinary"),
    *("--udp", "127.0.0.1:0", "--control", "127.0.0.1:0", "--type", "ac,linear"),
]
FAULTS = """
[[fault]]
kind = "warning"
code = "AL.910"
drive = 2
"""

Achse = Callable[..., Result]


@pytest.fixture(scope="module")
def port(tmp_path_factory: pytest.TempPathFactory, warm_commands: WarmCommands) -> Iterator[str]:
    """Where the drives listen."""
    script: Path = tmp_path_factory.mktemp("drives") / "faults.toml"
    script.write_text(FAULTS)
    with warm_commands.popen(*SERVE, "--faults", str(script), stdout=subprocess.PIPE) as run:
        assert run.stdout is not None
        stdout = dict(word.split("=") for word in run.stdout.readline().split()[3:])
        yield stdout["control"].rpartition(":")[2]
        run.terminate()
        assert run.wait() == 0


@pytest.fixture
def achse(port: str) -> Achse:
    def call(*arguments: str, exit_code: int = 0) -> Result:
        environment = {"ACHSE_CONTROL_PORT": port, "COLUMNS": "100"}
        result = CliRunner().invoke(app, arguments, env=environment)
        assert result.exit_code == exit_code, (result.output, result.exception)
        return result

    return call


def test_an_object_is_read_and_written(achse: Achse) -> None:
    assert achse("bus", "sdo", "2", "6085", "123456", "--served").stdout == "6085:00 = 123456\n"
    assert achse("bus", "sdo", "2", "6085:0", "--served").stdout == "6085:00 = 123456\n"
    report = json.loads(achse("bus", "sdo", "2", "6085", "--served", "--json").stdout)
    assert report == {"index": "0x6085", "subindex": 0, "value": 123456}
    assert (
        json.loads(achse("bus", "sdo", "1", "6085", "--json", "--served").stdout)["value"] != 123456
    )


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("bus", "sdo", "1", "5000", "--served"), 1, "0x06020000"),
        (("bus", "sdo", "3", "6041", "--served"), 1, "there are 2 slaves, got 3"),
        (("bus", "sdo", "1", "6041", "1", "--served"), 1, "0x06010002"),
        (("bus", "sdo", "1", "6085", "-1", "--served"), 1, "0x06090030"),
        (("bus", "sdo", "1", "6085", "fast", "--served"), 2, "a number expected"),
        (("fault", "add", "--served", "melt"), 2, "kind: expected one of"),
        (("fault", "add", "--served", "sto", "drive=9"), 1, "there are 2, got 9"),
    ],
)
def test_what_cannot_be_is_refused(
    achse: Achse, arguments: tuple[str, ...], code: int, message: str
) -> None:
    refusal = achse(*arguments, exit_code=code)
    assert message in " ".join(refusal.stderr.replace("│", " ").split())


def test_a_fault_begins_is_watched_and_ends(achse: Achse) -> None:
    [added] = achse(
        "fault", "add", "--served", "alarm", "code=AL.720", "drive=1"
    ).stdout.splitlines()
    number = added.split()[0]
    assert added == f"{number}  alarm drive=1 code=AL.720"
    listed = achse("fault", "list", "--served").stdout.splitlines()
    assert listed[-1] == f"{number}  active  1 hits  alarm drive=1 code=AL.720"
    drives = json.loads(achse("bus", "state", "--served", "--json").stdout)
    assert [each["slave"] for each in drives] == [1, 2]
    assert (drives[0]["power"], drives[0]["alarm"]) == ("FAULT", "AL.720")
    heading, first, second = achse("bus", "state", "--served").stdout.splitlines()
    assert heading.split()[:4] == ["slave", "bus", "power", "mode"]
    assert first.split()[:3] == ["1", "INIT", "fault"]
    assert second.split()[:3] == ["2", "INIT", "switch"]
    achse("fault", "clear", number, "--served")
    listed = json.loads(achse("fault", "list", "--served", "--json").stdout)
    assert [each["fault"]["kind"] for each in listed] == ["warning"]  # the script's


def test_what_is_stored_outlives_the_program(tmp_path: Path, warm_commands: WarmCommands) -> None:
    file = tmp_path / "kept.json"
    for expected in ("", "4711"):
        with warm_commands.popen(*SERVE, "--store", str(file), stdout=subprocess.PIPE) as run:
            assert run.stdout is not None
            stdout = dict(word.split("=") for word in run.stdout.readline().split()[3:])

            def achse(*arguments: str, port: str = stdout["control"].rpartition(":")[2]) -> str:
                result = CliRunner().invoke(app, [*arguments], env={"ACHSE_CONTROL_PORT": port})
                assert result.exit_code == 0, result.output
                return result.stdout.rpartition(" = ")[2].strip()

            if expected:
                assert achse("bus", "sdo", "2", "6085", "--served") == expected
            else:
                achse("bus", "sdo", "2", "6085", "4711", "--served")
                assert achse("bus", "sdo", "2", "1010:01", "0x65766173", "--served") == "0"
                while achse("bus", "sdo", "2", "1010:01", "--served") == "0":
                    pass
            run.terminate()
    assert json.loads(file.read_text())["2"]["6085:00"] == 4711


def test_kinds_are_listed(achse: Achse) -> None:
    listed = achse("fault", "list", "--kinds", "--served").stdout
    for kind in ("alarm: ", "lost_frames: ", "clock_drift: "):
        assert kind in listed


def test_a_name_that_is_none_is_reported_before_any_request() -> None:
    result = CliRunner().invoke(
        app, ["bus", "sdo", "1", "no such thing", "--served", "--tcp-port", "1"]
    )
    assert result.exit_code == 2
    assert "INDEX or INDEX:SUB" in result.output
