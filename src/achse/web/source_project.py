"""One project whose sources pages edit: files, drafts, findings. Loaded with the first call."""

import hashlib
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from achse.codes.links import SITE, finding_link, on_site
from achse.plc.system_info import lists_of_runtime
from achse.st.files.files import source_files
from achse.st.files.forms import Content, has_content
from achse.st.files.sections import (
    CodeSection,
    SectionError,
    edited,
    replace_source,
    sections_of,
)
from achse.st.lexis.source import Diagnostic, SourceError
from achse.st.workspace import Workspace
from achse.web.drawings import DrawnBody, drawn_bodies
from achse.web.messages import CallError
from achse.web.settings import EditedProject

_EDITABLE = (Content.TEXT, Content.ENVELOPE)
"""Contents of the files whose code can be edited."""

MOST_FINDINGS = 200
"""Findings that a page is sent at most; the rest is counted."""

_LARGEST = 1 << 20
"""Bytes of a file that can be edited, at most."""


class SourceProject:
    """The sources of one project, as pages edit them.

    A text that a page is typing is a draft: it is checked as if it were saved. There is one at a
    time: a check of another file, or a page that opens one, gets nothing of it. Not for two
    threads at once.
    """

    def __init__(self, project: EditedProject) -> None:
        self._path = project.path
        self._workspace = Workspace(
            project.path, libraries=project.libraries, predefined=lists_of_runtime
        )
        self._draft: Path | None = None
        self._names: dict[Path, str] = {}
        """Names of the project's sources at the last look."""
        self._stamps: dict[Path, tuple[int, int]] | None = None
        self._look()

    def _look(self) -> None:
        """Take what other programs did to the files: came, went, changed."""
        try:
            names = dict(source_files(self._path))
        except SourceError:
            names = {}  # the findings tell why
        stamps = {file: _stamp(file) for file in names}
        before, self._names = self._stamps, names
        self._stamps = stamps
        if before is None:
            return
        if stamps.keys() != before.keys():
            self._workspace.relist()
        for file in names:
            if stamps[file] != before.get(file, stamps[file]):
                self._workspace.reread(file)

    def _files(self) -> Iterator[tuple[Path, str]]:
        """Files whose code can be edited, with their names in the project."""
        for file, name in self._names.items():
            if self._may_edit(file):
                yield file, name

    def _may_edit(self, file: Path) -> bool:
        return has_content(file, *_EDITABLE) and not self._leads_away(file)

    def _leads_away(self, file: Path) -> bool:
        """Return True for a file that a link takes out of the folder of the project."""
        real = Path(os.path.realpath(file))
        folder = self._path if self._path.is_dir() else self._path.parent
        return str(real) != os.path.abspath(file) and not real.is_relative_to(
            os.path.realpath(folder)
        )

    def _file(self, name: str) -> Path:
        for file, name_of_file in self._names.items():
            if name_of_file == name and self._may_edit(file):
                return file
        raise CallError(f"file: expected a source of the project, got {name!r:.80}")

    def files(self) -> list[dict[str, Any]]:
        """Files that can be edited, each with the number of its errors."""
        self._look()
        errors: dict[Path, int] = {}
        for finding in self._workspace.findings.errors:
            file = self._workspace.file_of(finding)
            errors[file] = errors.get(file, 0) + 1
        return [{"file": name, "errors": errors.get(file, 0)} for file, name in self._files()]

    def read(self, name: str) -> dict[str, Any]:
        """Return the code of a file as it is on disk; a draft of it is dropped."""
        self._look()
        file = self._file(name)
        content = _content(file, name)
        sections = _sections(content, file, name)
        self._on_disk(file)
        return {
            "tag": _tag(content),
            "sections": [{"name": s.name, "kind": s.kind, "text": s.text} for s in sections],
            "findings": self.findings(),
            "is_drawn": bool(self.drawn(name)),
        }

    def drawn(self, name: str, instance: str = "") -> list[DrawnBody]:
        """Return the drawn bodies of a file, with values of a block or of its program."""
        source = self._workspace.source_of(self._file(name))
        units = (one.units for one in self._workspace.sources if one.source is source)
        return drawn_bodies(next(units, ()), instance)

    def check(self, name: str, texts: Sequence[str], tag: str = "") -> dict[str, Any]:
        """Return the findings with other code in a file, which becomes its draft; `is_changed` if
        others wrote the file since `tag` was reported."""
        file = self._file(name)
        content = _content(file, name)
        draft = _edited(content, texts, file, name)
        if self._draft != file:
            self._drop_draft()
        self._draft = file
        self._workspace.edit(file, draft)
        return {**self.findings(), "is_changed": bool(tag) and tag != _tag(content)}

    def save(self, name: str, texts: Sequence[str], tag: str) -> dict[str, Any]:
        """Write the code of a file, if no other program wrote it since `tag` was reported."""
        file = self._file(name)
        content = _content(file, name)
        if _tag(content) != tag:
            raise CallError(f"{name} was written by another program meanwhile: read it again")
        saved = _edited(content, texts, file, name)
        try:
            replace_source(file, saved)
        except OSError as failure:
            raise CallError(f"{name}: cannot be written: {failure.strerror}") from None
        self._on_disk(file)
        return {"tag": _tag(saved), "findings": self.findings()}

    def _drop_draft(self) -> None:
        if self._draft is not None:
            self._workspace.close(self._draft)
        self._draft = None

    def _on_disk(self, file: Path) -> None:
        """Check the project as it is on disk, and read a file of it again."""
        self._drop_draft()
        self._workspace.reread(file)

    def findings(self) -> dict[str, Any]:
        """Return the findings of the project: their number by kind, and the first of them as
        rows."""
        findings = self._workspace.findings
        sections: dict[Path, tuple[CodeSection, ...]] = {}
        rows: list[dict[str, Any]] = []
        kinds = {
            "error": findings.errors,
            "warning": findings.warnings,
            "unreached": findings.unreached,
        }
        every = ((kind, finding) for kind, several in kinds.items() for finding in several)
        for kind, finding in every:
            if len(rows) == MOST_FINDINGS:
                break
            file = self._workspace.file_of(finding)
            if file not in sections:
                sections[file] = self._sections_now(file)
            place = _place(finding, sections[file])
            link = on_site(finding_link(finding.code.value), os.environ.get(SITE))
            rows.append(
                {
                    "kind": kind,
                    "code": finding.code.value,
                    "text": finding.message,
                    "file": self._names.get(file, file.name),
                    **place,
                    "link": link,
                }
            )
        return {"counts": {kind: len(several) for kind, several in kinds.items()}, "rows": rows}

    def _sections_now(self, file: Path) -> tuple[CodeSection, ...]:
        """Sections of a file or its draft; none if it has no code that can be edited."""
        if not has_content(file, *_EDITABLE):
            return ()
        draft = self._workspace.text_of(file)
        try:
            content = _content(file, file.name) if draft is None else draft
            return _sections(content, file, file.name)
        except CallError:
            return ()


def _place(finding: Diagnostic, sections: Sequence[CodeSection]) -> dict[str, int | None]:
    """Section, line and column of a finding, the latter within the section; no section: None."""
    line, column = finding.location.line, finding.location.column
    number = None
    for index, section in enumerate(sections):
        if (section.line, section.column) <= (line, column):
            number = index
    if number is not None:
        section = sections[number]
        column -= section.column - 1 if line == section.line else 0
        line -= section.line - 1
    return {"section": number, "line": line, "column": column}


def _stamp(file: Path) -> tuple[int, int]:
    try:
        status = file.stat()
    except OSError:
        return 0, 0
    return status.st_mtime_ns, status.st_size


def _content(file: Path, name: str) -> bytes:
    try:
        if file.stat().st_size > _LARGEST:
            raise CallError(f"{name}: expected up to {_LARGEST} bytes")
        return file.read_bytes()
    except OSError as failure:
        raise CallError(f"{name}: {failure.strerror}") from None


def _sections(content: bytes, file: Path, name: str) -> tuple[CodeSection, ...]:
    try:
        return sections_of(content, is_xml=has_content(file, Content.ENVELOPE))
    except SectionError as failure:
        raise CallError(f"{name}: {failure}") from None


def _edited(content: bytes, texts: Sequence[str], file: Path, name: str) -> bytes:
    try:
        return edited(content, texts, is_xml=has_content(file, Content.ENVELOPE))
    except SectionError as failure:
        raise CallError(f"{name}: {failure}") from None


def _tag(content: bytes) -> str:
    return hashlib.blake2b(content, digest_size=12).hexdigest()
