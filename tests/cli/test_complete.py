"""Completion: what shells are offered, and that nobody waits or hears of failures."""

import os
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from typer.main import get_command

from achse.cli import complete
from achse.cli.app import app
from tests.warm_commands import WarmCommands


@pytest.fixture
def ctx(environment: dict[str, str]) -> Any:
    """The command line so far: where the target is."""
    params = {"host": environment["ACHSE_HOST"], "tcp_port": int(environment["ACHSE_TCP_PORT"])}
    return SimpleNamespace(params=params)


def test_axes(ctx: Any) -> None:
    assert complete.axes(ctx, "") == ["X", "Y", "C"]
    assert complete.axes(ctx, "x") == ["X"]
    assert complete.axes(ctx, "nope") == []


def test_symbols_come_part_by_part(ctx: Any) -> None:
    assert complete.symbols(ctx, "ma") == ["MAIN."]
    assert complete.symbols(ctx, "MAIN.") == ["MAIN.nCounter"]
    assert "GVL.nInt" in complete.symbols(ctx, "gvl.n")


def test_the_environment_says_where_the_target_is(
    ctx: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ACHSE_HOST", ctx.params["host"])
    monkeypatch.setenv("ACHSE_TCP_PORT", str(ctx.params["tcp_port"]))
    assert complete.axes(None, "X") == ["X"]


def test_who_does_not_answer_offers_nothing_and_costs_little(
    capfd: pytest.CaptureFixture[str],
) -> None:
    nobody = SimpleNamespace(params={"host": "127.0.0.1", "tcp_port": 1})
    assert complete.axes(nobody, "") == complete.symbols(nobody, "M") == []
    assert capfd.readouterr() == ("", "")
    assert complete.axes(SimpleNamespace(params={"net_id": "no"}), "") == []


def test_kinds_of_faults_and_their_fields() -> None:
    assert "drop" in complete.fault_kinds(None, "")
    assert complete.fault_kinds(None, "sl") == ["slow_cycle"]
    drives = {"served": True}
    assert complete.fault_kinds(SimpleNamespace(params=drives), "al") == ["alarm"]
    assert complete.fault_kinds(SimpleNamespace(params={"bus": 1}), "al") == ["alarm"]
    slow = SimpleNamespace(params={"kind": "slow_cycle"})
    assert complete.fault_fields(slow, "f") == ["factor="]
    assert "at=" in complete.fault_fields(slow, "")
    alarm = SimpleNamespace(params=drives | {"kind": "alarm"})
    assert "drive=" in complete.fault_fields(alarm, "")
    assert complete.fault_fields(SimpleNamespace(params={}), "") == []


def test_the_commands_use_it(ctx: Any, environment: dict[str, str]) -> None:
    """As a shell asks: the parameters of `achse axis move` and `achse fault add` complete."""
    commands: Callable[..., Any] = get_command(app)
    move = commands.commands["axis"].commands["move"]  # type: ignore[attr-defined]
    name = next(item for item in move.params if item.name == "name")
    assert [item.value for item in name.shell_complete(ctx, "X")] == ["X"]
    add = commands.commands["fault"].commands["add"]  # type: ignore[attr-defined]
    kind = next(item for item in add.params if item.name == "kind")
    assert "restart" in [item.value for item in kind.shell_complete(ctx, "re")]


@pytest.mark.parametrize(
    ("shell", "words", "offered"),
    [
        ("bash", "achse axis move ", ["X", "Y", "C"]),
        ("bash", "achse fault add dr", ["drop", "drop_link"]),
        ("bash", "achse ads route ", ["list", "remove", "add"]),
        ("fish", "achse ads read MA", ["MAIN."]),
    ],
)
def test_shells_get_it(
    warm_commands: WarmCommands,
    environment: dict[str, str],
    shell: str,
    words: str,
    offered: list[str],
) -> None:
    """As the script of `achse --install-completion` asks."""
    request = {
        "_ACHSE_COMPLETE": f"complete_{shell}",
        "COMP_WORDS": words,
        "COMP_CWORD": str(len(words.split(" ")) - 1),
        "_TYPER_COMPLETE_ARGS": words,
        "_TYPER_COMPLETE_FISH_ACTION": "get-args",
    }
    result = warm_commands.run(env=os.environ | environment | request)
    assert (result.stdout.split(), result.stderr) == (offered, "")
