"""`achse ads`: what a user asks, and what is printed."""

import json
from collections.abc import Callable
from typing import Any

import pytest

Lines = Callable[..., list[str]]
Document = Callable[..., Any]
Cli = Callable[..., Any]


def test_info(lines: Lines, document: Document) -> None:
    facts = dict(
        line.split(maxsplit=1) for line in lines("ads", "state", "--identity", "--port", "500")
    )
    assert facts["name"] == "TwinCAT NC"
    assert facts["address"] == "127.0.0.1.1.1:500"
    assert facts["state"].startswith("RUN (5)")
    report = document("ads", "state", "--identity", "--port", "500")
    assert (report["name"], report["version"]) == (facts["name"], facts["version"])


def test_a_plc_is_stopped_and_started(lines: Lines, document: Document) -> None:
    assert lines("ads", "state", "stop")[0].startswith("STOP (6)")
    assert document("ads", "state")["state"] == "STOP"
    assert lines("ads", "state", "run")[0].startswith("RUN (5)")


def test_an_unknown_state_is_bad_usage(cli: Cli) -> None:
    assert "reconfig" in cli("ads", "state", "sleep", exit_code=2).stderr


def test_variables_are_read_in_the_order_given(lines: Lines) -> None:
    assert lines("ads", "read", "GVL.aInt", "GVL.eColour", "gvl.stpoint.fX") == [
        "GVL.aInt = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]",
        "GVL.eColour = GREEN",
        "gvl.stpoint.fX = 1.0",
    ]


def test_what_can_be_read_is_shown_beside_what_cannot(cli: Cli) -> None:
    result = cli("ads", "read", "GVL.nNone", "GVL.nUint", exit_code=1)
    assert result.stdout == "GVL.nUint = 16\n"
    assert "GVL.nNone" in result.stderr
    assert "0x710 SYMBOL_NOT_FOUND" in result.stderr


def test_values_as_json(document: Document) -> None:
    assert document("ads", "read", "GVL.stPoint", "GVL.tTime", "GVL.aLreal") == {
        "GVL.stPoint": {"fX": 1.0, "fY": 2.0, "sName": "home", "bValid": True},
        "GVL.tTime": "T#1s500ms",
        "GVL.aLreal": [[1.1, 1.2, 1.3], [2.1, 2.2, 2.3]],
    }


@pytest.mark.parametrize(
    ("name", "literal", "shown"),
    [
        ("GVL.nInt", "-17", "-17"),
        ("GVL.nWord", "16#CAFE", "51966"),
        ("GVL.fLreal", "-1e-3", "-0.001"),
        ("GVL.sString", "hello", "'hello'"),
        ("GVL.tTime", "T#2m", "T#2m"),
        ("GVL.eColour", "BLUE", "BLUE"),
        ("GVL.aPoints[2]", "(fX := 3, sName := 'x')", None),
    ],
)
def test_a_written_literal_is_read_back(
    lines: Lines, name: str, literal: str, shown: str | None
) -> None:
    written = lines("ads", "write", name, literal)
    assert shown is None or written == [f"{name} = {shown}"]
    assert lines("ads", "read", name) == written


def test_a_value_of_another_type_is_bad_usage(cli: Cli) -> None:
    assert "-32768..32767, got 70000" in cli(
        "ads", "write", "GVL.nInt", "70000", exit_code=2
    ).stderr.replace("\n", " ")


def test_watch_prints_each_change(cli: Cli) -> None:
    result = cli(
        "ads", "read", "--watch", "MAIN.nCounter", "--cycle-time", "0.02", "-n", "4", "--json"
    )
    samples = [json.loads(line) for line in result.stdout.splitlines()]
    assert len(samples) == 4
    counts = [sample["value"] for sample in samples]
    assert counts == sorted(set(counts))


def test_watch_prints_a_line_per_sample(lines: Lines) -> None:
    watched = lines("ads", "read", "--watch", "GVL.nUsint", "--cyclic", "-c", "0.01", "-n", "3")
    assert [line.partition("  ")[2] for line in watched] == ["GVL.nUsint = 8"] * 3


def test_watch_shows_values_of_several_ports(lines: Lines) -> None:
    names = "GVL.nUsint", "500:Axes.X.ActPos"
    watched = lines("ads", "read", "--watch", *names, "--cyclic", "-c", "0.2", "-n", "60")
    shown = [line.partition("  ")[2].partition(" = ")[0] for line in watched]
    assert len(shown) == 60
    assert set(shown) == set(names)


def test_watch_ends_in_time(lines: Lines) -> None:
    assert len(lines("ads", "read", "--watch", "GVL.nUsint", "--for", "0.05")) <= 1


def test_symbols_by_pattern_and_type(lines: Lines, document: Document) -> None:
    names = [line.split()[0] for line in lines("symbols", "gvl", "--type", "ARRAY*OF INT")]
    assert names == ["GVL.aInt"]
    [counter] = document("symbols", "*.ncounter")
    assert counter["name"] == "MAIN.nCounter"
    assert (counter["type"], counter["size"]) == ("UDINT", 4)
    assert lines("symbols", "nothing*") == []


@pytest.mark.parametrize(
    "words", [("read", "GVL.nIntt"), ("write", "GVL.nIntt", "5"), ("read", "--watch", "GVL.nIntt")]
)
def test_near_symbols_are_offered(cli: Callable[..., Any], words: tuple[str, ...]) -> None:
    stderr = cli("ads", *words, exit_code=1).stderr
    assert "0x710" in stderr
    assert "not found; did you mean 'GVL.nInt'" in stderr


def test_a_list_is_no_symbol_but_holds_some(cli: Callable[..., Any]) -> None:
    stderr = cli("ads", "read", "GVL", exit_code=1).stderr
    assert "not found; GVL holds " in stderr
    assert "symbols: GVL.aInt, " in stderr
    stderr = cli("ads", "read", "GVL.aInt[10]", "GVL.stPoint.fZ", exit_code=1).stderr
    assert "not valid; index 10 is outside 0..9" in stderr
    assert "ST_Point has no member 'fZ'; it has fX, fY, " in stderr


def test_of_a_symbol_that_is_there_none_is_offered(cli: Callable[..., Any]) -> None:
    cli("fault", "add", "error", "code=0x710", "symbol=GVL.nInt")
    assert "did you mean" not in cli("ads", "read", "GVL.nInt", exit_code=1).stderr
    cli("fault", "clear")


@pytest.mark.parametrize(
    ("joined", "words"), [("A,B", "A B"), ("M.a[1,2],M.b,", "M.a[1,2] M.b"), (" A , B", "A B")]
)
def test_names_in_one_word_are_distinguished(
    cli: Callable[..., Any], joined: str, words: str
) -> None:
    stderr = cli("ads", "read", joined, exit_code=2).stderr
    assert f"names are separate words: {words};" in " ".join(stderr.replace("│", " ").split())
    assert "SYMBOL" in cli("ads", "read", "MAIN.a[1,2]", exit_code=1).stderr


def test_a_name_may_begin_with_a_port(lines: Lines, cli: Cli) -> None:
    names = ("GVL.nUint", "500:Axes.X.ActPos", "851:GVL.nUint")
    assert [line.partition(" = ")[0] for line in lines("ads", "read", *names)] == list(names)
    assert lines("ads", "write", "851:GVL.nUint", "25") == ["851:GVL.nUint = 25"]
    assert lines("ads", "read", "GVL.nUint") == ["GVL.nUint = 25"]
    assert "0x710" in cli("ads", "read", "70000:GVL.nUint", exit_code=1).stderr
