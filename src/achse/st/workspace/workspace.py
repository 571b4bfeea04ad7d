"""The workspace: a project that is checked once, and after each edit as far as the edit reaches.

An edit of bodies alone checks the changed routines again, on the same declarations. An edit of
declarations declares and checks again what names the changed units, directly or not. Files that did
not change are not parsed again. A file that is added or taken away is an edit of its declarations.
All files are read again if a task or a library changes, or a `.plcproj` apart from its files.
"""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from enum import Enum
from functools import partial
from pathlib import Path
from typing import Any
from weakref import WeakValueDictionary

from achse.iec.structs import StaticRecord
from achse.st.check.reached import faults_by_reach
from achse.st.check.warm import Inspection, WarmChecking
from achse.st.declare import (
    Declarations,
    Routine,
    declare_again,
    faults_of,
    has_good_locals,
    named_sources,
)
from achse.st.declared.scopes import DEEPEST, DeclaredUnit
from achse.st.files.envelope import TaskDeclaration
from achse.st.files.files import LIBRARY_TYPES, SOURCES, parse_file, source_files
from achse.st.files.forms import Content, has_content, suffixes_of
from achse.st.files.reading import file_key, reading
from achse.st.lexis.lexer import Defines
from achse.st.lexis.pragmas import needs_declarations
from achse.st.lexis.source import Diagnostic, Source, SourceError
from achse.st.lint.options import FILE, LintOptions, LintOptionsError
from achse.st.mentions import Mentions
from achse.st.project import ProjectFiles, read_files
from achse.st.reach import Reach
from achse.st.syntax.parser import Parsed
from achse.st.workspace.edits import BodyEdit, body_edit, emptied, is_on_disk, project_options
from achse.st.workspace.findings import ProjectFindings, sorted_findings
from achse.st.workspace.plans import plan_of_all, plan_routines, settled
from achse.st.workspace.touched import WordIndex, first_touched
from achse.st.workspace.uses import SymbolUse, use_at, uses_in

_BESIDE = (LIBRARY_TYPES, *suffixes_of(Content.PROJECT, Content.SYSTEM, Content.SOLUTION))
"""Endings of further files that say something about a project."""

_MOST_FILES = 16
"""Files that come, go or change at once; of more the project is read again."""

PredefinedLists = Callable[[Sequence[TaskDeclaration]], Iterable[type[StaticRecord]]]
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


class Workspace:
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
        self.path = Path(path)
        self.libraries = tuple(Path(item) for item in libraries)
        self._defines = defines
        self._predefined_of = predefined
        self._check_all = check_all
        self._contents = {file_key(file): text for file, text in (open_files or {}).items()}
        """Texts of files that are open, by `file_key`."""
        self._trees: WeakValueDictionary[tuple[object, ...], Any] = WeakValueDictionary()
        self._files: ProjectFiles | None = None
        self._sources: dict[str, Parsed] = {}
        """Sources of the project by `file_key`, in their order."""
        self._listed: frozenset[str] = frozenset()
        """Files of the project by `file_key`, those that cannot be read too."""
        self._named_files: dict[str, Path] = {}
        self._uses: dict[Source, Sequence[SymbolUse]] = {}
        self._options = b""
        """Content of the `.plcproj` apart from the files that it names."""
        self._is_listing = False
        """True if a `.plcproj` says what is in the project."""
        self._asking = False
        """True if conditions in sources ask for declarations of others."""
        self._mentions: dict[DeclaredUnit, Mentions] = {}
        self._named: frozenset[Source] = frozenset()
        self._declared_faults: tuple[Diagnostic, ...] = ()
        self._words = WordIndex()
        self.declarations: Declarations | None = None
        """The declarations of the project; None if nothing can be read."""
        self.checking: WarmChecking | None = None
        self.findings = ProjectFindings()
        self._lint_rules = lint_rules
        self.lint_options = LintOptions()
        self.lint_failure = ""
        """Fault in achse.toml, which switches all rules off."""
        self._linted: Sequence[Diagnostic] | None = None
        self._unreached_units: Callable[[], Collection[str]] = frozenset
        """Units left out because of faults that no task reaches."""
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

    @property
    def sources(self) -> tuple[Parsed, ...]:
        """The sources of the project."""
        return tuple(self._sources.values())

    @property
    def all_sources(self) -> Iterable[Parsed]:
        """The sources of the project and of the user's libraries."""
        return (*self._sources.values(), *(() if self._files is None else self._files.libraries))

    @property
    def tasks(self) -> Sequence[TaskDeclaration]:
        """The tasks of the project."""
        return () if self._files is None else self._files.tasks

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

    def uses_of(self, source: Source) -> Sequence[SymbolUse]:
        """Return the names in a source with what they mean, kept until an edit changes them."""
        if self.checking is None:
            return ()
        if source not in self._uses:
            self._uses[source] = uses_in(self.checking, source)
        return self._uses[source]

    def use_at(self, source: Source, offset: int) -> SymbolUse | None:
        """Return the name at an offset of a source with what it means."""
        if self.checking is None:
            return None
        if source not in self._uses:
            return use_at(self.checking, source, offset)
        uses = self._uses[source]
        return next((use for use in uses if use.at <= offset <= use.end), None)

    def lint(self) -> Sequence[Diagnostic]:
        """Return the findings of the linter, kept until an edit; none if no rule is on."""
        checking, declarations = self.checking, self.declarations
        if checking is None or declarations is None or not self.lint_options.codes:
            return ()
        if self._linted is None:
            from achse.st.lint.linting import lint_warm  # off by default

            compared = checking.remarks(() if self._check_all else self._unreached_units())
            self._linted = lint_warm(self.sources, declarations, compared, self.lint_options)
        return self._linted

    @property
    def is_linted(self) -> bool:
        """True if `lint` has nothing to do."""
        return self._linted is not None or not self.lint_options.codes

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
        found = self.relist()
        return self._load_again() if found is Extent.NOTHING else found

    def _load_again(self) -> Extent:
        self.load()
        return Extent.FILES

    def _edit_units(self, known: Parsed, edited: Parsed, *, is_whole: bool = False) -> bool:
        """Take other units of a file, which the project's sources have; False if everything is to
        be checked. With `is_whole` the trees that are known may be those of the new version."""
        self._take_sources()
        return self._edit_declarations(known, edited, is_whole)

    def _take_sources(self) -> None:
        assert self._files is not None
        self._files = replace(self._files, sources=self.sources)

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

    def _edit_of(self, known: Parsed, edited: Parsed) -> BodyEdit | None:
        """Return the edit if it changes bodies and locals alone, and all kept findings can follow
        it."""
        checking = self.checking
        if checking is None or not checking.is_exact or self._are_shared(known):
            return None
        edit = body_edit(known, edited)
        if edit is None or (edit.declaring and self._has_declared_faults(known.source)):
            return None
        quoted = f"{known.source.path}:"  # other findings name places in this file
        if any(quoted in one.message for one in self._every_finding()):
            return None
        return edit

    def _has_declared_faults(self, source: Source) -> bool:
        """Return True if faults of declarations in a file, or of a library, may come or go."""
        assert self._files is not None
        return any(parsed.faults for parsed in self._files.libraries) or any(
            one.origin is None or one.origin.source is source for one in self._declared_faults
        )

    def _are_shared(self, parsed: Parsed) -> bool:
        """Return True if another file has the same trees, because its content is the same."""
        units = set(map(id, parsed.units))
        return any(
            not units.isdisjoint(map(id, other.units))
            for other in self.all_sources
            if other is not parsed and other.source.path == parsed.source.path
        )

    def _every_finding(self) -> Iterable[Diagnostic]:
        assert self.checking is not None
        for node in self.checking.nodes.values():
            yield from node.faults
            yield from node.warnings
        yield from self.checking.names.scopes.faults

    # one edit of bodies ----------------------------------------------------------------------

    def _edit_bodies(self, key: str, edit: BodyEdit, edited: Parsed) -> bool:
        """Check the routines of an edited file again; False if findings would be wrong.

        Nothing is changed then, but what will be made again.
        """
        checking = self.checking
        assert checking is not None
        known = self._sources[key]
        self._uses.pop(known.source, None)
        known.source.content = None  # others must not get trees that change
        changed = {id(tree) for tree in edit.make()}
        declaring = {id(tree) for tree in edit.declaring}
        again = []
        for signature in checking.routines.made:
            is_changed = signature.source is known.source and id(signature.tree) in changed
            if not is_changed:
                continue
            if checking.checked(signature.key) is not None:
                again.append(signature)
            if id(signature.tree) in declaring:
                declaring.discard(id(signature.tree))
                self._words.forget(signature.entry)
                assert isinstance(signature.tree, Routine)
                if not has_good_locals(checking.names, signature.entry, signature.tree):
                    return False
        if declaring:  # routines that cannot be called
            return False
        keys = {signature.key for signature in again}
        for name, node in checking.nodes.items():
            found = (node.faults, node.warnings, node.remarks)
            if name in keys or not any(found):
                continue
            moved = [self._followed(edit, findings) for findings in found]
            if None not in moved:
                node.faults, node.warnings, node.remarks = moved  # type: ignore[assignment]
                continue
            routine = checking.checked(name)
            if routine is None:
                return False
            again.append(routine)
        scopes = checking.names.scopes
        declared = self._followed(edit, dict.fromkeys(self._declared_faults))
        reported = self._followed(edit, scopes.faults)
        if declared is None or reported is None:
            return False
        self._declared_faults, scopes.faults = tuple(declared), reported
        self._sources[key] = Parsed(known.source, known.units, edited.faults)
        checking.check_again(again)
        if not checking.is_exact:
            return False
        for entry in [one for one in self._mentions if one.source is known.source]:
            del self._mentions[entry]
        if edit.declaring:
            self._named = named_sources(checking.names)
        self.judge()
        return True

    @staticmethod
    def _followed(
        edit: BodyEdit, findings: dict[Diagnostic, None]
    ) -> dict[Diagnostic, None] | None:
        """Return findings at their new places; None if one has none."""
        moved = [edit.follow(one) for one in findings]
        if None in moved:
            return None
        return dict.fromkeys(one for one in moved if one is not None)

    # an edit of declarations -----------------------------------------------------------------

    def _edit_declarations(self, known: Parsed, edited: Parsed, is_whole: bool) -> bool:
        """Declare and check again what an edit touches; False if findings would be wrong.

        Everything is to be checked then.
        """
        files, checking = self._files, self.checking
        assert files is not None
        if checking is None or not checking.is_exact:
            return False
        if any(parsed.faults for parsed in files.libraries):
            return False  # they count if the project names something of the file
        names = checking.names
        first = first_touched(checking, known, edited, self._declared_faults, is_whole=is_whole)
        if first is None or any("var_config" in self._words.of_file(s) for s in self._own_sources):
            return False
        sources = tuple(self.all_sources)
        readable = {parsed.source for parsed in sources}
        entries = [one for one in names.scopes.entries.values() if one.source in readable]
        self._words.keep(sources, entries)
        touched = self._words.touched(sources, entries, first)
        named = {
            parsed.source
            for parsed in sources
            if not touched.words.isdisjoint(self._words.of_file(parsed.source, parsed.units))
        }
        plan = plan_routines(checking, known, edited, touched, self._words)
        self.declarations = declare_again(
            names, self.sources, files.libraries, touched.units, touched.words
        )
        self._named = named_sources(names)
        self._declared_faults = tuple(names.scopes.faults)
        self._uses = {}
        for entry in [one for one in self._mentions if one.source in named]:
            del self._mentions[entry]
        plan = settled(plan, names, touched, edited) or plan_of_all(checking, touched, self._words)
        checking.check_touched(touched.units, touched.words, plan.again, plan.kept)
        if not checking.is_exact or names.scopes.height > DEEPEST:
            return False
        self.judge()
        return True

    @property
    def _own_sources(self) -> Iterable[Source]:
        return (parsed.source for parsed in self._sources.values())

    # everything ------------------------------------------------------------------------------

    def _examine(self) -> None:
        """Declare and check everything."""
        assert self._files is not None
        self._take_sources()
        self.declarations, _ = self._files.declared()
        names = self.declarations.names
        self._named = named_sources(names)
        self._declared_faults = tuple(names.scopes.faults)
        self._mentions, self._uses = {}, {}
        inspect: Inspection | None = None
        if self.lint_options.codes:
            from achse.st.lint.comparisons import comparisons_in  # off by default

            inspect = comparisons_in
        self.checking = WarmChecking(names, self._predefined_of(self.tasks), inspect=inspect)
        self.checking.start()
        self.judge()

    def judge(self) -> None:
        """Say what the findings mean for the build."""
        files, checking = self._files, self.checking
        assert files is not None
        assert checking is not None
        self._linted = None
        declared = faults_of(self.sources, files.libraries, self._declared_faults, self._named)
        faults = [*files.faults, *SourceError(declared).faults]
        checked = tuple(sorted(dict.fromkeys(checking.faults), key=lambda one: one.location))
        if self._check_all:
            self.findings = sorted_findings([*faults, *checked], checking.warnings, ())
            return
        reach = Reach(
            checking.names,
            (*self.sources, *files.found.sources),
            files.programs(),
            self._mentions,
        )
        errors, unreached = reach.findings(faults)
        further, all_unreached = faults_by_reach(
            checked, checking.faulty_routines, reach, tuple(unreached)
        )
        self._unreached_units = partial(reach.dependent_on, all_unreached)
        self.findings = sorted_findings(
            [*errors, *further], checking.warnings, [*unreached, *all_unreached]
        )
