"""Sum read of 500 symbols by handle (0xF080): the round trip over TCP, and the device alone.

pyads' test server answers no sum commands, so 500 single reads by the same client are beside it.
Usage: python benchmarks/sums.py [ROUNDS]
"""

import asyncio
import statistics
import struct
import sys
import time

from processes import station

import achse
from achse.station import Station
from achse.testing import free_host

HOST = free_host()
PARTS = 500
NAMES = ("MAIN.nCounter", "GVL.nInt", "GVL.fLreal", "GVL.sString", "GVL.stPoint.fX")


def median_ms(spans: list[float]) -> str:
    return f"{statistics.median(spans) * 1e3:7.3f} ms"


async def over_tcp(rounds: int) -> None:
    async with achse.connect(HOST, net_id=f"{HOST}.1.1", mode="direct") as plc:
        handles = []
        for name in (NAMES * PARTS)[:PARTS]:
            answer = await plc.read_write_raw(0xF003, 0, 4, name.encode())
            handles.append(struct.unpack("<I", answer)[0])
        request = b"".join(struct.pack("<III", 0xF005, handle, 4) for handle in handles)
        sums, singles = [], []
        for _ in range(rounds):
            start = time.perf_counter()
            answer = await plc.read_write_raw(0xF080, PARTS, PARTS * 8, request)
            sums.append(time.perf_counter() - start)
            assert len(answer) == PARTS * 8
            assert not any(answer[: PARTS * 4])
        for _ in range(max(3, rounds // 20)):
            start = time.perf_counter()
            for handle in handles:
                await plc.read_raw(0xF005, handle, 4)
            singles.append(time.perf_counter() - start)
    print(f"  one sum read of {PARTS} symbols over TCP   {median_ms(sums)}   (below 1 ms)")
    print(f"  {PARTS} single reads, one after the other  {median_ms(singles)}")


def device_alone(rounds: int) -> None:
    demo = Station.demo()
    plc = next(device for device in demo.devices if device.address.port == 851)
    handles = [
        struct.unpack("<I", plc.read_write(0xF003, 0, 4, name.encode()))[0]
        for name in (NAMES * PARTS)[:PARTS]
    ]
    request = b"".join(struct.pack("<III", 0xF005, handle, 4) for handle in handles)
    spans = []
    for _ in range(rounds):
        start = time.perf_counter()
        plc.read_write(0xF080, PARTS, PARTS * 8, request)
        spans.append(time.perf_counter() - start)
    print(f"  the same in the device, without TCP      {median_ms(spans)}")


def main(rounds: int = 300) -> None:
    print(f"sum read of {PARTS} symbols by handle, median of {rounds} rounds")
    with station(HOST):
        asyncio.run(over_tcp(rounds))
    device_alone(rounds)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
