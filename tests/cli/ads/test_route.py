"""`achse ads route` and `achse hash-password`."""

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from typer.testing import CliRunner

from achse.ams import NetId
from achse.cli.ads import route
from achse.cli.app import app
from achse.router.access import PasswordHash, hash_password
from achse.router.routes import Route
from achse.router.static_routes import static_routes


@pytest.fixture(scope="module")
def host(
    tmp_path_factory: pytest.TempPathFactory, start_station: Callable[..., Any]
) -> Iterator[str]:
    """Where a station runs that lets Administrator change its routes."""
    file: Path = tmp_path_factory.mktemp("station") / "station.toml"
    file.write_text(
        f'[router.users]\nAdministrator = "{hash_password("1")}"\n'
        '[[route]]\nname = "press"\nnet_id = "5.9.9.9.1.1"\nhost = "10.0.0.9"\none_way = true\n'
        "max_fragment = 1000\n"
    )
    with start_station(str(file)) as station:
        yield station.host


def run(*arguments: str, exit_code: int = 0, typed: str | None = None, **environment: str) -> Any:
    result = CliRunner().invoke(
        app, arguments, env={"ACHSE_PASSWORD": None, "COLUMNS": "100", **environment}, input=typed
    )
    assert result.exit_code == exit_code, (result.output, result.exception)
    return result


PRESS = "press  5.9.9.9.1.1  10.0.0.9  one way, fragments of 1000 bytes"


def test_a_route_is_added_listed_and_removed(host: str) -> None:
    assert run("ads", "route", "list", ACHSE_HOST=host).stdout.splitlines() == [PRESS]
    arguments = ("--name", "me", "--net-id", "192.0.2.7.1.1", "--address", "192.0.2.7")
    output = run(
        *("ads", "route", "add", "--host", host, *arguments, "--temporary", "--password", "1")
    ).stdout
    assert output == f"me added at {host}: 192.0.2.7.1.1 is at 192.0.2.7\n"
    listed = run("ads", "route", "list", "--host", host).stdout.splitlines()
    assert listed[1].split() == ["me", "192.0.2.7.1.1", "192.0.2.7", "temporary"]
    refusal = run("ads", "route", "remove", "me", ACHSE_HOST=host, exit_code=1)
    assert "others go with --password, or without one if [router] has" in refusal.stderr
    remove = ("ads", "route", "remove", "me", "--password", "1")
    assert run(*remove, ACHSE_HOST=host).stdout == "me removed\n"
    refusal = run(*remove, ACHSE_HOST=host, exit_code=1)
    assert refusal.stderr == "no route is named 'me', see `achse ads route list`\n"


@pytest.mark.parametrize(
    ("name", "password", "message"),
    [
        ("press", "2", "removes no route, 0x704: wrong user or password"),
        ("press", "1", "removes no route, 0x723: routes of its configuration stay as they are"),
    ],
)
def test_what_is_not_removed(host: str, name: str, password: str, message: str) -> None:
    arguments = ("ads", "route", "remove", name, "--password", password)
    assert message in run(*arguments, ACHSE_HOST=host, exit_code=1).stderr


def test_over_ads_routes_are_removed_where_that_is_permitted(
    tmp_path: Path, start_station: Callable[..., Any]
) -> None:
    file = tmp_path / "station.toml"
    file.write_text('[router]\nroutes_over_ads = true\nstatic_routes = "r.xml"\n')
    text = static_routes([Route(name="me", net_id=NetId("5.9.9.9.1.1"), host="10.0.0.9")])
    (tmp_path / "r.xml").write_text(text)
    with start_station(str(file)) as station:
        remove = ("ads", "route", "remove", "me", "--json")
        assert json.loads(run(*remove, ACHSE_HOST=station.host).stdout) == {"removed": "me"}
        refusal = run(*remove, ACHSE_HOST=station.host, exit_code=1)
        report = json.loads(refusal.stderr)["message"]
        assert report == "no route is named 'me', see `achse ads route list`"


def test_a_list_without_an_end_comes_to_one(host: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("achse.cli.ads.route._MOST", 1)
    monkeypatch.setattr("achse.cli.ads.route._END", ())
    assert run("ads", "route", "list", ACHSE_HOST=host).stdout.splitlines() == [PRESS]


def test_routes_as_json(host: str) -> None:
    [route] = json.loads(run("ads", "route", "list", "--json", ACHSE_HOST=host).stdout)
    assert route == {
        "name": "press",
        "net_id": "5.9.9.9.1.1",
        "host": "10.0.0.9",
        "flags": 0xA0,
        "timeout": 5.0,
        "max_fragment": 1000,
    }


def test_without_options_the_route_leads_to_us(host: str) -> None:
    stdout = run("ads", "route", "add", ACHSE_HOST=host, ACHSE_PASSWORD="1").stdout
    assert stdout.endswith(f"added at {host}: 127.0.0.1.1.2 is at 127.0.0.1\n")
    run("ads", "route", "remove", stdout.split(" added")[0], ACHSE_HOST=host, ACHSE_PASSWORD="1")


def test_the_password_comes_from_a_pipe_too(host: str) -> None:
    result = run("ads", "route", "add", "--host", host, typed="falsch\n", exit_code=1)
    assert f"{host} adds no route, 0x704: wrong user or password" in result.stderr
    assert "falsch" not in result.output
    result = run("ads", "route", "add", "--host", host, typed="", exit_code=1)
    assert result.stderr == "an empty password is none\n"


def test_the_password_is_requested_at_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    prompts: list[tuple[str, dict[str, Any]]] = []

    def prompt(text: str, **options: Any) -> str:
        prompts.append((text, options))
        return "geheim"

    monkeypatch.setattr("typer.prompt", prompt)
    monkeypatch.setattr("sys.stdin", SimpleNamespace(isatty=lambda: True))
    assert route._password("Password of me") == "geheim"
    assert prompts == [("Password of me", {"hide_input": True, "confirmation_prompt": False})]


@pytest.mark.parametrize(
    ("arguments", "exit_code", "message"),
    [
        (("--net-id", "1.2.3"), 2, "a NetId is six numbers"),
        (("--udp-port", "1", "--timeout", "0.05"), 1, "answers nothing at UDP port 1"),
        (("--host", "no.such.host.invalid"), 1, "no.such.host.invalid: "),
    ],
)
def test_what_cannot_be(arguments: tuple[str, ...], exit_code: int, message: str) -> None:
    refusal = run("ads", "route", "add", *arguments, "--password", "1", exit_code=exit_code,
                  ACHSE_HOST="127.0.0.1")  # fmt: skip
    assert message in refusal.stderr


def test_a_password_is_hashed_from_a_pipe() -> None:
    stdout = run("hash-password", typed="geheim\n").stdout.strip()
    assert PasswordHash.parse(stdout).matches("geheim")
    assert "empty" in run("hash-password", typed="\n", exit_code=1).stderr
