"""The workspace: a project that is checked once, and after each edit as far as the edit reaches.

Files that did not change are not parsed again. A file that is added or taken away is an edit of
its declarations. All files are read again if a task or a library changes, or a `.plcproj` apart
from its files.
"""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from enum import Enum
from pathlib import Path
from typing import Any
from weakref import WeakValueDictionary

from achse.iec.structs import StaticRecord
from achse.st.files.envelope import TaskDeclaration
from achse.st.files.files import LIBRARY_TYPES, SOURCES, parse_file, source_files
from achse.st.files.forms import Content, has_content, suffixes_of
from achse.st.files.reading import file_key, reading
from achse.st.lexis.lexer import Defines
from achse.st.lexis.pragmas import needs_declarations
from achse.st.lexis.source import Diagnostic, Source, SourceError
from achse.st.lint.options import FILE, LintOptions, LintOptionsError
from achse.st.project import read_files
from achse.st.syntax.parser import Parsed
from achse.st.workspace.checked import CheckedProject, PredefinedLists
from achse.st.workspace.edits import emptied, is_on_disk, project_options
from achse.st.workspace.findings import sorted_findings

_BESIDE = (LIBRARY_TYPES, *suffixes_of(Content.PROJECT, Content.SYSTEM, Content.SOLUTION))
"""Endings of further files that say something about a project."""

_MOST_FILES = 16
"""Files that come, go or change at once; of more the project is read again."""

LintRules = Callable[[Path], LintOptions]


class Extent(Enum):
    """Parts of a project that an edit makes the workspace check."""

    NOTHING = "nothing"
    BODIES = "bodies"
    DECLARATIONS = "declarations"
    """Units with changed declarations, and those that name them."""
    PROJECT = "project"
    FILES = "files"
    """The project, after its files were read again."""


def _no_predefined(tasks: Sequence[TaskDeclaration]) -> Iterable[type[StaticRecord]]:
    return ()


class Workspace(CheckedProject):
    """A project in memory. `findings` are those that a check of the same texts would have.

    `predefined` returns the variable lists that a runtime declares for the tasks of a project.
    `lint_rules` returns the rules of the linter that are on, without it there are none.
    """

    def __init__(
        self,
        path: str | Path,
        *,
        libraries: Iterable[str | Path] = (),
        defines: Defines = (),
        predefined: PredefinedLists = _no_predefined,
        check_all: bool = False,
        lint_rules: LintRules | None = None,
        open_files: Mapping[Path, bytes] | None = None,
    ) -> None:
        super().__init__(predefined, check_all=check_all)
        self.path = Path(path)
        self.libraries = tuple(Path(item) for item in libraries)
        self._defines = defines
        self._contents = {file_key(file): text for file, text in (open_files or {}).items()}
        """Texts of files that are open, by `file_key`."""
        self._trees: WeakValueDictionary[tuple[object, ...], Any] = WeakValueDictionary()
        self._listed: frozenset[str] = frozenset()
        """Files of the project by `file_key`, those that cannot be read too."""
        self._named_files: dict[str, Path] = {}
        self._options = b""
        """Content of the `.plcproj` apart from the files that it names."""
        self._is_listing = False
        """True if a `.plcproj` says what is in the project."""
        self._asking = False
        """True if conditions in sources ask for declarations of others."""
        self._lint_rules = lint_rules
        self.lint_failure = ""
        """Fault in achse.toml, which switches all rules off."""
        self.load()

    # files -----------------------------------------------------------------------------------

    def load(self) -> None:
        """Read all files and check everything."""
        self._read_lint_options()
        try:
            with reading(self._contents, self._trees):
                self._files = read_files(self.path, libraries=self.libraries, defines=self._defines)
        except SourceError as error:
            self._named_files, self._uses = {}, {}
            self._files, self.declarations, self.checking = None, None, None
            self._sources, self._listed = {}, frozenset()
            self.findings = sorted_findings(error.faults, (), ())
            return
        self._sources = {file_key(Path(one.source.file)): one for one in self._files.sources}
        self._named_files = {name: file for file, name in source_files(self.path)}
        self._listed = frozenset(map(file_key, self._named_files.values()))
        self._options = project_options(self.path)
        self._is_listing = bool(self._options)
        self._asking = any(needs_declarations(one.source.text) for one in self.sources)
        self._examine()

    def source_of(self, file: Path) -> Source | None:
        """Return the source of a file of the project or of its libraries; None of others, and of
        files that cannot be read."""
        key = file_key(file)
        own = self._sources.get(key)
        if own is not None:
            return own.source
        for parsed in self.all_sources:
            if parsed.source.file and file_key(Path(parsed.source.file)) == key:
                return parsed.source
        return None

    def file_of(self, finding: Diagnostic) -> Path:
        """Return the file that a finding is in; the project for one that names no file of it."""
        if finding.origin is not None and finding.origin.source.file:
            return Path(finding.origin.source.file)
        return self._named_files.get(finding.location.path, self.path)

    def has(self, file: Path) -> bool:
        """Return True if a file is a source of the project or of its libraries."""
        return file_key(file) in self._listed or self.source_of(file) is not None

    def text_of(self, file: Path) -> bytes | None:
        """Return the content of a file that is open; None of one that is not."""
        return self._contents.get(file_key(file))

    def _read_lint_options(self) -> None:
        if self._lint_rules is None:
            return
        try:
            self.lint_options, self.lint_failure = self._lint_rules(self.path), ""
        except LintOptionsError as failure:
            self.lint_options, self.lint_failure = LintOptions(), str(failure)

    # edits -----------------------------------------------------------------------------------

    def edit(self, file: Path, content: bytes) -> Extent:
        """Take the content of a file that an editor has, saved or not."""
        key = file_key(file)
        if self._contents.get(key) == content:
            return Extent.NOTHING
        self._contents[key] = content
        return self._changed(key, file)

    def edit_all(self, contents: Mapping[Path, bytes]) -> None:
        """Take the contents of several files."""
        changed = {f: new for f, new in contents.items() if self.text_of(f) != new}
        if self._are_many(file for file, new in changed.items() if not is_on_disk(file, new)):
            self._contents |= {file_key(file): new for file, new in changed.items()}
            self.load()
            return
        for file, new in changed.items():
            self.edit(file, new)

    def _are_many(self, files: Iterable[Path]) -> bool:
        """Return True if reading the project again takes less."""
        return sum(map(self.has, files)) > _MOST_FILES

    def close(self, file: Path) -> Extent:
        """Go back to the content that a file has on disk."""
        key = file_key(file)
        if self._contents.pop(key, None) is None:
            return Extent.NOTHING
        return self._changed(key, file)

    def reread(self, file: Path) -> Extent:
        """Look at a file that may have changed on disk, have come or gone."""
        key = file_key(file)
        if key in self._sources and not file.is_file():
            return self._lose()
        is_open = key in self._contents and key in self._sources
        return Extent.NOTHING if is_open else self._changed(key, file)

    def reread_all(self, files: Collection[Path]) -> None:
        """Look at several files that may have changed on disk, have come or gone."""
        if self._are_many(files):
            self.load()
            return
        for file in files:
            self.reread(file)

    def relist(self) -> Extent:
        """Look for files that came and went."""
        try:
            listed = {file_key(file): (file, name) for file, name in source_files(self.path)}
            if self._options != project_options(self.path):
                return self._load_again()
        except SourceError:
            return self._load_again()
        came = [key for key in listed if key not in self._listed]
        gone = [key for key in self._listed if key not in listed]
        if not came and not gone:
            return Extent.NOTHING
        if len(came) + len(gone) > _MOST_FILES or not self._may_take(came, gone):
            return self._load_again()
        parsed: dict[str, Parsed] = {}
        try:
            with reading(self._contents, self._trees):
                for key in came:
                    file, name = listed[key]
                    parsed[key] = parse_file(file, name, defines=self._defines)
        except SourceError:
            return self._load_again()
        if any(needs_declarations(one.source.text) for one in parsed.values()):
            return self._load_again()
        self._listed = frozenset(listed)
        self._named_files = {name: file for file, name in listed.values()}
        every = {**self._sources, **parsed}
        is_exact = True
        for key in gone:
            known = self._sources.pop(key)
            is_exact = is_exact and self._edit_units(known, emptied(known))
        for key, one in parsed.items():
            present = {*self._sources, key}
            self._sources = {each: every[each] for each in listed if each in present}
            is_exact = is_exact and self._edit_units(emptied(one), one)
        if not is_exact:
            self._examine()
            return Extent.PROJECT
        return Extent.DECLARATIONS

    def _may_take(self, came: Iterable[str], gone: Iterable[str]) -> bool:
        """Return True if files that came and went are sources, on which nothing else depends."""
        if self._files is None or self._files.events or self._asking:
            return False
        is_code = all(has_content(Path(key), Content.TEXT, Content.ENVELOPE) for key in came)
        return is_code and all(key in self._sources for key in gone)

    def _lose(self) -> Extent:
        """Look for files of which one is not there any more, though it may be listed."""
        extent = self.relist()
        return self._load_again() if extent is Extent.NOTHING else extent

    def _load_again(self) -> Extent:
        self.load()
        return Extent.FILES

    def _edit_units(self, known: Parsed, edited: Parsed, *, is_whole: bool = False) -> bool:
        """Take other units of a file, which the project's sources have; False if everything is to
        be checked. With `is_whole` the trees that are known may be those of the new version."""
        self._take_sources()
        return self._edit_declarations(known, edited, is_whole)

    def _changed(self, key: str, file: Path) -> Extent:
        known = self._sources.get(key)
        if known is None or self._files is None:
            if not self._may_read(key, file):
                return Extent.NOTHING
            is_code = has_content(file, Content.TEXT, Content.ENVELOPE, Content.PROJECT)
            if self._files is None or not is_code or key in self._listed:
                return self._load_again()
            in_library = self.has(file) or any(
                Path(key).is_relative_to(file_key(folder)) for folder in self.libraries
            )
            return self._load_again() if in_library else self.relist()
        if not file.is_file():
            return self._lose()
        try:
            with reading(self._contents, self._trees):
                edited = parse_file(
                    Path(known.source.file), known.source.path, defines=self._defines
                )
        except SourceError:
            return self._load_again()
        if self._asking or needs_declarations(edited.source.text):
            return self._load_again()
        if edited.source.text == known.source.text and edited.source.pieces == known.source.pieces:
            return Extent.NOTHING
        edit = self._edit_of(known, edited)
        if edit is not None and self._edit_bodies(key, edit, edited):
            return Extent.BODIES
        self._sources[key] = edited
        if self._edit_units(known, edited, is_whole=edit is not None):
            return Extent.DECLARATIONS
        self._examine()
        return Extent.PROJECT

    def _may_read(self, key: str, file: Path) -> bool:
        """Return True if the project may have a file, or reads it besides its sources."""
        if file.name == FILE:
            return self._lint_rules is not None
        if file.suffix.lower() not in SOURCES or key in self._listed:
            return file.suffix.lower() in (*_BESIDE, *SOURCES)
        folders = [*self.libraries, *(() if self._is_listing else (self.path,))]
        return self.has(file) or any(
            Path(key).is_relative_to(file_key(folder)) for folder in folders
        )
