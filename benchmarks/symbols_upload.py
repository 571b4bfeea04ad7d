"""Upload of 100,000 symbols: the first and later ones, and look-up by name; pyads beside it.

The station declares them in Structured Text. Usage: python benchmarks/symbols_upload.py [SYMBOLS]
"""

import asyncio
import importlib.util
import sys
import tempfile
import time
from pathlib import Path

from processes import station

import achse
from achse.ams.commands import ReadWriteRequest
from achse.testing import free_host

HOST = free_host()
PER_LIST = 1000
TYPES = ("INT", "LREAL", "STRING(20)", "ARRAY[0..9] OF DINT", "ST_Part")


def declare(folder: Path, symbols: int) -> Path:
    """Sources with that many variables, and a station.toml for them."""
    (folder / "types.st").write_text(
        "TYPE ST_Part : STRUCT nId : INT; sName : STRING(15); END_STRUCT END_TYPE\n"
    )
    for first in range(0, symbols, PER_LIST):
        lines = [
            f"    nVariable{number} : {TYPES[number % len(TYPES)]};"
            for number in range(first, min(first + PER_LIST, symbols))
        ]
        text = "\n".join(["VAR_GLOBAL", *lines, "END_VAR", ""])
        (folder / f"GVL_{first // PER_LIST}.st").write_text(text)
    toml = folder / "station.toml"
    toml.write_text('[[plc]]\nsources = "."\n')
    return toml


async def measure() -> None:
    async with achse.connect(HOST, timeout=60, watch_symbols=False) as plc:
        for which in ("first", "second"):
            start = time.perf_counter()
            size = int.from_bytes((await plc.read_raw(0xF00F, 0, 24))[4:8], "little")
            table = await plc.read_raw(0xF00B, 0, size)
            print(f"  {which} upload {time.perf_counter() - start:.3f} s, {len(table)} bytes")
        start = time.perf_counter()
        entries = await plc.symbols()
        print(f"  upload and decoding {time.perf_counter() - start:.3f} s, {len(entries)} symbols")
        names = [entry.name for entry in entries[:: max(1, len(entries) // 10_000)]]
        start = time.perf_counter()
        outcomes = await plc.send_each(
            [ReadWriteRequest(0xF009, 0, 0xFFFF, name.encode()) for name in names]
        )
        elapsed = time.perf_counter() - start
        assert all(outcome.result == 0 for outcome in outcomes)
        print(f"  look-up by name {elapsed / len(names) * 1e6:.1f} us each, in sums of 500")


def beside() -> None:
    """The same list by pyads, as a yardstick for what a client spends itself."""
    import pyads

    with pyads.Connection(f"{HOST}.1.1", 851, HOST) as plc:
        plc.set_timeout(60_000)
        start = time.perf_counter()
        count = len(plc.get_all_symbols())
        print(f"  pyads get_all_symbols {time.perf_counter() - start:.3f} s, {count} symbols")


def main(symbols: int = 100_000) -> None:
    with tempfile.TemporaryDirectory() as name:
        toml = declare(Path(name), symbols)
        start = time.perf_counter()
        with station(HOST, str(toml)):
            print(f"{symbols} symbols, station ready in {time.perf_counter() - start:.1f} s")
            asyncio.run(measure())
            if importlib.util.find_spec("pyads"):
                beside()


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
