"""What open pages cost a station: late cycles and processor time with and without browsers.

A station with a PLC task of 1 ms whose 32 variables each of the pages records at 1 ms, over
WebSockets in a process of their own that reads everything; beside it the same station without
pages, in the same run. Late: begun more than one cycle late. Then a page that never reads: bytes
that wait for it, after so many seconds of samples put in at once.
With --browsers the pages are the scope in tabs of a real Chromium (playwright, headless: it draws
without a graphics processor). Told are the pictures that each of them draws in a second, and for
each picture the processor time of all of Chromium, and of script and layout in the page's main
thread. Pictures a second depend on what else the machine does, processor time hardly.
Usage: python benchmarks/web.py [SECONDS] [PAGES] [--browsers] [--window=5]
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
from typing import Any

from achse.client import connect
from achse.station import Station
from achse.web.send_queue import PageSendQueue
from achse.web.server import WebServer
from achse.web.settings import WebSettings

CHANNELS = 32


def station(folder: Path) -> Station:
    """A PLC task of 1 ms with waves, every fourth with noise."""
    names = [f"n{n}" for n in range(CHANNELS)]
    variables = "t : LREAL; seed : UDINT; noise : LREAL; "
    variables += " ".join(f"{name} : LREAL;" for name in names)
    body = "t := t + 0.001; seed := seed * 1664525 + 1013904223; "
    body += "noise := UDINT_TO_LREAL(seed) / 4294967296.0; "
    body += " ".join(
        f"{name} := {n % 8 - 4}.0 + 2.0 * SIN({0.3 + 0.4 * n} * t)"
        + (" + noise;" if n % 4 == 0 else ";")
        for n, name in enumerate(names)
    )
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
        requested = False
        block = bytearray()
        while data := await reader.read(1 << 18):
            wire.receive_data(data)
            for event in wire.events():
                if isinstance(event, events.AcceptConnection) and not requested:
                    requested = True
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


def look(port: int, pages: int, window: str) -> None:
    """Tabs of a Chromium with the scope; prints what they drew and took at the end of stdin."""
    from playwright.sync_api import CDPSession, sync_playwright

    names = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
    executable = os.environ.get("ACHSE_BROWSER") or next(
        filter(None, map(shutil.which, names)), None
    )
    traces = "|".join(f"MAIN.n{n}~{1 + n // 8}" for n in range(CHANNELS))

    def processor(session: CDPSession) -> float:
        answer = session.send("SystemInfo.getProcessInfo")["processInfo"]
        return sum(float(each["cpuTime"]) for each in answer)

    def metrics(session: CDPSession) -> tuple[float, float]:
        answer = session.send("Performance.getMetrics")["metrics"]
        values = {each["name"]: float(each["value"]) for each in answer}
        layout = values["LayoutDuration"] + values["RecalcStyleDuration"]
        return values["ScriptDuration"], layout

    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=executable, args=["--no-sandbox"])
        whole = browser.new_browser_cdp_session()
        tabs = []
        for _ in range(pages):
            tab = browser.new_context(viewport={"width": 1280, "height": 900}).new_page()
            tab.add_init_script(COUNT_PICTURES)
            tab.goto(f"http://127.0.0.1:{port}/#scope?width={window}&traces={traces}")
            session = tab.context.new_cdp_session(tab)
            session.send("Performance.enable", {"timeDomain": "threadTicks"})
            tabs.append((tab, session))
        for tab, _ in tabs:
            tab.wait_for_function("() => document.querySelectorAll('.chart canvas').length >= 4")
        tabs[0][0].wait_for_timeout(1000 * float(window) + 500)  # the window is full then
        begin = processor(whole), time.monotonic()
        before = [(tab.evaluate("pictures"), *metrics(session)) for tab, session in tabs]
        print("ready", flush=True)
        sys.stdin.read()
        after = [(tab.evaluate("pictures"), *metrics(session)) for tab, session in tabs]
        used, passed = processor(whole) - begin[0], time.monotonic() - begin[1]
        drawn, script, layout = (
            [end[n] - first[n] for end, first in zip(after, before, strict=True)] for n in range(3)
        )
        each = 1000 / max(sum(drawn), 1)
        figures = {
            "pictures a second": [round(count / passed, 1) for count in drawn],
            "ms a picture": round(used * each, 2),
            "script": round(sum(script) * each, 2),
            "layout": round(sum(layout) * each, 2),
        }
        print(json.dumps(figures))
        browser.close()


COUNT_PICTURES = """
globalThis.pictures = 0;
const clear = CanvasRenderingContext2D.prototype.clearRect;
CanvasRenderingContext2D.prototype.clearRect = function (...args) {
  if (this.canvas === document.querySelector(".chart canvas")) globalThis.pictures += 1;
  return clear.apply(this, args);
};
"""


async def measured(
    folder: Path, seconds: float, pages: int, kind: str, window: str
) -> tuple[int, int, float, Any]:
    """Cycles, late ones, share of a processor, and what the pages counted."""
    watched = station(folder)
    counts: Any = None
    async with (
        watched.running("127.0.0.1", 0),
        connect(watched.router, port=851, keep_alive=None) as client,
        WebServer(client, WebSettings(port=0)) as web,
    ):
        command = [sys.executable, __file__, kind, str(web.port), str(pages), window]
        child = None
        if pages:
            child = await asyncio.create_subprocess_exec(
                *command, stdin=subprocess.PIPE, stdout=subprocess.PIPE
            )
            while sum(len(page.scopes) for page in web.open_pages) < pages:  # noqa: ASYNC110
                await asyncio.sleep(0.01)
            if kind == "--look":
                assert child.stdout is not None
                await child.stdout.readline()
        await asyncio.sleep(0.5)
        assert watched.pace is not None
        late, begin, used = watched.pace.late_ticks, watched.time_ns, time.process_time()
        await asyncio.sleep(seconds)
        late = watched.pace.late_ticks - late
        cycles = (watched.time_ns - begin) // watched.tick_ns
        share = (time.process_time() - used) / seconds
        if child is not None:
            out, _ = await child.communicate(b"\n")
            counts = json.loads(out)
    return cycles, late, share, counts


def waiting(seconds: float) -> tuple[int, int]:
    """Bytes that wait for a page that never reads, and bytes that were put in."""
    send_queue = PageSendQueue()
    rows = 40
    payload = bytes(8 * rows * (CHANNELS + 1))
    blocks = round(seconds * 1000 / rows)
    for _ in range(blocks):
        send_queue.put_block(1, payload, CHANNELS + 1, rows)
    return send_queue.buffered_bytes, blocks * len(payload)


def main() -> None:
    """Measure and print."""
    if sys.argv[1:2] == ["--read"]:
        asyncio.run(readers(int(sys.argv[2]), int(sys.argv[3])))
        return
    if sys.argv[1:2] == ["--look"]:
        look(int(sys.argv[2]), int(sys.argv[3]), sys.argv[4])
        return
    numbers = [each for each in sys.argv[1:] if not each.startswith("--")]
    window = next((each[9:] for each in sys.argv if each.startswith("--window=")), "5")
    kind = "--look" if "--browsers" in sys.argv else "--read"
    seconds = float(numbers[0]) if numbers else 20.0
    pages = int(numbers[1]) if len(numbers) > 1 else 10
    for count in (0, pages, 0):
        with tempfile.TemporaryDirectory() as folder:
            cycles, late, share, counts = asyncio.run(
                measured(Path(folder), seconds, count, kind, window)
            )
        line = f"{count:3} pages  {cycles} cycles, {late} late ({late / max(cycles, 1):.3%})"
        line += f", {share:.1%} of a processor"
        if count and kind == "--look":
            line += f"; {counts}"
        elif count:
            line += f"; {counts[0]} blocks, {counts[1]} rows read, {counts[2]} blocks dropped"
        print(line, flush=True)
    waiting_bytes, put = waiting(3600.0)
    print(f"a page that does not read, 1 h of samples: {waiting_bytes:,} bytes wait of {put:,}")


if __name__ == "__main__":
    main()
