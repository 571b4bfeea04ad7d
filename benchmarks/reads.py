"""Single reads by pyads: our station beside pyads' own test server, in turns.

One read after the other, 4 bytes by index group and offset, each server a process of its own.
Usage: python benchmarks/reads.py [READS] [ROUNDS]
"""

import itertools
import statistics
import subprocess
import sys
import time

from processes import HERE, running, station

from achse.testing import free_host


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


def main(reads: int, rounds: int) -> None:
    ours, theirs = [], []
    here, there = free_host(), free_host()
    with station(here), running(str(HERE / "reads.py"), "--serve", there, ready="peer ready"):
        for _ in range(rounds):
            ours.append(measured(here, "MAIN.nCounter", reads))
            theirs.append(measured(there, "", reads))
    print(f"pyads, {reads} single reads of 4 bytes, median of {rounds} rounds in turns")
    for name, rows in (("achse station", ours), ("pyads test server", theirs)):
        rate, latency = (statistics.median(column) for column in zip(*rows, strict=True))
        print(f"  {name:18} {rate:8.0f} reads/s   median latency {latency:6.1f} µs")
    ratios = [a[0] / b[0] for a, b in zip(ours, theirs, strict=True)]
    print(f"  ratio              {statistics.median(ratios):8.2f}   (at least 1.0 is promised)")


if __name__ == "__main__":
    if sys.argv[1:2] == ["--serve"]:
        serve(sys.argv[2])
    elif sys.argv[1:2] == ["--read"]:
        read(sys.argv[2], sys.argv[3], int(sys.argv[4]))
    else:
        numbers = [int(argument) for argument in sys.argv[1:]]
        main(numbers[0] if numbers else 5000, numbers[1] if len(numbers) > 1 else 5)
