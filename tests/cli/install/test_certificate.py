"""`achse certificate`, `achse ads route add --secure` and --host secure://…"""

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from achse.cli.app import app
from achse.router.access import hash_password


@pytest.fixture(scope="module")
def station(
    tmp_path_factory: pytest.TempPathFactory, start_station: Callable[..., Any]
) -> Iterator[Any]:
    """One that listens at both ports."""
    file: Path = tmp_path_factory.mktemp("station") / "station.toml"
    file.write_text(
        f'[router]\nlisten = "both"\n[router.users]\nAdministrator = "{hash_password("1")}"\n'
    )
    with start_station(str(file)) as running:
        yield running


def run(*arguments: str, exit_code: int = 0, **environment: Any) -> Any:
    result = CliRunner().invoke(app, arguments, env={"COLUMNS": "100", **environment})
    assert result.exit_code == exit_code, (result.output, result.exception)
    return result


def test_ours_is_made_once_and_shown(tmp_path: Path) -> None:
    place = str(tmp_path / "mine")
    missing = run("certificate", "--folder", place, exit_code=1)
    assert "achse.crt is not there; `achse certificate --create` makes it" in missing.stderr
    report = json.loads(run("certificate", "--create", "--json", "--folder", place).stdout)
    assert report["key"].endswith("achse.key")
    shown = run("certificate", ACHSE_CERTIFICATES=place).stdout.split()
    assert shown == ["certificate", report["certificate"], "fingerprint", report["fingerprint"]]
    twice = run("certificate", "--create", "--folder", place, exit_code=1)
    assert "is there already" in twice.stderr


def test_first_contact_then_commands_by_secure_ads(station: Any, tmp_path: Path) -> None:
    mine: dict[str, Any] = {"ACHSE_CERTIFICATES": str(tmp_path)}
    host = station.host
    shown = json.loads(run("certificate", host, "--json", **mine).stdout)
    added = run("ads", "route", "add", "--secure", "--host", host, "--password", "1", **mine)
    first, where = added.stdout.splitlines()
    assert first == f"{station.net_id} knows our certificate now; it is reached by --host"
    assert where == f"secure://{host}:8016?fingerprint={shown['fingerprint']}"
    answer = run("ads", "state", "--port", "10000", "--host", where, **mine)
    assert answer.stdout == "RUN (5), device state 1\n"
    listed = run("ads", "route", "list", "--host", where, **mine)
    assert len(listed.stdout.splitlines()) == 1


def test_refusals_are_reported(station: Any, tmp_path: Path) -> None:
    mine: dict[str, Any] = {"ACHSE_CERTIFICATES": str(tmp_path)}
    host = station.host
    add = ("ads", "route", "add", "--secure", "--host", host)
    assert "wrong user or password" in run(*add, "--password", "2", exit_code=1, **mine).stderr
    where = f"secure://{host}?fingerprint={'ab' * 32}"
    stderr = run("ads", "state", "--host", where, exit_code=1, **mine).stderr
    assert "shows the fingerprint" in stderr
    stderr = run("ads", "state", "--host", f"secure://{host}?x=1", exit_code=2, **mine).stderr
    assert "not 'x'" in stderr
    stderr = run("certificate", "127.0.0.1:1", exit_code=1, **mine).stderr
    assert stderr.startswith("127.0.0.1:1 (Secure ADS): ")
