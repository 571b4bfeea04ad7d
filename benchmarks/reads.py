"""Single reads by pyads: our station beside pyads' test server and bare responders, in turns.

One read after the other, 4 bytes by index group and offset, each server a process of its own. The
bare ones look at nothing but the header: a program in C (`responder.c`), and a protocol of uvloop
or asyncio (that of `outstanding.py`).
Usage: python benchmarks/reads.py [READS] [ROUNDS]
"""

import contextlib
import itertools
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator

from processes import HERE, running, station

from achse.testing import free_host

OURS = "achse station"
PEERS = {
    "pyads test server": ("reads.py", "--serve"),
    "bare, a protocol": ("outstanding.py", "--serve-at"),
}
"""Script and options, to which the host is added."""


def serve(host: str) -> None:
    """pyads' test server with its advanced handler."""
    from pyads.testserver import AdsTestServer, AdvancedHandler, PLCVariable

    handler = AdvancedHandler()
    handler.add_variable(
        PLCVariable("MAIN.n", bytes(4), ads_type=19, symbol_type="UDINT", index_group=0x4040,
                    index_offset=0)
    )  # fmt: skip
    server = AdsTestServer(handler, ip_address=host, logging=False)
    server.start()
    print("peer ready", flush=True)
    server.join()


def read(host: str, symbol: str, reads: int) -> None:
    """Print the rate (1/s) and median latency (µs) of `reads` reads at `host`.

    Of a symbol, or at 0x4040:0 without one.
    """
    import pyads

    pyads.open_port()
    pyads.set_local_address("192.0.2.73.1.1")
    pyads.add_route(f"{host}.1.1", host)
    with pyads.Connection(f"{host}.1.1", 851, host) as plc:
        offset = plc.get_symbol(symbol).index_offset if symbol else 0
        clock = time.perf_counter
        for _ in range(200):
            plc.read(0x4040, offset, pyads.PLCTYPE_UDINT)
        moments = [clock()]
        for _ in range(reads):
            plc.read(0x4040, offset, pyads.PLCTYPE_UDINT)
            moments.append(clock())
    spans = [b - a for a, b in itertools.pairwise(moments)]
    print(reads / (moments[-1] - moments[0]), statistics.median(spans) * 1e6)


def measured(host: str, symbol: str, reads: int) -> tuple[float, float]:
    text = subprocess.run(
        [sys.executable, __file__, "--read", host, symbol, str(reads)],
        check=True, capture_output=True, text=True,
    ).stdout  # fmt: skip
    rate, latency = map(float, text.split())
    return rate, latency


def compiled_responder(folder: str) -> str | None:
    """The bare responder in C, where there is a compiler."""
    compiler = shutil.which("cc")
    if compiler is None:
        return None
    program = f"{folder}/responder"
    source = str(HERE / "responder.c")
    subprocess.run([compiler, "-O2", "-o", program, source], check=True)
    return program


@contextlib.contextmanager
def servers(folder: str) -> Iterator[dict[str, tuple[str, str]]]:
    """Host and symbol of each."""
    hosts = iter(free_host, "")
    with contextlib.ExitStack() as stack:
        ours = next(hosts)
        stack.enter_context(station(ours))
        places = {OURS: (ours, "MAIN.nCounter")}
        for name, (script, *options) in PEERS.items():
            host = next(hosts)
            command = (str(HERE / script), *options, host)
            stack.enter_context(running(*command, ready="peer ready"))
            places[name] = host, ""
        program = compiled_responder(folder)
        if program:
            host = next(hosts)
            stack.enter_context(running(host, ready="peer ready", program=program))
            places["bare, in C"] = host, ""
        yield places


def main(reads: int, rounds: int) -> None:
    with tempfile.TemporaryDirectory() as folder, servers(folder) as beside:
        rows: dict[str, list[tuple[float, float]]] = {name: [] for name in beside}
        for _ in range(rounds):
            for name, (host, symbol) in beside.items():
                rows[name].append(measured(host, symbol, reads))
    print(f"pyads, {reads} single reads of 4 bytes, median of {rounds} rounds in turns")
    for name, row in rows.items():
        rate, latency = (statistics.median(column) for column in zip(*row, strict=True))
        ratio = statistics.median(a[0] / b[0] for a, b in zip(rows[OURS], row, strict=True))
        print(
            f"  {name:22} {rate:8.0f} reads/s   median latency {latency:6.1f} µs"
            + (f"   station/this {ratio:5.2f}" if name != OURS else "")
        )


if __name__ == "__main__":
    if sys.argv[1:2] == ["--serve"]:
        serve(sys.argv[2])
    elif sys.argv[1:2] == ["--read"]:
        read(sys.argv[2], sys.argv[3], int(sys.argv[4]))
    else:
        numbers = [int(argument) for argument in sys.argv[1:]]
        main(numbers[0] if numbers else 5000, numbers[1] if len(numbers) > 1 else 5)
