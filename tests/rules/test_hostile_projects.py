"""Hostile projects: each ends in one exception with its line, and nothing else notices.

Beside the PLC there are another one, an axis that moves, and a client; all of them go on.
"""

import logging
import random
import string
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import AdsState, DeviceError
from achse.client.blocking import Client
from achse.codes import ReturnCode
from achse.plc import PlcState
from achse.st.check import check
from achse.st.declare import examine
from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse
from achse.station import ConfigError, Station
from achse.testing import LiveStation

ROWS = Path(__file__).parents[1] / "data" / "st_rules" / "hostile.txt"
GOOD = "PROGRAM MAIN VAR n : DINT; END_VAR n := n + 1; END_PROGRAM"
VARIABLES = """n : INT; m : INT; s : SINT; d : DINT; p : POINTER TO INT; q : POINTER TO INT;
ps : POINTER TO STRING; r : LREAL; a : ARRAY [0..9] OF INT; e : __SYSTEM.ExceptionCode;
str : STRING;
big1 : ARRAY [0..999999] OF INT; big2 : ARRAY [0..999999] OF INT;"""
HERE = "(* here *)"


class Case(NamedTuple):
    """A row."""

    key: str
    units: str
    statements: str
    exception: str

    @property
    def text(self) -> str:
        variables = VARIABLES
        if "FUNCTION_BLOCK FB" in self.units:
            variables += " fb1 : FB; pf : POINTER TO FB;"
        if "INTERFACE I" in self.units:
            variables += " i1 : I;"
        # A line for each statement, so that a wrong one shows.
        text = (
            f"{self.units}\nPROGRAM MAIN\nVAR\n{variables}\nEND_VAR\n{self.statements}\nEND_PROGRAM"
        )
        return text.replace("; ", ";\n").replace(f";\n{HERE}", f"; {HERE}")

    @property
    def line(self) -> int:
        lines = self.text.splitlines()
        return next((n for n, line in enumerate(lines, 1) if HERE in line), 0)


def _cases() -> Iterator[Case]:
    for line in ROWS.read_text(encoding="utf-8").splitlines():
        if line and not line.startswith("#"):
            yield Case(*line.split("\t"))


CASES = list(_cases())


def _station(folder: Path, text: str, good: str = GOOD, more: str = "") -> Station:
    (folder / "bad.st").write_text(text)
    (folder / "good.st").write_text(good)
    (folder / "station.toml").write_text(
        f'[[plc]]\nsources = "bad.st"\nbudget = 200_000\n{more}[[plc]]\nport = 852\n'
        'sources = "good.st"\n[[axis]]\nid = 1\nname = "A"\n'
    )
    return Station.load(folder / "station.toml")


@pytest.mark.parametrize("case", CASES, ids=[case.key for case in CASES])
def test_a_hostile_program_stops_alone(
    case: Case, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    station = _station(tmp_path, case.text)
    station.advance(0.1)
    plc, other = station.plcs[851], station.plcs[852]
    assert (other.state, other.instance("MAIN")["n"]) == (PlcState.RUN, 10)
    device = next(one for one in station.devices if getattr(one, "plc", None) is plc)
    errors = [record for record in caplog.records if record.levelno >= logging.ERROR]
    if not case.exception:
        assert (plc.state, errors) == (PlcState.RUN, []), plc.failure
        return
    assert (plc.state, device.ads_state) == (PlcState.EXCEPTION, AdsState.EXCEPTION)
    assert plc.fault is not None
    assert plc.fault.name in case.exception.split(" or "), plc.fault
    assert case.line in (0, plc.fault.line), f"{plc.fault}\n{case.text}"
    assert len(errors) == 1, "told once"
    assert f"exception {plc.fault.name} in {plc.fault.routine} (bad.st, line" in errors[0].message
    plc.reset()
    plc.run() if plc.state is PlcState.STOP else None
    station.advance(0.1)
    assert other.instance("MAIN")["n"] == 20


CALLED = """
FUNCTION_BLOCK FB_Trap
VAR n : INT; END_VAR
{attribute 'TcRpcEnable'}
METHOD Divide : INT
VAR_INPUT nBy : INT; END_VAR
Divide := 10 /
    nBy;
END_METHOD
{attribute 'monitoring' := 'call'}
PROPERTY Bad : INT
GET
    WHILE TRUE DO
        n := n + 1;
    END_WHILE
END_GET
SET
    n := 10 / Bad;
END_SET
END_PROPERTY
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR fb : FB_Trap; nCycles : DINT; END_VAR
nCycles := nCycles + 1;
END_PROGRAM
"""


@pytest.mark.parametrize(
    ("what", "exception", "line"),
    [("method", "DIVIDEBYZERO", 7), ("get", "CYCLE_TIME_EXCEED", 13), ("set", "DIVIDEBYZERO", 18)],
)
def test_what_a_client_calls_stops_its_plc_alone(
    what: str, exception: str, line: int, tmp_path: Path
) -> None:
    _station(tmp_path, CALLED)
    calls: dict[str, Callable[[Client], object]] = {
        "method": lambda plc: plc.call("MAIN.fb", "Divide", nBy=0),
        "get": lambda plc: plc.read("MAIN.fb.Bad"),
        "set": lambda plc: plc.write("MAIN.fb.Bad", 0),
    }
    with LiveStation(tmp_path / "station.toml") as live, live.connect() as plc:
        assert plc.call("MAIN.fb", "Divide", nBy=5) == 2
        for code in (ReturnCode.DEVICE_ERROR, ReturnCode.INVALID_STATE):
            with pytest.raises(DeviceError) as error:
                calls[what](plc)
            assert error.value.return_code is code
        assert plc.state().ads_state is AdsState.EXCEPTION
        other = plc.at_port(852)
        assert other.state().ads_state is AdsState.RUN
        assert other.read("MAIN.n") >= 0
        fault = live.run(lambda: live.station.plcs[851].fault)
    assert fault is not None
    assert (fault.name, fault.line) == (exception, line)


EXIT = """
FUNCTION_BLOCK FB_Last
VAR n : INT; END_VAR
METHOD FB_exit : BOOL
VAR_INPUT bInCopyCode : BOOL; END_VAR
n := 1 / n;
END_METHOD
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR fb : FB_Last; x : INT; END_VAR
x := x + 1;
END_PROGRAM
"""


def test_an_exception_in_fb_exit_is_reported_with_its_line(tmp_path: Path) -> None:
    station = _station(tmp_path, EXIT)
    station.advance(0.05)
    (tmp_path / "bad.st").write_text(EXIT.replace("VAR n : INT;", "VAR n : INT; m : INT;"))
    station.online_change(851)
    plc = station.plcs[851]
    assert plc.state is PlcState.EXCEPTION
    assert plc.fault is not None
    assert (plc.fault.name, plc.fault.line, plc.fault.routine) == (
        "DIVIDEBYZERO",
        6,
        "FB_Last.FB_exit",
    )
    station.advance(0.05)
    assert station.plcs[852].instance("MAIN")["n"] == 10


@pytest.mark.parametrize(
    "declared",
    [
        "a : ARRAY [0..2000000000] OF LINT;",
        "a : ARRAY [0..20000, 0..20000, 0..20000] OF LINT;",
        "s : STRING(2000000000);",
        "a : ARRAY [0..-5] OF INT;",
        "a : ARRAY [5..9999999999999999999999] OF INT;",
        "a AT %MB268435455 : LINT;",
    ],
)
def test_declarations_larger_than_any_memory_are_refused_in_words(
    declared: str, tmp_path: Path
) -> None:
    with pytest.raises(ConfigError) as refusal:
        _station(tmp_path, f"PROGRAM MAIN VAR {declared} END_VAR END_PROGRAM")
    assert "bad.st" in str(refusal.value) or "MAIN" in str(refusal.value)


@pytest.mark.parametrize("kind", ["statements", "variables", "functions", "nested", "chain"])
def test_large_sources_run(kind: str, tmp_path: Path, many: Callable[[int], int]) -> None:
    declared, body, units = "n : DINT;", "n := n + 1;", ""
    if kind == "statements":
        body = "n := n + 1;\n" * many(2_000)
    elif kind == "variables":
        declared += "\n".join(f"v{i} : INT;" for i in range(many(2_000)))
    elif kind == "functions":
        units = "\n".join(
            f"FUNCTION F{i} : INT\nF{i} := {i};\nEND_FUNCTION" for i in range(many(200))
        )
    elif kind == "nested":
        body = "IF n >= 0 THEN\n" * 90 + body + "\nEND_IF" * 90
    else:
        body = "n := " + " + ".join(["n"] * 500) + " + 1;"
    text = f"{units}\nPROGRAM MAIN\nVAR {declared} END_VAR\n{body}\nEND_PROGRAM"
    station = _station(tmp_path, text)
    station.advance(0.02)
    assert station.plcs[851].state is PlcState.RUN, station.plcs[851].failure
    assert station.plcs[851].instance("MAIN")["n"] > 0


WORDS = [
    "PROGRAM", "MAIN", "VAR", "END_VAR", "n", ":", "INT", ";", ":=", "IF", "THEN", "END_IF", "(",
    ")", "[", "]", "..", "FOR", "TO", "DO", "END_FOR", "FUNCTION_BLOCK", "METHOD", "END_METHOD",
    "{IF", "}", "defined", "'", '"', "$", "(*", "*)", "//", "%QX0.0", "16#", "T#", "1", "1.5E400",
    "^", ".", "STRUCT", "TYPE", "END_TYPE", "EXTENDS", "__TRY", "__NEW", "ADR", "SIZEOF", "SUPER",
    "THIS", "END_PROGRAM", "\n", "ARRAY", "OF", "POINTER", "REFERENCE", "=>", "CASE", "ELSE",
    "AT", "\0", "\ufeff", "Ω", "0", "-", "x",
]  # fmt: skip


@given(st.integers(0, (1 << 64) - 1), st.integers(0, 300), st.integers(0, 2))
@settings(max_examples=38)
def test_noise_is_refused_in_words_and_nothing_else(seed: int, count: int, kind: int) -> None:
    """Words at random, a sound source with pieces exchanged, or any characters at all."""
    rng = random.Random(seed)
    if kind == 0:
        text = " ".join(rng.choice(WORDS) for _ in range(count))
    elif kind == 1:
        pieces = list(CALLED)
        for _ in range(rng.randint(1, 12)):
            at = rng.randrange(len(pieces))
            pieces[at : at + rng.randint(0, 9)] = rng.choice([rng.choice(WORDS), " ", ""])
        text = "".join(pieces)
    else:
        text = "".join(
            chr(rng.choice([rng.randrange(256), rng.randrange(0xD800)])) for _ in range(count)
        )
    declared, error = examine([parse(Source(text, "noise.st"))])
    for fault in (*(error.faults if error else ()), *check(declared).faults):
        assert fault.message
        assert fault.location.path == "noise.st"
        assert fault.location.line <= text.count("\n") + 1


def test_names_and_numbers_without_end() -> None:
    long = "x" * 100_000
    for text in (
        f"PROGRAM MAIN VAR {long} : INT; END_VAR {long} := 1; END_PROGRAM",
        f"PROGRAM MAIN VAR n : INT; END_VAR n := {'9' * 100_000}; END_PROGRAM",
        f"PROGRAM MAIN VAR n : LREAL; END_VAR n := 1E{'9' * 5_000}; END_PROGRAM",
        f"PROGRAM MAIN VAR s : STRING; END_VAR s := '{string.ascii_letters * 3000}'; END_PROGRAM",
        f"PROGRAM MAIN VAR n : INT; END_VAR n := T#{'9' * 9000}S; END_PROGRAM",
    ):
        declared, _ = examine([parse(Source(text, "long.st"))])
        check(declared)
