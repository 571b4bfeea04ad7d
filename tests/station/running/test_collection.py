"""Nothing of a station outlives it: objects and memory over restarts, stations, online changes."""

import asyncio
import ctypes
import gc
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from achse.client import connect
from achse.station import Station

CONFIG = """
[[axis]]
id = 1
name = "X"
plc = "MAIN.axis"

[[axis]]
id = 2
name = "Y"

[[axis]]
id = 3
name = "C"
modulo = true
encoder_modulo_factor = 360.0

[[channel]]
id = 1
name = "Interpolation"

[[group]]
id = 11
name = "3D"
channel = 1

[[camshaft]]
name = "Press"
axis = "C"

[[bus]]
name = "Drives"

[[drive]]
axis = "Y"

[[terminal]]
name = "Inputs"
input_address = 100

[[plc]]
port = 851
sources = "machine.st"

[[plc]]
port = 852
sources = "plain.st"
code = "plain"

[[fault]]
kind = "online_change"
at = "1000s"

[limits]
abandoned_handles = 1
"""

MACHINE = """
TYPE E_Mode : (idle, busy, done) UINT; END_TYPE
TYPE T_Part : INT (0..99); END_TYPE
TYPE ST_Part : STRUCT n : T_Part; s : STRING(20); e : E_Mode; END_STRUCT END_TYPE
INTERFACE I_Count METHOD Add : DINT VAR_INPUT n : T_Part; END_VAR END_METHOD END_INTERFACE
FUNCTION_BLOCK FB_Count IMPLEMENTS I_Count
VAR nSum : DINT; tDelay : TON; END_VAR
METHOD Add : DINT VAR_INPUT n : T_Part; END_VAR
    nSum := nSum + n;
    Add := nSum;
END_METHOD
tDelay(IN := TRUE, PT := T#10MS);
END_FUNCTION_BLOCK
FUNCTION F_Down : DINT VAR_INPUT n : DINT; END_VAR
IF n > 0 THEN F_Down := 1 + F_Down(n - 1); END_IF
END_FUNCTION
PROGRAM MAIN
VAR
    axis : AXIS_REF; fbCount : FB_Count; iCount : I_Count; aParts : ARRAY [0..9] OF ST_Part;
    pPart : POINTER TO ST_Part; eMode : E_Mode; sText : STRING; n, nCaught : DINT;
    {comment}
END_VAR
VAR RETAIN nKept : DINT; END_VAR
VAR PERSISTENT nLasting : DINT; END_VAR
iCount := fbCount;
fbCount();
n := iCount.Add({added}) + F_Down(5);
pPart := __NEW(ST_Part);
IF pPart <> 0 THEN
    pPart^.sText := 'a';
    __DELETE(pPart);
END_IF
aParts[n MOD 10].s := CONCAT('part ', DINT_TO_STRING(n));
sText := TO_STRING(E_Mode.busy);
nKept := nKept + 1;
__TRY n := n / (n - n); __CATCH nCaught := nCaught + 1; __ENDTRY
END_PROGRAM
""".replace("pPart^.sText", "pPart^.s")

PLAIN = "PROGRAM MAIN VAR n : DINT; t : TON; END_VAR n := n + 1; t(IN := n > 3); END_PROGRAM\n"

ROUNDS = 4
"""In the usual run; `--deep` does 200."""
SEARCH = 4
GROWTH_MB = 8
OURS = {"achse", "llvmlite", "ctypes", "_ctypes"}


def put_sources(folder: Path, added: int = 1, declared: str = "") -> None:
    text = MACHINE.replace("{added}", str(added)).replace("{comment}", declared)
    (folder / "machine.st").write_text(text, encoding="utf-8")


@pytest.fixture
def project(tmp_path: Path) -> Path:
    (tmp_path / "station.toml").write_text(CONFIG, encoding="utf-8")
    (tmp_path / "plain.st").write_text(PLAIN, encoding="utf-8")
    put_sources(tmp_path)
    return tmp_path / "station.toml"


def use(station: Station, client_of: Any) -> None:
    """What a client and a scope leave behind, if anything does."""
    client = client_of(station.router, 851)
    client.subscribe(0x4020, 0, 4, cycle_s=0.01)
    client.exchange(0xF003, 0, 4, b"MAIN.n\0")
    with station.scope(["MAIN.n"], length=0.02) as scope:
        station.advance(0.03)
    assert scope is not None
    station.router.unregister(client.address.port)


def objects() -> Counter[str]:
    """How many objects of our classes there are, and of those that hold machine code."""
    gc.collect()
    kinds = (type(each) for each in gc.get_objects())
    return Counter(
        f"{kind.__module__}.{kind.__qualname__}"
        for kind in kinds
        if str(kind.__module__).partition(".")[0] in OURS
    )


def resident_mb() -> float:
    """Memory of this process that is in use; 0 where the system does not say."""
    statm = Path("/proc/self/statm")
    if not statm.exists():
        return 0.0
    if sys.platform == "linux":
        ctypes.CDLL(None).malloc_trim(0)
    return int(statm.read_text().split()[1]) * 4096 / 1e6


def stays(rounds: int, one: Callable[[int], object]) -> None:
    """Demand that objects and memory are the same after so many rounds as after two."""
    for number in range(2):
        one(number)
    before, memory = objects(), resident_mb()
    for number in range(rounds):
        one(number)
        if number % SEARCH == SEARCH - 1:
            gc.collect()  # at the latest: what waits for Python's own search is no leak
    after = objects()
    assert after == before, {name: (before[name], after[name]) for name in after - before}
    assert resident_mb() - memory < GROWTH_MB


@pytest.fixture
def station(project: Path) -> Station:
    """One whose bus has come into operation."""
    station = Station.load(project)
    station.advance(2.0)
    return station


def test_nothing_outlives_a_restart(
    station: Station, client_of: Any, many: Callable[[int], int]
) -> None:
    def restart(_: int) -> None:
        use(station, client_of)
        station.restart()
        station.advance(0.6)
        assert not station.plcs[851].failure

    stays(many(ROUNDS), restart)


def test_nothing_outlives_a_station(
    project: Path, client_of: Any, many: Callable[[int], int]
) -> None:
    stays(many(ROUNDS), lambda _: use(Station.load(project), client_of))


@pytest.mark.parametrize("declared", ["", "nMore : ARRAY [0..9] OF ST_Part;"])
def test_nothing_outlives_an_online_change(
    station: Station, client_of: Any, many: Callable[[int], int], declared: str
) -> None:
    def change(number: int) -> None:
        put_sources(station.base, 1 + number % 2, declared * (number % 2))
        station.online_change()
        use(station, client_of)
        assert not station.plcs[851].failure

    stays(many(ROUNDS), change)


def test_nothing_outlives_a_reset_of_a_plc(
    station: Station, client_of: Any, many: Callable[[int], int]
) -> None:
    def reset(_: int) -> None:
        station.plcs[851].reset()
        station.plcs[851].run()
        use(station, client_of)

    stays(many(ROUNDS), reset)


def test_nothing_outlives_clients_of_a_served_station(
    station: Station, many: Callable[[int], int]
) -> None:
    async def served() -> None:
        async with station.running("127.0.0.1", 0, udp_port=None, speed=0) as running:
            host = f"127.0.0.1:{running.tcp_port}"
            async with connect(host) as client, client.subscribe("MAIN.n") as samples:
                station.advance(0.1)
                await anext(samples)
                await client.write("MAIN.n", 1)
            async with connect(host) as client, client.subscribe("MAIN.n"):
                station.restart()
                station.advance(0.6)

    stays(many(ROUNDS), lambda _: asyncio.run(served()))


# when Python searches ----------------------------------------------------------------------------


def test_python_searches_seldom_while_stations_are_served() -> None:
    code = """
import gc, weakref
from achse.station.running.collection import collect_remains, seldom_collected
class Knot:
    def __init__(self): self.self = self
before = gc.get_threshold()
early = Knot()
with seldom_collected():
    young, _, old = gc.get_threshold()
    assert young >= 500 and old >= 100
    frozen = gc.get_freeze_count()
    assert frozen > 0
    early = weakref.ref(early)
    gc.collect()
    assert early() is not None
    collect_remains()
    assert early() is None
    assert gc.get_freeze_count() > frozen / 2
    late = weakref.ref(Knot())
    collect_remains()
    assert late() is None
assert gc.get_threshold() == before and gc.get_freeze_count() == 0
last = weakref.ref(Knot())
collect_remains()
assert last() is not None
"""
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert run.stderr == ""
