"""Checked projects: a project in memory, with its declarations and findings, and edits of them.

An edit of bodies and local variables alone checks the changed routines again, on the same
declarations. An edit of other declarations declares what names the changed units again, directly
or not, and checks the routines that have a changed name.
"""

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import replace
from functools import partial

from achse.iec.structs import StaticRecord
from achse.st.check.warm import Inspection, WarmChecking
from achse.st.declare import (
    Declarations,
    RoutineTree,
    declare_again,
    faults_of,
    has_good_locals,
    named_sources,
)
from achse.st.declared.scopes import DEEPEST, DeclaredUnit
from achse.st.files.envelope import TaskDeclaration
from achse.st.lexis.source import Diagnostic, Source, SourceError
from achse.st.lint.options import LintOptions
from achse.st.mentions import Mentions
from achse.st.project import ProjectFiles
from achse.st.reach import Reach
from achse.st.syntax.parser import Parsed
from achse.st.workspace.edits import BodyEdit, body_edit
from achse.st.workspace.findings import (
    ProjectFindings,
    findings_by_reach,
    sorted_faults,
    sorted_findings,
)
from achse.st.workspace.plans import any_list_fails, plan_of_all, plan_routines, settled
from achse.st.workspace.stubs import ProjectStubs, may_need_stubs
from achse.st.workspace.touched import Touched, WordIndex, first_touched
from achse.st.workspace.uses import SymbolUse, use_at, uses_in

PredefinedLists = Callable[[Sequence[TaskDeclaration]], Iterable[type[StaticRecord]]]


class CheckedProject:
    """The sources of a project, what they declare, and what a check finds in them.

    `predefined` returns the variable lists that a runtime declares for the tasks of a project.
    """

    def __init__(self, predefined: PredefinedLists, *, check_all: bool) -> None:
        self._predefined_of = predefined
        self._check_all = check_all
        self._files: ProjectFiles | None = None
        self._sources: dict[str, Parsed] = {}
        """Sources of the project by `file_key`, in their order."""
        self._uses: dict[Source, Sequence[SymbolUse]] = {}
        self._mentions: dict[DeclaredUnit, Mentions] = {}
        self._named: frozenset[Source] = frozenset()
        self._declared_faults: tuple[Diagnostic, ...] = ()
        self._words = WordIndex()
        self.declarations: Declarations | None = None
        """The declarations of the project; None if nothing can be read."""
        self.checking: WarmChecking | None = None
        self._stubs: ProjectStubs | None = None
        self.findings = ProjectFindings()
        self.lint_options = LintOptions()
        self._linted: Sequence[Diagnostic] | None = None
        self._unreached_units: Callable[[], Collection[str]] = frozenset
        """Units left out because of faults that no task reaches."""

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

    def _take_sources(self) -> None:
        assert self._files is not None
        self._files = replace(self._files, sources=self.sources)

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
        assert self._files is not None
        assert self._stubs is not None
        if self._stubs.sources and not self._stubs.leaves(
            edit.words(), tuple(self.all_sources), self._words
        ):
            return False
        self._uses.pop(known.source, None)
        known.source.content = None  # others must not get trees that change
        changed = {id(tree) for tree in edit.make()}
        declaring = {id(tree) for tree in edit.declaring}
        again = []
        for signature in checking.routines.created:
            is_changed = signature.source is known.source and id(signature.tree) in changed
            if not is_changed:
                continue
            if checking.checked(signature.key) is not None:
                again.append(signature)
            if id(signature.tree) in declaring:
                declaring.discard(id(signature.tree))
                self._words.forget(signature.entry)
                assert isinstance(signature.tree, RoutineTree)
                if not has_good_locals(checking.names, signature.entry, signature.tree):
                    return False
        if declaring:  # routines that cannot be called
            return False
        keys = {signature.key for signature in again}
        for name, node in checking.nodes.items():
            findings = (node.faults, node.warnings, node.remarks)
            if name in keys or not any(findings):
                continue
            faults, warnings, remarks = (self._followed(edit, each) for each in findings)
            if faults is not None and warnings is not None and remarks is not None:
                node.faults, node.warnings, node.remarks = faults, warnings, remarks
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
        if not self._stubs.hold(self._files):
            return False
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
        assert self._stubs is not None
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
        sound = frozenset(names.units)
        touched = self._words.touched(sources, entries, first, sound)
        named = {
            parsed.source
            for parsed in sources
            if not touched.words.isdisjoint(self._words.of_file(parsed.source, parsed.units))
        }
        if not self._may_declare(known, edited, touched, sources):
            return False
        plan = plan_routines(checking, known, edited, touched, self._words)
        libraries = (*files.libraries, *self._stubs.sources)
        self.declarations = declare_again(
            names, self.sources, libraries, touched.units, touched.words
        )
        self._named = named_sources(names)
        self._declared_faults = tuple(names.scopes.faults)
        self._uses = {}
        for entry in [one for one in self._mentions if one.source in named]:
            del self._mentions[entry]
        if any_list_fails(names, touched.units & sound):
            return False  # units that name other variables of it fail, too
        plan = settled(plan, names, touched, edited) or plan_of_all(checking, touched, self._words)
        checking.check_touched(touched.units, touched.words, plan.again, plan.unchanged)
        if not checking.is_exact or names.scopes.height > DEEPEST:
            return False
        if not self._stubs.hold(files):
            return False
        self.judge()
        return True

    def _may_declare(
        self, known: Parsed, edited: Parsed, touched: Touched, sources: Sequence[Parsed]
    ) -> bool:
        """Return True if stubs for names of libraries stay as they are."""
        stubs = self._stubs
        assert stubs is not None
        return stubs.leaves_texts((known, edited), sources, self._words) and stubs.leaves_units(
            touched, sources, self._words
        )

    @property
    def _own_sources(self) -> Iterable[Source]:
        return (parsed.source for parsed in self._sources.values())

    # everything ------------------------------------------------------------------------------

    def _examine(self) -> None:
        """Declare and check everything."""
        assert self._files is not None
        self._take_sources()
        declared = self._files.declared()
        stub_sources: tuple[Parsed, ...] = ()
        checking = self._checked(declared[0])
        if may_need_stubs(self._files, checking):
            complete = self._files.completed(known=declared)
            stub_sources = complete.sources
            if complete.declarations is not declared[0]:
                checking = self._checked(complete.declarations)
        names = checking.names
        self._named = named_sources(names)
        self._mentions, self._uses = {}, {}
        self.checking = checking
        self._stubs = ProjectStubs(self._files, stub_sources, checking)
        self.judge()

    def _checked(self, declarations: Declarations) -> WarmChecking:
        """Return a check of everything on declarations, which are those of the project now."""
        names = declarations.names
        names.blocks_do_nothing = True
        self.declarations = declarations
        self._declared_faults = tuple(names.scopes.faults)
        inspect: Inspection | None = None
        if self.lint_options.codes:
            from achse.st.lint.comparisons import comparisons_in  # off by default

            inspect = comparisons_in
        checking = WarmChecking(names, self._predefined_of(self.tasks), inspect=inspect)
        checking.start()
        return checking

    def judge(self) -> None:
        """Say what the findings mean for the build."""
        files, checking = self._files, self.checking
        assert files is not None
        assert checking is not None
        self._linted = None
        declared = faults_of(self.sources, files.libraries, self._declared_faults, self._named)
        faults = [*files.faults, *SourceError(declared).faults]
        if self._check_all:
            checked = sorted_faults(checking)
            self.findings = sorted_findings([*faults, *checked], checking.warnings, ())
            return
        reach = Reach(
            checking.names,
            (*self.sources, *files.gathered.sources),
            files.programs(),
            self._mentions,
        )
        self.findings, gone = findings_by_reach(faults, checking, reach)
        self._unreached_units = partial(reach.dependent_on, gone)
