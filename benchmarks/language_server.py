"""Time from an edit to its findings in `achse lsp`, its processor time, and the server's memory.

A client of pygls types into a project over standard streams: faults into bodies and out again, and
other types into declarations. Without a folder the project is made up, of that many sources. Times
are those that an editor waits, the pause of the server (30 ms) included; `hovered` is without it.
Processor times are those of all threads of the server, where the system tells them.
DRAWN further edits of any kind are each compared with a cold check: all diagnostics of all files.
Usage: python benchmarks/language_server.py [SOURCES|FOLDER] [EDITS] [DRAWN]
"""

import asyncio
import random
import re
import statistics
import sys
import tempfile
import time
from collections.abc import Awaitable
from contextlib import suppress
from pathlib import Path

from lsprotocol import types
from pygls.lsp.client import LanguageClient

from achse.lsp.diagnostics import Published
from achse.lsp.editor import Editor
from achse.lsp.projects import Projects

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
_ANY_CODE = re.compile(r"<!\[CDATA\[(.*?)\]\]>", re.DOTALL)
_TYPE = re.compile(r":\s*(INT|DINT|BOOL|REAL)\b")
_WORD = re.compile(r"\b[A-Za-z]\w*\b")


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
        self._news, self._any = asyncio.Event(), asyncio.Event()
        self._uri = ""
        self.text = ""
        """Text of the document that was opened last."""
        self.shown: dict[str, list[types.Diagnostic]] = {}
        """Diagnostics of all files that have some."""

        @client.feature(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def published(params: types.PublishDiagnosticsParams) -> None:
            self.shown.pop(params.uri, None)
            if params.diagnostics:
                self.shown[params.uri] = list(params.diagnostics)
            self._any.set()
            if params.uri == self._uri:
                self._news.set()

    def open(self, file: Path) -> str:
        """Open a document; return its text."""
        self._uri, self.text = file.as_uri(), file.read_bytes().decode("utf-8-sig")
        item = types.TextDocumentItem(self._uri, "iecst", self._version, self.text)
        self._client.text_document_did_open(types.DidOpenTextDocumentParams(item))
        return self.text

    def close(self) -> None:
        """Close the document."""
        document = types.TextDocumentIdentifier(self._uri)
        self._client.text_document_did_close(types.DidCloseTextDocumentParams(document))

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
        self.text = self.text[:start] + new + self.text[end:]

    def _position(self, offset: int) -> types.Position:
        head = self.text[:offset]
        last = head.rpartition("\n")[2]
        return types.Position(head.count("\n"), len(last.encode("utf-16-le")) // 2)

    async def seen(self) -> None:
        """Wait until findings of the document come."""
        await asyncio.wait_for(self._news.wait(), 60)

    async def shows(self, expected: dict[str, list[types.Diagnostic]]) -> bool:
        """Return True once all files have these diagnostics; False if they have not after 10 s."""
        with suppress(TimeoutError):
            async with asyncio.timeout(10):
                while self.shown != expected:
                    self._any.clear()
                    await self._any.wait()
        return self.shown == expected

    async def hovered(self, offset: int = 0) -> None:
        """Wait for the answer about a place."""
        document = types.TextDocumentIdentifier(self._uri)
        params = types.HoverParams(document, self._position(offset))
        await self._client.text_document_hover_async(params)

    async def completed(self, offset: int) -> None:
        """Wait for the completions at a place."""
        document = types.TextDocumentIdentifier(self._uri)
        params = types.CompletionParams(document, self._position(offset))
        await self._client.text_document_completion_async(params)


class Stopwatch:
    """Times of one kind of request: for the client, and of the server's processor."""

    def __init__(self, server: int | None) -> None:
        self._server = server
        self._waited: dict[str, list[float]] = {}
        self._processor: dict[str, list[float]] = {}

    async def measure(self, name: str, work: Awaitable[None]) -> None:
        """Wait for some work."""
        start, used = time.perf_counter(), processor_seconds(self._server)
        await work
        self._waited.setdefault(name, []).append(time.perf_counter() - start)
        now = processor_seconds(self._server)
        self._processor.setdefault(name, []).append(now - used)

    def show(self) -> None:
        """Print the times of each kind of request."""
        for name, waited in self._waited.items():
            _row(name, waited, "ms waited")
            if any(self._processor[name]):
                _row("", self._processor[name], "ms processor")


def _row(name: str, seconds: list[float], unit: str) -> None:
    ordered = sorted(seconds)
    p95 = ordered[min(int(len(ordered) * 0.95), len(ordered) - 1)]
    middle = statistics.median(ordered)
    print(
        f"{name:<28} p50 {middle * 1e3:>7.1f}   p95 {p95 * 1e3:>7.1f}   max"
        f" {ordered[-1] * 1e3:>7.1f} {unit}   {len(ordered)} times"
    )


def processor_seconds(process: int | None) -> float:
    """Return the time that all threads of a process ran; 0 where the system does not tell."""
    total = 0
    for thread in Path(f"/proc/{process}/task").glob("*/schedstat"):
        with suppress(OSError):
            total += int(thread.read_text().split()[0])
    return total / 1e9


def _megabytes(process: int | None) -> float:
    """Return the memory of a process; 0 where the system does not tell."""
    with suppress(OSError):
        status = Path(f"/proc/{process}/status").read_text()
        return int(status.partition("VmRSS:")[2].split()[0]) / 1024
    return 0.0


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


_NEW = (
    "",
    ";",
    "x",
    "1",
    " + 1",
    "END_IF;",
    "(",
    "(*",
    "]]>",
    "\n",
    "VAR y : INT; END_VAR",
    "'ä",
    "😀",
)


def draw_edit(generator: random.Random, text: str) -> tuple[int, int, str]:
    """Draw an edit, mostly in the code: some characters for others, or a word for another."""
    words = list(_WORD.finditer(text))
    places = [match.span(1) for match in _ANY_CODE.finditer(text)]
    if words and generator.random() < 0.4:
        one, other = generator.choice(words), generator.choice(words)
        return one.start(), one.end(), other[0]
    first, last = generator.choice(places) if places else (0, len(text))
    start = generator.randint(first, last)
    end = min(start + generator.choice((0, 0, 1, 3, 40)), len(text))
    return start, end, generator.choice(_NEW)


def cold_diagnostics(root: Path, file: Path, text: str) -> dict[str, list[types.Diagnostic]]:
    """Return the diagnostics of a server that begins with this text in a file."""
    editor = Editor()
    editor.projects = Projects([root])
    editor.open(file.as_uri(), text, 1)
    editor.update()
    editor.projects.load()
    published = Published(editor).changes()
    return {params.uri: list(params.diagnostics) for params in published if params.diagnostics}


async def compare_drawn_edits(root: Path, typist: Typist, files: list[Path], count: int) -> int:
    """Draw edits, two in a row for each file; return after how many the server has other
    diagnostics than a cold one for 10 s."""
    generator = random.Random(7)
    differing = 0
    for _ in range(0, count, 2):
        file = generator.choice(files)
        typist.open(file)
        for _ in range(2):
            typist.replace(*draw_edit(generator, typist.text))
            await typist.hovered()
            expected = cold_diagnostics(root, file, typist.text)
            differing += not await typist.shows(expected)
        typist.close()
    return differing


async def measure(root: Path, edits: int, drawn: int) -> int:
    """Measure a project; return how many drawn edits differ from a cold check."""
    files = _bodies(root)
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
    waited, used = time.perf_counter() - start, processor_seconds(server)
    print(f"loaded and checked in {waited:.2f} s, processor {used:.2f} s")
    watch = Stopwatch(server)
    await _type(typist, watch, files, edits)
    watch.show()
    print(f"server: {_megabytes(server):.0f} MB after {edits} turns")
    differing = await compare_drawn_edits(root, typist, files, drawn)
    if drawn:
        print(f"{drawn} drawn edits, {differing} with other findings than a cold check")
        print(f"server: {_megabytes(server):.0f} MB after them")
    await client.shutdown_async(None)
    client.exit(None)
    await client.stop()  # type: ignore[no-untyped-call]
    return differing


async def _type(typist: Typist, watch: Stopwatch, files: list[Path], edits: int) -> None:
    generator = random.Random(31)
    for _ in range(edits):
        text = typist.open(generator.choice(files))
        code = generator.choice(list(_CODE.finditer(text)))
        await typist.hovered()
        start = code.start(1)
        fault = "\nnothing_here := 1;\n"
        for end, new in ((start, fault), (start + len(fault), "")):
            typist.replace(start, end, new)
            await watch.measure("edit of a body, until shown", typist.seen())
        for end, new in ((start, "(* more *)"), (start + 10, "")):
            typist.replace(start, end, new)
            await watch.measure("edit of a body, asked", typist.hovered())
        place = generator.randrange(start, code.end(1)) if code[1] else start
        await watch.measure("hover", typist.hovered(place))
        await watch.measure("completion", typist.completed(place))
        variables = list(_TYPE.finditer(text))
        if variables:
            one = generator.choice(variables)
            start, old = one.start(1), one[1]
            for end, new in ((one.end(1), "LINT"), (start + 4, old)):
                typist.replace(start, end, new)
                await watch.measure("edit of a declaration, asked", typist.hovered())


def main() -> int:
    """Measure a made-up project, or one of the user; 1 if drawn edits differ."""
    project = sys.argv[1] if len(sys.argv) > 1 else "800"
    edits = int(sys.argv[2]) if len(sys.argv) > 2 else 100
    drawn = int(sys.argv[3]) if len(sys.argv) > 3 else 0
    if not project.isdigit():
        return bool(asyncio.run(measure(Path(project).resolve(), edits, drawn)))
    with tempfile.TemporaryDirectory() as folder:
        write_project(Path(folder), int(project))
        print(f"{project} sources")
        return bool(asyncio.run(measure(Path(folder).resolve(), edits, drawn)))


if __name__ == "__main__":
    sys.exit(main())
