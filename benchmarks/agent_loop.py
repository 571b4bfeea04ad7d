"""Time of an agent's loop in `achse mcp`: edit a body, check, run the unit tests.

The official client talks to the server over standard streams. The project is made up of that many
sources beside the 30 tests of tests/data/unit_tests. Usage: python benchmarks/agent_loop.py
[SOURCES] [LOOPS]
"""

import asyncio
import shutil
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from language_server import write_project
from mcp import Client, StdioServerParameters

DATA = Path(__file__).parents[1] / "tests" / "data" / "unit_tests"
STATION = '[[plc]]\nsources = "line"\nlibraries = ["TcUnit"]\n'
TASK = {"project": "station.toml"}
GOOD, BAD = "PT := tDown", "PT := T#50MS"


def write_folder(folder: Path, count: int) -> None:
    """Write the project, its station and what looks like TcUnit."""
    line = folder / "line"
    line.mkdir()
    write_project(line, count)
    for file in (DATA / "press" / "POUs").iterdir():
        shutil.copy(file, line)
    shutil.copytree(DATA / "tcunit_stub", folder / "TcUnit")
    (folder / "station.toml").write_text(
        STATION + '[[plc.task]]\nname = "PlcTask"\nprograms = ["PRG_TEST"]\n'
    )


def _row(name: str, seconds: list[float]) -> None:
    ordered = sorted(seconds)
    p95 = ordered[min(int(len(ordered) * 0.95), len(ordered) - 1)]
    print(
        f"{name:<34} p50 {statistics.median(ordered) * 1e3:>7.1f} ms   p95 {p95 * 1e3:>7.1f} ms"
        f"   max {ordered[-1] * 1e3:>7.1f} ms   {len(ordered)} times"
    )


def _names(report: Any) -> list[str]:
    return [test["name"] for test in report["tests"]]


async def _measure(folder: Path, loops: int) -> None:
    times: dict[str, list[float]] = {name: [] for name in ("edit_code", "check", "test", "loop")}
    arguments = ["-m", "achse", "mcp", "--root", str(folder)]
    began = time.perf_counter()
    async with Client(StdioServerParameters(command=sys.executable, args=arguments)) as client:

        async def call(tool: str, **named: Any) -> Any:
            start = time.perf_counter()
            result = await client.call_tool(tool, named | TASK)
            times.setdefault(tool, []).append(time.perf_counter() - start)
            if result.is_error:
                raise RuntimeError(f"{tool}: {result.content}")
            return result.structured_content

        connected = time.perf_counter() - began
        first = await call("check")
        print(f"connected in {connected:.2f} s, first check {times['check'].pop():.2f} s")
        assert first["ok"], first["findings"]
        baseline = _names(await call("test"))
        print(f"first test {times['test'].pop():.2f} s, {first['sources']} sources")
        old, new = GOOD, BAD
        for _ in range(2 * loops):
            start = time.perf_counter()
            await call("edit_code", file="line/FB_Press.TcPOU", old=old, new=new)
            await call("check")
            failed = _names(await call("test"))
            times["loop"].append(time.perf_counter() - start)
            assert (failed != baseline) == (new == BAD)
            old, new = new, old
    for name, seconds in times.items():
        _row(name, seconds)


def main() -> None:
    """Measure a made-up project."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    loops = int(sys.argv[2]) if len(sys.argv) > 2 else 10
    with tempfile.TemporaryDirectory() as folder:
        write_folder(Path(folder), count)
        asyncio.run(_measure(Path(folder), loops))


if __name__ == "__main__":
    main()
