"""Tools over the sources of a project: check, explain, find, read, edit, test."""

from pathlib import Path
from typing import Annotated, Any

from anyio import Lock, from_thread, to_thread
from mcp.server.mcpserver import Context
from pydantic import Field

from achse.iec.nearest import did_you_mean
from achse.mcp.code import CodeError, edit_file, find_symbols, read_unit
from achse.mcp.folder import ProjectFolder
from achse.mcp.results import (
    CheckReport,
    CodeExcerpt,
    CodeExplanation,
    EditReport,
    SymbolMatches,
    TestReport,
)
from achse.mcp.testing import unit_test_report
from achse.mcp.workspaces import WarmProjects
from achse.st.explanations.explanation import explanation_of
from achse.st.lexis.codes import Code

_MOST_TEXT = 20_000

ProjectPath = Annotated[
    str,
    Field(description="Folder of sources, .plcproj, source file or station.toml."),
]
_Limit = Annotated[int, Field(ge=1, le=500)]
_Text = Annotated[str, Field(max_length=_MOST_TEXT)]


class SourceTools:
    """Tools over the projects of a folder; one call at a time."""

    def __init__(self, folder: ProjectFolder) -> None:
        self._folder = folder
        self._projects = WarmProjects(folder)
        self._lock = Lock()

    async def check(self, project: ProjectPath = ".", limit: _Limit = 50) -> CheckReport:
        """Check a PLC project as its files are now: errors first, each with code and place."""
        async with self._lock:
            return await to_thread.run_sync(self._projects.check, project, limit)

    async def explain(self, code: Annotated[str, Field(max_length=20)]) -> CodeExplanation:
        """Explain the code of a finding (ST4101): its meaning, remedy, an example wrong and
        right."""
        try:
            explanation = explanation_of(Code(code.strip().upper()))
        except ValueError:
            near = did_you_mean(code, map(str, Code))
            raise CodeError(
                f"expected the code of a finding, like ST4101, got {code!r:.40}{near}"
            ) from None
        return CodeExplanation(
            code=str(explanation.code),
            title=explanation.title,
            meaning=explanation.meaning,
            remedy=explanation.remedy,
            wrong=dict(explanation.wrong),
            right=dict(explanation.right),
        )

    async def find_symbols(
        self,
        pattern: Annotated[str, Field(max_length=200)],
        project: ProjectPath = ".",
        limit: _Limit = 50,
    ) -> SymbolMatches:
        """Find units, parts, variables and types by a piece of their name, without case."""
        async with self._lock:
            return await to_thread.run_sync(self._find, project, pattern, limit)

    def _find(self, project: str, pattern: str, limit: int) -> SymbolMatches:
        return find_symbols(self._projects.of(project), self._folder, pattern, limit)

    async def read_code(
        self, name: Annotated[str, Field(max_length=500)], project: ProjectPath = "."
    ) -> CodeExcerpt:
        """Read the code of a unit (FB_Press) or of a part of it (FB_Press.Close)."""
        async with self._lock:
            return await to_thread.run_sync(self._read, project, name)

    def _read(self, project: str, name: str) -> CodeExcerpt:
        return read_unit(self._projects.of(project), self._folder, name, _MOST_TEXT)

    async def edit_code(
        self, file: str, old: _Text, new: _Text, project: ProjectPath = ".", limit: _Limit = 20
    ) -> EditReport:
        """Replace a text that is in the code of a source file once, and check the project."""
        async with self._lock:
            return await to_thread.run_sync(self._edit, project, file, old, new, limit)

    def _edit(self, project: str, file: str, old: str, new: str, limit: int) -> EditReport:
        workspace = self._projects.of(project)
        path, line = edit_file(workspace, self._folder, file, old, new)
        report = self._projects.check(project, limit)
        return EditReport(file=self._folder.name(path), line=line, check=report)

    async def test(
        self,
        ctx: Context[Any],
        project: ProjectPath = ".",
        all_tests: bool = False,
        limit_s: Annotated[float, Field(gt=0, le=3600)] = 60.0,
    ) -> TestReport:
        """Run the TcUnit tests of a project in virtual time, at most limit_s of PLC time; lists
        the tests that did not pass, or all."""
        path: Path = self._folder.path(project)

        def report(plc_time: float) -> None:
            from_thread.check_cancelled()
            from_thread.run(ctx.report_progress, plc_time, limit_s)

        def work() -> TestReport:
            return unit_test_report(
                self._folder,
                path,
                limit=limit_s,
                timeout=60.0,
                most=200,
                everything=all_tests,
                report=report,
            )

        return await to_thread.run_sync(work)
