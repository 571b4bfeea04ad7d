"""Time from an edit to its findings in `achse lsp`, and the memory of the server.

A client of pygls types into a project over standard streams: faults into bodies and out again, and
other types into declarations. Without a folder the project is made up, of that many sources. Times
are those that an editor waits, the pause of the server (30 ms) included; `asked` is without it.
Usage: python benchmarks/language_server.py [SOURCES|FOLDER] [EDITS]
"""

import asyncio
import random
import re
import statistics
import sys
import tempfile
import time
from pathlib import Path

from lsprotocol import types
from pygls.lsp.client import LanguageClient

BLOCK = """\
<TcPlcObject><POU Name="FB_Valve{n}"><Declaration><![CDATA[
FUNCTION_BLOCK FB_Valve{n}{base}
VAR_INPUT
    bOpen{n} : BOOL; // command
    tTimeout{n} : TIME := T#2S;
END_VAR
VAR_OUTPUT
    bDone{n} : BOOL;
END_VAR
VAR
    fbTimer{n} : TON;
    eState{n} : E_State;
    stSample{n} : ST_Sample;
    nSteps{n} : INT;
END_VAR]]></Declaration><Implementation><ST><![CDATA[
fbTimer{n}(IN := bOpen{n}, PT := tTimeout{n});
CASE eState{n} OF
    E_State.Idle: eState{n} := E_State.Moving;
    E_State.Moving: bDone{n} := fbTimer{n}.Q;
END_CASE
nSteps{n} := nSteps{n} + Travel(nLimit := GVL.nLimit);
]]></ST></Implementation>
<Method Name="Travel"><Declaration><![CDATA[METHOD PUBLIC Travel : INT
VAR_INPUT
    nLimit : INT;
END_VAR]]></Declaration><Implementation><ST><![CDATA[
stSample{n}.fValue := INT_TO_LREAL(nSteps{n});
Travel := MIN(nSteps{n}, nLimit);
]]></ST></Implementation></Method>
</POU></TcPlcObject>
"""
SHARED = {
    "Types.st": "TYPE E_State : (Idle, Moving); END_TYPE\n"
    "TYPE ST_Sample : STRUCT fValue : LREAL; END_STRUCT END_TYPE\n",
    "GVL.st": "VAR_GLOBAL\n    nLimit : INT := 5;\nEND_VAR\n",
}
_CODE = re.compile(r"<ST><!\[CDATA\[(.*?)\]\]></ST>", re.DOTALL)
_TYPE = re.compile(r":\s*(INT|DINT|BOOL|REAL)\b")


def write_project(folder: Path, count: int) -> None:
    """Write a project of blocks, each derived from the one before the tens."""
    for name, text in SHARED.items():
        (folder / name).write_text(text)
    for number in range(count - len(SHARED)):
        base = "" if number % 10 == 0 else f" EXTENDS FB_Valve{number - number % 10}"
        text = BLOCK.format(n=number, base=base)
        (folder / f"FB_Valve{number}.TcPOU").write_text(text)


class Typist:
    """A client that types into documents, and waits for what it sees."""

    def __init__(self, client: LanguageClient) -> None:
        self._client = client
        self._version = 1
        self._news = asyncio.Event()
        self._text = ""
        self._uri = ""

        @client.feature(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def published(params: types.PublishDiagnosticsParams) -> None:
            if params.uri == self._uri:
                self._news.set()

    def open(self, file: Path) -> str:
        """Open a document; return its text."""
        self._uri, self._text = file.as_uri(), file.read_text("utf-8-sig")
        item = types.TextDocumentItem(self._uri, "iecst", self._version, self._text)
        self._client.text_document_did_open(types.DidOpenTextDocumentParams(item))
        return self._text

    def replace(self, start: int, end: int, new: str) -> None:
        """Replace some characters."""
        self._version += 1
        self._news.clear()
        place = types.Range(self._position(start), self._position(end))
        self._client.text_document_did_change(
            types.DidChangeTextDocumentParams(
                types.VersionedTextDocumentIdentifier(self._version, self._uri),
                [types.TextDocumentContentChangePartial(place, new)],
            )
        )
        self._text = self._text[:start] + new + self._text[end:]

    def _position(self, offset: int) -> types.Position:
        head = self._text[:offset]
        last = head.rpartition("\n")[2]
        return types.Position(head.count("\n"), len(last.encode("utf-16-le")) // 2)

    async def seen(self) -> float:
        """Return the time until findings of the document come."""
        start = time.perf_counter()
        await asyncio.wait_for(self._news.wait(), 60)
        return time.perf_counter() - start

    async def asked(self, offset: int = 0) -> float:
        """Return the time until the answer about a place comes."""
        start = time.perf_counter()
        document = types.TextDocumentIdentifier(self._uri)
        params = types.HoverParams(document, self._position(offset))
        await self._client.text_document_hover_async(params)
        return time.perf_counter() - start

    async def completed(self, offset: int) -> float:
        """Return the time until the completions at a place come."""
        start = time.perf_counter()
        document = types.TextDocumentIdentifier(self._uri)
        params = types.CompletionParams(document, self._position(offset))
        await self._client.text_document_completion_async(params)
        return time.perf_counter() - start


def _row(name: str, seconds: list[float]) -> None:
    if seconds:
        ordered = sorted(seconds)
        p95 = ordered[min(int(len(ordered) * 0.95), len(ordered) - 1)]
        middle = statistics.median(ordered)
        print(
            f"{name:<34} p50 {middle * 1e3:>7.1f} ms   p95 {p95 * 1e3:>7.1f} ms"
            f"   max {ordered[-1] * 1e3:>7.1f} ms   {len(ordered)} times"
        )


def _bodies(root: Path) -> list[Path]:
    files = sorted(root.rglob("*.TcPOU"))
    return [file for file in files if _CODE.search(file.read_text("utf-8-sig"))]


def _usage(process: int | None) -> tuple[float, float]:
    """CPU seconds and megabytes of a process; zeros where the system does not tell."""
    try:
        status = Path(f"/proc/{process}/status").read_text()
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0, 0.0
    size = int(status.partition("VmRSS:")[2].split()[0]) / 1024
    return (int(fields[11]) + int(fields[12])) / 100, size


async def _measure(root: Path, files: list[Path], edits: int) -> None:
    client = LanguageClient("typist", "1")
    typist = Typist(client)
    start = time.perf_counter()
    await client.start_io(sys.executable, "-m", "achse", "lsp")
    server = client._server.pid if client._server is not None else None
    folders = [types.WorkspaceFolder(root.as_uri(), "project")]
    await client.initialize_async(
        types.InitializeParams(types.ClientCapabilities(), workspace_folders=folders)
    )
    client.initialized(types.InitializedParams())
    await client.workspace_symbol_async(types.WorkspaceSymbolParams("zzzz"))
    used, _ = _usage(server)
    print(f"loaded and checked in {time.perf_counter() - start:.2f} s, processor {used:.2f} s")
    generator = random.Random(31)
    shown, body, declared, hovered, completed = [], [], [], [], []
    spent = 0.0
    for _ in range(edits):
        text = typist.open(generator.choice(files))
        code = generator.choice(list(_CODE.finditer(text)))
        await typist.asked()
        fault = "\nnothing_here := 1;\n"
        typist.replace(code.start(1), code.start(1), fault)
        shown.append(await typist.seen())
        typist.replace(code.start(1), code.start(1) + len(fault), "")
        shown.append(await typist.seen())
        typist.replace(code.start(1), code.start(1), "(* more *)")
        body.append(await typist.asked())
        typist.replace(code.start(1), code.start(1) + 10, "")
        body.append(await typist.asked())
        place = generator.randrange(code.start(1), code.end(1)) if code[1] else code.start(1)
        hovered.append(await typist.asked(place))
        completed.append(await typist.completed(place))
        found = list(_TYPE.finditer(text))
        if found:
            one = generator.choice(found)
            before, _ = _usage(server)
            typist.replace(one.start(1), one.end(1), "LINT")
            declared.append(await typist.asked())
            typist.replace(one.start(1), one.start(1) + 4, one[1])
            declared.append(await typist.asked())
            spent += _usage(server)[0] - before
    _row("edit of a body, until shown", shown)
    _row("edit of a body, asked", body)
    _row("edit of a declaration, asked", declared)
    if declared:
        print(f"{'  of it processor':<34} mean {spent / len(declared) * 1e3:>6.1f} ms")
    _row("hover", hovered)
    _row("completion", completed)
    now, size = _usage(server)
    print(f"server: {size:.0f} MB, processor {now - used:.2f} s for all of it")
    await client.shutdown_async(None)
    client.exit(None)
    await client.stop()


def main() -> None:
    """Measure a made-up project, or one of the user."""
    given = sys.argv[1] if len(sys.argv) > 1 else "800"
    edits = int(sys.argv[2]) if len(sys.argv) > 2 else 100
    if not given.isdigit():
        root = Path(given).resolve()
        asyncio.run(_measure(root, _bodies(root), edits))
        return
    with tempfile.TemporaryDirectory() as folder:
        write_project(Path(folder), int(given))
        print(f"{given} sources")
        root = Path(folder)
        asyncio.run(_measure(root, _bodies(root), edits))


if __name__ == "__main__":
    main()
