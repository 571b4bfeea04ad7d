"""`achse lsp` over public sources: a client of pygls types into them, and after each edit all files
have the findings of a check that begins with nothing.

The sources of the parser blark come from its package, by .ci/foreign-suites. TcUnit and TcoCore are
in no package registry: these tests run where ACHSE_TCUNIT or ACHSE_TCOCORE names the folder.
"""

import asyncio
import os
import random
import re
import shutil
import sys
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from pathlib import Path

import pytest
from lsprotocol import types
from pygls.lsp.client import LanguageClient

from achse.lsp.diagnostics import Published
from achse.lsp.editor import Editor
from achse.lsp.projects import Projects

BLARK = Path(__file__).parents[2] / ".foreign" / "pyads-3.6.0" / "blark"
_CODE = re.compile(r"<!\[CDATA\[(.*?)\]\]>", re.DOTALL)
_WORD = re.compile(r"\b[A-Za-z_]\w*\b")
_SOURCES = (".tcpou", ".tcdut", ".tcgvl", ".tcio", ".st")
_GUARD_S = 600
_NEW = ("", ";", " x", "nothing_here := 1;", "(*", "END_IF;", "\n", " : LINT;", "'ä😀")


def _named_by(variable: str) -> Path:
    folder = os.environ.get(variable)
    if not folder:
        pytest.skip(f"{variable} does not name the sources, which are in no package registry")
    return Path(folder)


def _of_blark() -> Path:
    if not BLARK.is_dir():
        absent = pytest.fail if os.environ.get("ACHSE_WITNESSES") == "required" else pytest.skip
        absent("the sources of blark are not on this machine; .ci/foreign-suites fetches them")
    return BLARK


SOURCES: dict[str, Callable[[], Path]] = {
    "blark": _of_blark,
    "TcUnit": lambda: _named_by("ACHSE_TCUNIT"),
    "TcoCore": lambda: _named_by("ACHSE_TCOCORE"),
}


@pytest.fixture(params=list(SOURCES))
def project(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """A copy of public sources."""
    place = SOURCES[request.param]()
    folder = place if place.is_dir() else place.parent
    return Path(shutil.copytree(folder, tmp_path / "project")).resolve()


class Typist:
    """A client that types into one document at a time, and what it is shown."""

    def __init__(self, client: LanguageClient) -> None:
        self.client = client
        self.text = ""
        self.shown: dict[str, list[types.Diagnostic]] = {}
        self._uri = ""
        self._version = 0
        self._news = asyncio.Event()

        @client.feature(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
        def published(params: types.PublishDiagnosticsParams) -> None:
            self.shown.pop(params.uri, None)
            if params.diagnostics:
                self.shown[params.uri] = list(params.diagnostics)
            self._news.set()

    def open(self, file: Path) -> None:
        """Open a document."""
        self._uri, self.text = file.as_uri(), file.read_bytes().decode("utf-8-sig")
        self._version += 1
        item = types.TextDocumentItem(self._uri, "iecst", self._version, self.text)
        self.client.text_document_did_open(types.DidOpenTextDocumentParams(item))

    def close(self) -> None:
        """Close the document."""
        document = types.TextDocumentIdentifier(self._uri)
        self.client.text_document_did_close(types.DidCloseTextDocumentParams(document))

    def replace(self, start: int, end: int, new: str) -> None:
        """Replace some characters."""
        self._version += 1
        place = types.Range(self.position(start), self.position(end))
        self.client.text_document_did_change(
            types.DidChangeTextDocumentParams(
                types.VersionedTextDocumentIdentifier(self._version, self._uri),
                [types.TextDocumentContentChangePartial(place, new)],
            )
        )
        self.text = self.text[:start] + new + self.text[end:]

    def position(self, offset: int) -> types.Position:
        """Return an offset in lines and units of UTF-16."""
        head = self.text[:offset]
        last = head.rpartition("\n")[2]
        return types.Position(head.count("\n"), len(last.encode("utf-16-le")) // 2)

    async def sees(self, expected: dict[str, list[types.Diagnostic]]) -> bool:
        """Wait until all files have these diagnostics."""
        with suppress(TimeoutError):
            async with asyncio.timeout(_GUARD_S):
                while self.shown != expected:
                    self._news.clear()
                    await self._news.wait()
        return self.shown == expected


@asynccontextmanager
async def _typist(project: Path) -> AsyncIterator[Typist]:
    client = LanguageClient("typist", "1")
    typist = Typist(client)
    await client.start_io(sys.executable, "-m", "achse", "lsp")
    folders = [types.WorkspaceFolder(project.as_uri(), "project")]
    await client.initialize_async(
        types.InitializeParams(types.ClientCapabilities(), workspace_folders=folders)
    )
    client.initialized(types.InitializedParams())
    try:
        yield typist
    finally:
        await client.shutdown_async(None)
        client.exit(None)
        await client.stop()  # type: ignore[no-untyped-call]


def _files(project: Path) -> list[Path]:
    return sorted(file for file in project.rglob("*") if file.suffix.lower() in _SOURCES)


def _cold(project: Path, file: Path, text: str) -> dict[str, list[types.Diagnostic]]:
    """Return the diagnostics of a server that begins with this text in a file."""
    editor = Editor()
    editor.projects = Projects([project])
    editor.open(file.as_uri(), text, 1)
    editor.update()
    editor.projects.load()
    changes = Published(editor).changes()
    return {params.uri: list(params.diagnostics) for params in changes if params.diagnostics}


def _draw(text: str, draw: random.Random) -> tuple[int, int, str]:
    """Draw a word for another, or some characters for others, in the code."""
    code = [match.span(1) for match in _CODE.finditer(text)] or [(0, len(text))]
    first, last = draw.choice(code)
    words = list(_WORD.finditer(text, first, last))
    if words and draw.random() < 0.6:
        return *draw.choice(words).span(), draw.choice(words)[0]
    start = draw.randint(first, last)
    return start, min(start + draw.choice((0, 1, 8)), last), draw.choice(_NEW)


async def test_drawn_edits_have_the_findings_of_a_cold_check(
    project: Path, many: Callable[[int], int]
) -> None:
    draw = random.Random(31)
    async with _typist(project) as typist:
        for _ in range(many(6)):
            file = draw.choice(_files(project))
            typist.open(file)
            for _ in range(2):
                typist.replace(*_draw(typist.text, draw))
                expected = _cold(project, file, typist.text)
                assert await typist.sees(expected), (file, typist.text)
            typist.close()


async def test_a_name_is_among_the_references_to_what_it_means(project: Path) -> None:
    async with _typist(project) as typist:
        client, count = typist.client, 0
        for file in _files(project)[:3]:
            typist.open(file)
            document = types.TextDocumentIdentifier(file.as_uri())
            for word in list(_WORD.finditer(typist.text))[:60:3]:
                place = typist.position(word.start())
                params = types.DefinitionParams(document, place)
                if not await client.text_document_definition_async(params):
                    continue
                count += 1
                references = await client.text_document_references_async(
                    types.ReferenceParams(types.ReferenceContext(True), document, place)
                )
                places = {(one.uri, one.range.start.line) for one in references or ()}
                assert (file.as_uri(), place.line) in places, word[0]
            typist.close()
        assert count
