"""Python modules generated from the symbols of a station: they import, read, write and call."""

import asyncio
import re
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import achse
from achse.ams import DeviceError
from achse.client import MethodResult
from achse.client.stubs import programs_of, stubs
from achse.codes import ReturnCode
from achse.iec import INT, LREAL, IecType, IecValueError, Method, Parameter
from achse.iec.entries import name_in_table
from achse.station import Station
from achse.station.configuration.station_file import parse
from tests.plc.code.hostile_names import NAMES

SOURCES = """
TYPE E_Mode : (OFF := 0, ON := 3) UINT; END_TYPE
TYPE ST_Part : STRUCT
    nId : INT; eMode : E_Mode; sName : STRING(10); wsName : WSTRING(5);
    tWait : TIME; aGrid : ARRAY[0..1, 1..2] OF REAL; class : BOOL;
    stWhere : ST_Where;
END_STRUCT END_TYPE
TYPE ST_Where : STRUCT nRow : INT; END_STRUCT END_TYPE
FUNCTION_BLOCK FB_Sum
VAR nCalls : INT; END_VAR
{attribute 'TcRpcEnable'}
METHOD Add : LREAL
VAR_INPUT fA : LREAL; fB : LREAL; END_VAR
VAR_OUTPUT nCalls : INT; END_VAR
END_METHOD
{attribute 'TcRpcEnable'}
METHOD Name : STRING(10)
VAR_INPUT stPart : ST_Part; END_VAR
END_METHOD
{attribute 'TcRpcEnable'}
METHOD Clear
END_METHOD
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR
    aParts : ARRAY[1..2] OF ST_Part := [(nId := 1, sName := 'one'), (nId := 2)];
    fbSum : FB_Sum;
    tLong : LTIME := LTIME#5us;
    pNone : POINTER TO INT;
END_VAR
END_PROGRAM
"""
BEHAVIOUR = """
class FB_Sum:
    def Add(self, a, b):
        self.nCalls += 1
        return a + b, self.nCalls

    def Name(self, part):
        return part.sName.upper()

    def Clear(self):
        self.nCalls = 0
"""


@pytest.fixture
def station(tmp_path: Path) -> Station:
    (tmp_path / "plc.st").write_text(SOURCES)
    (tmp_path / "behaviour.py").write_text(BEHAVIOUR)
    path = tmp_path / "station.toml"
    path.write_text('[[plc]]\nsources = "plc.st"\nbehaviour = ["behaviour.py:FB_Sum"]\n')
    return Station.load(path)


async def _module(plc: achse.client.Client, monkeypatch: pytest.MonkeyPatch) -> Any:
    types = await plc.types()
    symbols = {e.name: types.symbol_type(e) for e in await plc.symbols() if "TwinCAT" not in e.name}
    source = stubs(symbols, 'a "target"\\', await programs_of(plc, symbols))
    module = ModuleType("generated_stubs")
    monkeypatch.setitem(sys.modules, module.__name__, module)
    exec(compile(source, "generated_stubs", "exec"), vars(module))
    return module


def test_values_are_read_and_written_with_their_types(
    station: Station, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def main() -> None:
        async with achse.connect(station.router) as plc:
            module = await _module(plc, monkeypatch)
            symbols = module.Symbols(plc)
            first, second = await symbols.MAIN.aParts.read()
            assert isinstance(first, module.ST_Part)
            assert (first.nId, first.sName, second.eMode) == (1, "one", module.E_Mode.OFF)
            first.eMode, first.wsName, first.class_ = module.E_Mode.ON, "ß", True
            first.aGrid[1][0] = 2.5
            await symbols.MAIN.aParts.write([first, second])
            assert await symbols.MAIN.aParts.read() == [first, second]
            assert await plc.read("MAIN.aParts[1].aGrid[1,1]") == 2.5
            assert await symbols.MAIN.tLong.read() == 5000
            async with symbols.MAIN.aParts.samples() as samples:
                station.advance(0.1)
                typed = await anext(samples)
                assert typed.value == [first, second]

    asyncio.run(main())


def test_methods_are_called_with_their_types(
    station: Station, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def main() -> None:
        async with achse.connect(station.router) as plc:
            module = await _module(plc, monkeypatch)
            symbol = module.Symbols(plc).MAIN.fbSum
            assert await symbol.Add(fA=1.0, fB=2.0) == MethodResult(3.0, {"nCalls": 1})
            part = (await module.Symbols(plc).MAIN.aParts.read())[0]
            assert await symbol.Name(stPart=part) == "ONE"
            assert await symbol.Clear() is None
            assert (await symbol.read()).nCalls == 0

    asyncio.run(main())


def test_calls_by_name_and_their_refusals(station: Station) -> None:
    async def main() -> None:
        async with achse.connect(station.router) as plc:
            result = await plc.call("main.FBSUM", "add", fa=1, FB=2)
            assert result == MethodResult(3.0, {"nCalls": 1})
            with pytest.raises(IecValueError, match="fB"):
                await plc.call("MAIN.fbSum", "Add", fA=1)
            with pytest.raises(IecValueError, match=r"got 'fc'"):
                await plc.call("MAIN.fbSum", "Add", fA=1, fB=2, fC=3)
            with pytest.raises(DeviceError, match=r"not found; did you mean 'Add'\?"):
                await plc.call("MAIN.fbSum", "Addd")
            for name, method in (("MAIN.fbSum", "Nothing"), ("MAIN.aParts", "Add")):
                with pytest.raises(DeviceError, match="declares no method") as refusal:
                    await plc.call(name, method)
                assert refusal.value.return_code is ReturnCode.SYMBOL_NOT_FOUND
            # A device that declares no methods can still be called by a declaration of one's own.
            inputs = (Parameter("fA", LREAL), Parameter("fB", LREAL))
            add = Method("Add", (*inputs, Parameter("nCalls", INT, is_output=True)), LREAL)
            assert (await plc.call("MAIN.fbSum", add, fA=2, fB=2)).value == 4.0

    asyncio.run(main())


def test_calls_survive_an_online_change(station: Station) -> None:
    async def main() -> None:
        async with achse.connect(station.router, watch_symbols=False) as plc:
            assert (await plc.call("MAIN.fbSum", "Add", fA=1, fB=2)).outputs == {"nCalls": 1}
            station.online_change()
            assert (await plc.call("MAIN.fbSum", "Add", fA=1, fB=2)).outputs == {"nCalls": 2}

    asyncio.run(main())


def test_no_symbols_give_a_module_all_the_same() -> None:
    nothing: dict[str, IecType[Any]] = {}
    scope: dict[str, Any] = {"__name__": "generated_empty"}
    exec(compile(stubs(nothing, "t"), "empty", "exec"), scope)
    assert scope["__all__"] == ["Symbols"]


MACHINE = """
TYPE ST_Order : STRUCT nId : INT; sName : STRING(10); END_STRUCT END_TYPE
FUNCTION_BLOCK FB_Drive
VAR nSpeed : INT; name : STRING(5); END_VAR
{attribute 'TcRpcEnable'}
METHOD read : INT
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Line
VAR fbMain : FB_Drive; aDrives : ARRAY [1..2] OF FB_Drive; nCount : INT; END_VAR
END_FUNCTION_BLOCK
PROGRAM MAIN
VAR fbLine : FB_Line; aGrid : ARRAY [0..1, 1..2] OF FB_Drive; nParts, call : INT; END_VAR
{attribute 'TcRpcEnable'}
METHOD Start : ST_Order
VAR_INPUT nParts : INT; END_VAR
END_METHOD
{attribute 'TcRpcEnable'}
METHOD Order : BOOL
VAR_INPUT stOrder : ST_Order; END_VAR
VAR_OUTPUT nLeft : INT; END_VAR
END_METHOD
END_PROGRAM
PROGRAM Quiet
VAR n : INT; END_VAR
END_PROGRAM
"""
MACHINE_BEHAVIOUR = """
class MAIN:
    def Start(self, parts):
        self.nParts = parts
        return {"nId": parts, "sName": "started"}

    def Order(self, order):
        return order.sName == "more", self.nParts - order.nId


class FB_Drive:
    def read(self):
        return self.nSpeed
"""


@pytest.fixture
def machine(tmp_path: Path) -> Station:
    (tmp_path / "plc.st").write_text(MACHINE)
    (tmp_path / "behaviour.py").write_text(MACHINE_BEHAVIOUR)
    path = tmp_path / "station.toml"
    names = ", ".join(f'"behaviour.py:{name}"' for name in ("MAIN", "FB_Drive"))
    path.write_text(f'[[plc]]\nsources = "plc.st"\nbehaviour = [{names}]\n')
    return Station.load(path)


def test_methods_of_programs_are_called_with_their_types(
    machine: Station, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def main() -> None:
        async with achse.connect(machine.router) as plc:
            module = await _module(plc, monkeypatch)
            symbols = module.Symbols(plc)
            order = await symbols.MAIN.Start(nParts=5)
            assert order == module.ST_Order(nId=5, sName="started")
            assert await symbols.MAIN.nParts.read() == 5
            assert await symbols.MAIN.call_.read() == 0  # A variable that is called like that.
            more = module.ST_Order(nId=2, sName="more")
            assert await symbols.MAIN.Order(stOrder=more) == MethodResult(True, {"nLeft": 3})
            assert not hasattr(symbols.Quiet, "call")

    asyncio.run(main())


def test_methods_of_blocks_in_blocks_and_arrays(
    machine: Station, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def main() -> None:
        async with achse.connect(machine.router) as plc:
            module = await _module(plc, monkeypatch)
            main = module.Symbols(plc).MAIN
            await plc.write("MAIN.fbLine.aDrives[2].nSpeed", 7)
            await plc.write("MAIN.aGrid[1,2].nSpeed", 9)
            assert await main.fbLine.aDrives[2].read_() == 7
            assert await main.fbLine.fbMain.read_() == 0
            assert await main.aGrid[1, 2].read_() == 9
            assert (await main.aGrid[1, 2].read()).nSpeed == 9
            assert (await main.fbLine.aDrives.read())[1].nSpeed == 7

    asyncio.run(main())


NAMED = """
TYPE <Mode> : (<idle> := 3, <busy> := 5) DINT; END_TYPE
TYPE <Part> : STRUCT <number> : LINT; <text> : STRING(20); <mode> : <Mode>; <list> : ARRAY [0..1]
OF LREAL; END_STRUCT END_TYPE
FUNCTION_BLOCK <Block> VAR <total> : LINT; <part> : <Part>; END_VAR
{attribute 'TcRpcEnable'}
METHOD <Add> : LINT VAR_INPUT <by> : LINT; <with> : <Part>; END_VAR <total> := <total> + <by>;
<Add> := <total>; END_METHOD
END_FUNCTION_BLOCK
PROGRAM <Main> VAR <block> : <Block>; <record> : <Part> := (<number> := 9, <mode> := <Mode>.<busy>);
<word> : STRING := 'a'; <real> : LREAL := 0.5; END_VAR
END_PROGRAM
PROGRAM <Other> VAR <record> : INT := 4; END_VAR END_PROGRAM
"""
ROLES = sorted(set(re.findall(r"<(\w+)>", NAMED)))
PAIRS = {"number": "\u00b5", "text": "\u03bc", "mode": "x\u00b2", "idle": "_a_", "Main": "_Main"}
"""Names that are one in Python, none, or reserved in a class."""


@settings(max_examples=10)
@given(st.lists(NAMES, min_size=len(ROLES), max_size=len(ROLES), unique_by=str.lower))
@example([PAIRS.get(role, f"r_{role}") for role in ROLES])
def test_symbols_of_any_names_are_a_module(
    tmp_path_factory: pytest.TempPathFactory, drawn: list[str]
) -> None:
    names = dict(zip(ROLES, drawn, strict=True))
    path = tmp_path_factory.mktemp("named") / "plc.st"
    text = re.sub(r"<(\w+)>", lambda match: names[match[1]], NAMED)
    path.write_text(text, encoding="utf-8")
    configuration = {"plc": [{"sources": "plc.st", "code": "plain"}]}
    station = Station(parse(configuration, ""), base=path.parent)

    async def main() -> None:
        async with achse.connect(station.router) as plc:
            with pytest.MonkeyPatch.context() as patch:
                symbols = (await _module(plc, patch)).Symbols(plc)
                units = [vars(unit).values() for unit in vars(symbols).values()]
                exported = {
                    each.name: each for unit in units for each in unit if hasattr(each, "read")
                }
                own = {each.name for each in await plc.symbols() if "TwinCAT" not in each.name}
                assert exported.keys() == own
                for symbol in exported.values():
                    value = await symbol.read()
                    await symbol.write(value)
                    assert await symbol.read() == value
                record = await exported[name_in_table(f"{names['Main']}.{names['record']}")].read()
                assert [*vars(record).values()] == [9, "", 5, [0.0, 0.0]]
                assert (
                    await exported[name_in_table(f"{names['Other']}.{names['record']}")].read() == 4
                )

    asyncio.run(main())
