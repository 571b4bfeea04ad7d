"""`achse fault`: on a running station, from outside."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest

Lines = Callable[..., list[str]]
Cli = Callable[..., Any]


@pytest.fixture(autouse=True)
def clean(cli: Cli) -> Iterator[None]:
    yield
    cli("fault", "clear")


def test_a_fault_is_added_listed_hits_and_is_cleared(lines: Lines, cli: Cli) -> None:
    [added] = lines("fault", "add", "error", "symbol=GVL.nInt", "code=0x706")
    number = added.split()[0]
    assert added == f"{number}  error symbol=GVL.nInt code=0x706 (INVALID_DATA)"
    refusal = cli("ads", "read", "GVL.nInt", exit_code=1)
    assert "0x706 INVALID_DATA" in refusal.stderr
    [listed] = lines("fault", "list")
    assert listed.split()[:3] == [number, "active", "1"]
    assert lines("fault", "clear", number) == []
    assert lines("ads", "read", "GVL.nInt") == ["GVL.nInt = -16"]
    assert lines("fault", "list") == []


def test_breaking_all_links_is_reported_as_done(lines: Lines) -> None:
    [line] = lines("fault", "add", "drop_link")
    assert line.split()[1:] == ["drop_link"]


def test_json(document: Callable[..., Any]) -> None:
    added = document("fault", "add", "drop", "at=1e6", "port=851")
    assert document("fault", "list") == [
        {
            "number": added["number"],
            "state": "waiting",
            "hits": 0,
            "fault": {"kind": "drop", "at": 1e6, "port": 851},
        }
    ]


@pytest.mark.parametrize(
    ("arguments", "exit_code", "message"),
    [
        (("add", "melt"), 2, "kind: expected one of"),
        (("add", "drop", "colour=1"), 2, "expected KEY=VALUE"),
        (("add", "error", "code=1", "symbol=X.y"), 1, "symbol: no device of the station has"),
        (("add", "error", "symbol=GVL.nInt"), 2, "code: a fault of kind error needs it"),
        (("clear", "4711"), 1, "no fault has the number 4711, see `achse fault list`"),
    ],
)
def test_what_cannot_be_is_refused(
    cli: Cli, arguments: tuple[str, ...], exit_code: int, message: str
) -> None:
    refusal = cli("fault", *arguments, exit_code=exit_code)
    assert message in " ".join(refusal.stderr.replace("│", " ").split())


def test_kinds_are_listed(lines: Lines) -> None:
    listed = lines("fault", "list", "--kinds")
    assert "drop: Frames vanish: the answer never comes." in listed
    assert "    lasting port factor" in listed
