"""What a station, an axis, a request and a client cost, in processor time and memory (Linux).

Stations run in real time in processes of their own; what they cost is read from /proc, so that
other programs disturb little. Requests are reads of 4 bytes by TCP, Secure ADS and MQTT, one client
with 16 under way: microseconds of the station, of the client and of the broker for each.
Usage: python benchmarks/costs.py [SECONDS] [READS]
"""

import asyncio
import contextlib
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from transports import broker, certificates, missing, secure_target, to_station

TICKS = os.sysconf("SC_CLK_TCK")
AXES = 100
UNDER_WAY = 16


def processor(process: int) -> float:
    """Seconds of processor time so far."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def memory(process: int) -> float:
    """MB that are this process's own."""
    text = Path(f"/proc/{process}/smaps_rollup").read_text()
    return sum(map(int, re.findall(r"^Private_\w+: +(\d+)", text, re.MULTILINE))) / 1024


@contextlib.contextmanager
def station(text: str) -> Iterator[tuple[int, dict[str, str]]]:
    """A station of its own; its process and the words of its ready line."""
    with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
        file.write(text)
        file.flush()
        command = [sys.executable, "-m", "achse", "run", file.name]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None
            line = next(line for line in process.stdout if line.startswith("achse ready"))
            try:
                yield process.pid, dict(word.split("=", 1) for word in line.split() if "=" in word)
            finally:
                process.terminate()


def axes(count: int) -> str:
    return "".join(f'[[axis]]\nid = {n}\nname = "A{n}"\n' for n in range(1, count + 1))


async def move_all(target: str, count: int) -> None:
    """Each axis runs at a steady velocity from now on."""
    import achse

    async with achse.connect(target, source="192.0.2.78.1.1:40000", watch_symbols=False) as client:
        for number in range(1, count + 1):
            axis = client.nc.axis(number)
            await axis.enable()
            await axis.move_velocity(100.0, wait=False)


def of_station(seconds: float) -> None:
    """With one axis, with many at rest, with many that move."""
    head = '[router]\nnet_id = "5.6.7.8.1.1"\ntcp_port = 0\n'
    spent: dict[str, tuple[float, float]] = {}
    for name, count in (("one", 1), ("rest", AXES + 1), ("moving", AXES + 1)):
        with station(head + axes(count)) as (process, words):
            if name == "moving":
                asyncio.run(move_all(words["tcp"], count))
            time.sleep(min(seconds, 1.0))
            before = processor(process)
            time.sleep(seconds)
            spent[name] = (processor(process) - before) / seconds, memory(process)
    small, room = spent["one"]
    print(f"station with one axis      {small:8.2%} of a core   {room:6.1f} MB")
    for name in ("rest", "moving"):
        share, own = ((spent[name][k] - spent["one"][k]) / AXES for k in (0, 1))
        print(f"axis, {name:<20} {share:8.4%} of a core   {own * 1024:6.0f} kB")


async def ask(transport: object, reads: int) -> float:
    """Processor seconds of this process for so many reads."""
    async with transport as read:  # type: ignore[attr-defined]
        await read()

        async def go_on() -> None:
            for _ in range(reads // UNDER_WAY):
                await read()

        before = time.process_time()
        await asyncio.gather(*(go_on() for _ in range(UNDER_WAY)))
        return time.process_time() - before


def of_requests(folder: Path, reads: int) -> None:
    without_tls = missing("", "secure", "OpenSSL")
    without_mqtt = missing("mosquitto", "mqtt", "aiomqtt")
    text = '[router]\nnet_id = "5.6.7.8.1.1"\ntcp_port = 0\n'
    text += "" if without_tls else 'listen = "both"\n'
    with contextlib.ExitStack() as stack:
        mqtt = None if without_mqtt else stack.enter_context(broker(folder))
        text += axes(1)
        if mqtt is not None:
            text += f'[[mqtt]]\nbroker = "127.0.0.1"\nport = {mqtt[0]}\ntopic = "transports"\n'
        text += "" if without_tls else certificates(folder)
        process, words = stack.enter_context(station(text))
        targets = {"TCP": words["tcp"]}
        if not without_tls:
            targets["TLS"] = secure_target(folder, int(words["secure"].rpartition(":")[2]))
        if mqtt is not None:
            targets["MQTT"] = f"mqtt://127.0.0.1:{mqtt[0]}/transports"
        for name, target in targets.items():
            before, between = processor(process), mqtt and processor(mqtt[1])
            own = asyncio.run(ask(to_station(target), reads))
            line = f"station {(processor(process) - before) / reads * 1e6:6.0f} µs"
            line += f"   client {own / reads * 1e6:6.0f} µs"
            if name == "MQTT" and mqtt and between is not None:
                line += f"   broker {(processor(mqtt[1]) - between) / reads * 1e6:6.0f} µs"
            print(f"request by {name:<15} {line}")


def main(seconds: float, reads: int) -> None:
    of_station(seconds)
    with tempfile.TemporaryDirectory() as name:
        of_requests(Path(name), reads)


if __name__ == "__main__":
    arguments = sys.argv[1:] or ["10", "20000"]
    main(float(arguments[0]), int(arguments[1]))
