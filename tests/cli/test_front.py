"""Errors of the command line itself, and the version."""

import json
from collections.abc import Callable
from typing import Any

import pytest
from typer.testing import CliRunner

from achse import __version__
from achse.cli.app import app


def _run(*words: str) -> Any:
    return CliRunner().invoke(app, words)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("ads", "state", "--colour", "--json"), "No such option: --colour"),
        (("adds", "--json"), "No such command 'adds'. Did you mean 'ads'?"),
        (("axis", "mvoe", "--json"), "Did you mean 'move'"),
        (("axis", "list", "--json"), "No such command 'list'. Did you mean 'show'?"),
        (("bus", "show", "--json"), "No such command 'show'. Did you mean 'state'?"),
        (("bus", "get", "--json"), "No such command 'get'. Did you mean 'sdo'?"),
        (("drive", "get", "--json"), "No such command 'get'. Did you mean 'bus sdo --served'?"),
        (("new", "project", "x", "--json"), "argument(s) (x). Did you mean 'new NAME'?"),
        (("start", "--json"), "No such command 'start'. Did you mean 'run'?"),
        (("ads", "read", "--json"), "Missing argument"),
        (("ads", "state", "--net-id", "1.2", "--json"), "six numbers"),
        (("run", "--net-id", "1.2", "--json"), "six numbers"),
        (("run", "--speed", "fast", "--json"), "a number above 0"),
        (("ads", "route", "add", "--net-id", "x", "--password", "y", "--json"), "six numbers"),
        (("ads", "raw", "x", "0", "--json"), "0x4040"),
        (("axis", "move", "X", "--to", "far", "--json"), "'--to': expected a number, got 'far'"),
        (("web", "--port", "x", "--json"), "'--port': expected a whole number, got 'x'"),
        (("run", "--tcp-port", "65536", "--json"), "expected at most 65535, got '65536'"),
        (("run", "--tcp-port", "-1", "--json"), "expected at least 0, got '-1'"),
    ],
)
def test_an_error_of_the_command_line_is_an_object(words: tuple[str, ...], message: str) -> None:
    result = _run(*words)
    assert (result.exit_code, result.stdout) == (2, "")
    error = json.loads(result.stderr)
    assert (error["code"], error["name"]) == (None, "USAGE")
    assert message in error["message"]


def test_a_value_without_its_option_reports_the_options() -> None:
    for words, option in [
        (("axis", "move", "X", "100"), "--to"),
        (("ads", "write", "GVL.nInt", "1", "2"), "--port"),
    ]:
        error = json.loads(_run(*words, "--json").stderr)
        assert "unexpected extra argument" in error["message"]
        assert option in error["message"].partition("options say what a value is: ")[2]


def test_without_json_it_is_a_text_for_people() -> None:
    result = _run("adds")
    assert result.exit_code == 2
    assert "Did you mean 'ads'" in result.stderr


def test_a_refusal_is_an_object_of_code_name_and_message(cli: Callable[..., Any]) -> None:
    report = json.loads(cli("ads", "read", "GVL.nothing", "--json", exit_code=1).stderr)
    assert (report["code"], report["name"]) == (0x710, "SYMBOL_NOT_FOUND")
    assert "GVL.nothing" in report["message"]


def test_the_version_is_reported() -> None:
    assert _run("--version").stdout == f"achse {__version__}\n"


@pytest.mark.parametrize(
    ("word", "ours"), [("init", "new"), ("start", "run"), ("move", "axis move")]
)
def test_a_command_of_other_tools_leads_to_ours(word: str, ours: str) -> None:
    run = CliRunner().invoke(app, [word, "--json"])
    assert f"No such command '{word}'. Did you mean '{ours}'?" in run.stderr
