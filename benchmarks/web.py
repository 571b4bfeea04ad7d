"""What open pages cost a station: late cycles and processor time with and without browsers.

A station with a PLC task of 1 ms whose 32 variables each of the pages records at 1 ms, over
WebSockets in a process of their own that reads everything; beside it the same station without
pages, in the same run. Late: begun more than one cycle late. Then a page that never reads: bytes
that wait for it, after so many seconds of samples put in at once.
With --browsers the pages are the scope in tabs of a real Chromium (playwright, headless), and the
pictures that each of them draws in a second are told.
Usage: python benchmarks/web.py [SECONDS] [PAGES] [--browsers]
"""

import asyncio
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from achse.client import connect
from achse.station import Station
from achse.web.outbox import PageOutbox
from achse.web.server import WebServer
from achse.web.settings import WebSettings

CHANNELS = 32


def station(folder: Path) -> Station:
    """A PLC task of 1 ms with counters and a wave."""
    names = [f"n{n}" for n in range(CHANNELS)]
    variables = " ".join(f"{name} : LREAL;" for name in names)
    body = " ".join(f"{name} := {name} + {n + 1};" for n, name in enumerate(names))
    (folder / "main.st").write_text(
        f"PROGRAM MAIN VAR {variables} END_VAR {body} END_PROGRAM", encoding="utf-8"
    )
    (folder / "station.toml").write_text(
        '[[plc]]\nsources = "main.st"\n[[plc.task]]\ncycle = "1ms"\nprograms = ["MAIN"]\n',
        encoding="utf-8",
    )
    return Station.load(folder / "station.toml")


async def readers(port: int, pages: int) -> None:
    """Pages that record and read; prints blocks, rows and blocks dropped at the end of stdin."""
    import wsproto
    from wsproto import events

    ended = asyncio.Event()
    names = [f"MAIN.n{n}" for n in range(CHANNELS)]
    counts = [0, 0, 0]

    async def one() -> None:
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        wire = wsproto.WSConnection(wsproto.ConnectionType.CLIENT)
        writer.write(wire.send(events.Request(host=f"127.0.0.1:{port}", target="/ws")))
        call = {"id": 1, "call": "scope.start", "with": {"channels": names, "cycle": 0.001}}
        asked = False
        block = bytearray()
        while data := await reader.read(1 << 18):
            wire.receive_data(data)
            for event in wire.events():
                if isinstance(event, events.AcceptConnection) and not asked:
                    asked = True
                    writer.write(wire.send(events.TextMessage(json.dumps(call))))
                elif isinstance(event, events.Ping):
                    writer.write(wire.send(event.response()))
                elif isinstance(event, events.BytesMessage):
                    block += event.data
                    if event.message_finished:
                        counts[0] += 1
                        counts[1] += int.from_bytes(block[8:12], "little")
                        counts[2] = max(counts[2], int.from_bytes(block[12:16], "little"))
                        block.clear()

    tasks = [asyncio.create_task(one()) for _ in range(pages)]
    loop = asyncio.get_running_loop()
    loop.add_reader(sys.stdin.fileno(), ended.set)
    await ended.wait()
    for task in tasks:
        task.cancel()
    print(json.dumps(counts), flush=True)


def look(port: int, pages: int) -> None:
    """Tabs of a Chromium with the scope; prints pictures a second of each at the end of stdin."""
    from playwright.sync_api import sync_playwright

    names = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
    found = os.environ.get("ACHSE_BROWSER") or next(filter(None, map(shutil.which, names)), None)
    traces = "|".join(f"MAIN.n{n}~{1 + n // 8}" for n in range(CHANNELS))
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=found, args=["--no-sandbox"])
        tabs = []
        for _ in range(pages):
            tab = browser.new_context(viewport={"width": 1280, "height": 900}).new_page()
            tab.goto(f"http://127.0.0.1:{port}/#scope?traces={traces}")
            tabs.append(tab)
        for tab in tabs:
            tab.wait_for_function("() => document.querySelectorAll('.chart canvas').length >= 4")
            tab.evaluate(COUNT_FRAMES)
        sys.stdin.read()
        print(json.dumps([round(tab.evaluate("frames()"), 1) for tab in tabs]))
        browser.close()


COUNT_FRAMES = """() => {
  const [begin, count] = [performance.now(), () => { drawn += 1; requestAnimationFrame(count); }];
  let drawn = 0;
  count();
  globalThis.frames = () => 1000 * drawn / (performance.now() - begin);
}"""


async def measured(
    folder: Path, seconds: float, pages: int, kind: str = "--read"
) -> tuple[int, int, float, list[float]]:
    """Cycles, late ones, share of a processor, and what the pages counted."""
    made = station(folder)
    counts: list[float] = [0, 0, 0]
    async with (
        made.running("127.0.0.1", 0),
        connect(made.router, port=851, keep_alive=None) as client,
        WebServer(client, WebSettings(port=0)) as web,
    ):
        command = [sys.executable, __file__, kind, str(web.port), str(pages)]
        child = None
        if pages:
            child = await asyncio.create_subprocess_exec(
                *command, stdin=subprocess.PIPE, stdout=subprocess.PIPE
            )
            while sum(len(page.scopes) for page in web.open_pages) < pages:  # noqa: ASYNC110
                await asyncio.sleep(0.01)
        await asyncio.sleep(0.5)
        assert made.pace is not None
        late, begin, used = made.pace.late_ticks, made.time_ns, time.process_time()
        await asyncio.sleep(seconds)
        late = made.pace.late_ticks - late
        cycles = (made.time_ns - begin) // made.tick_ns
        share = (time.process_time() - used) / seconds
        if child is not None:
            out, _ = await child.communicate(b"\n")
            counts = json.loads(out)
    return cycles, late, share, counts


def waiting(seconds: float) -> tuple[int, int]:
    """Bytes that wait for a page that never reads, and bytes that were put in."""
    outbox = PageOutbox()
    rows = 40
    payload = bytes(8 * rows * (CHANNELS + 1))
    blocks = round(seconds * 1000 / rows)
    for _ in range(blocks):
        outbox.put_block(1, payload, CHANNELS + 1, rows)
    return outbox.held, blocks * len(payload)


def main() -> None:
    """Measure and print."""
    if sys.argv[1:2] == ["--read"]:
        asyncio.run(readers(int(sys.argv[2]), int(sys.argv[3])))
        return
    if sys.argv[1:2] == ["--look"]:
        look(int(sys.argv[2]), int(sys.argv[3]))
        return
    browsers = "--browsers" in sys.argv
    if browsers:
        sys.argv.remove("--browsers")
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 20.0
    pages = int(sys.argv[2]) if len(sys.argv) > 2 else 10
    for count in (0, pages, 0):
        with tempfile.TemporaryDirectory() as folder:
            cycles, late, share, counts = asyncio.run(
                measured(Path(folder), seconds, count, "--look" if browsers else "--read")
            )
        told = f"{count:3} pages  {cycles} cycles, {late} late ({late / max(cycles, 1):.3%})"
        told += f", {share:.1%} of a processor"
        if count and browsers:
            told += f"; pictures a second: {', '.join(map(str, counts))}"
        elif count:
            told += f"; {counts[0]} blocks, {counts[1]} rows read, {counts[2]} blocks dropped"
        print(told, flush=True)
    held, put = waiting(3600.0)
    print(f"a page that does not read, 1 h of samples: {held:,} bytes wait of {put:,}")


if __name__ == "__main__":
    main()
