"""PLCs of a station: from Python classes, from Structured Text sources, or from a symbol file."""

import hashlib
import importlib
import importlib.util
import logging
import traceback
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeVar

from achse.extras import needs_extra
from achse.iec import DeclarationError, GlobalVariables, IecType, Program
from achse.iec.structs import StaticRecord
from achse.plc import Memory, PlcRuntime, Task
from achse.plc.behaviour import with_behaviour
from achse.plc.program import area_sizes
from achse.plc.system_info import system_info_list
from achse.st.files.tasks import FileTask, called_tasks, has_floating_point_exceptions
from achse.st.lexis.collection import collection_paused
from achse.station.configuration.plc import PlcConfig, TaskConfig
from achse.station.configuration.types import ConfigError

if TYPE_CHECKING:
    from achse.plc.bodies import Bodies
    from achse.plc.routines.builtins import Services
    from achse.st.declare import Declarations
    from achse.st.files.solution import NcMappings
    from achse.st.lexis.source import Diagnostic
    from achse.st.missing.libraries import MissingLibrary
    from achse.st.reach import Reach

_SHOWN_FAULTS = 20
_SHOWN_FILES = 5

log = logging.getLogger("achse.plc")

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class _Declared:
    """Declarations of sources or of a symbol file."""

    units: Sequence[type[StaticRecord]] = ()
    types: Sequence[IecType[Any]] = ()
    tasks: Sequence[FileTask] = ()
    project: str = "achse"
    pointer_size: int = 8
    declarations: "Declarations | None" = None
    """Of sources: what a check makes bodies of."""
    reach: "Reach | None" = None
    unreached: Sequence["Diagnostic"] = ()
    """Faults of declarations in units that no task reaches."""
    missing: Sequence["MissingLibrary"] = ()


class PlcSource:
    """Source of the declarations of one `[[plc]]`.

    `key` names the section in errors, `base` is the folder of relative names, `services` are the
    library routines that need the station, `epoch()` is the Unix time at time 0. All methods raise
    `ConfigError` for a source that cannot be read or declared.
    """

    def __init__(
        self,
        config: PlcConfig,
        key: str,
        base: Path,
        services: "Services | None" = None,
        epoch: Callable[[], int] = int,
    ) -> None:
        self.config = config
        self.services = services
        self.epoch = epoch
        self.key = key
        self.base = base

    def make(self) -> PlcRuntime:
        """Return the PLC as declared, in RUN."""
        config = self.config
        declared, tasks, globals, programs = self._read()
        called = [program for of_task in programs.values() for program in of_task]
        sizes = area_sizes([*globals, *called])
        watchdogs = {task.name: task.watchdog_cycles for task in config.task}
        return self._checked(
            "",
            lambda: PlcRuntime(
                [
                    Task(
                        task.name,
                        task.cycle_ns,
                        programs[task.name],
                        priority=task.priority,
                        port=task.port,
                        watchdog_cycles=watchdogs.get(task.name, task.watchdog_cycles),
                    )
                    for task in tasks
                ],
                globals,
                name=f"Port_{config.port}",
                project=declared.project,
                port=config.port,
                memory=Memory(sizes),
                pointer_size=declared.pointer_size,
                bodies=self._bodies(declared, tasks),
            ),
        )

    def nc_mappings(self, known: "dict[tuple[Path, ...], NcMappings]") -> "NcMappings | None":
        """Axes and channels that the solution of the sources links to variables of this PLC.

        If a link names the project of the sources, only such links count. None without sources.
        Mappings of solutions that are in `known` are not read again; others are added to it.
        """
        if self.config.sources is None:
            return None
        from achse.st.files.solution import mapping_files, nc_mappings, solutions_of

        root = self.base / self.config.sources
        solutions = solutions_of(root)
        mappings = known.get(solutions)
        if mappings is None:
            mappings = self._checked(".sources", lambda: nc_mappings(mapping_files(solutions)))
            known[solutions] = mappings
        return mappings.of_projects({root.stem.casefold(), root.absolute().parent.name.casefold()})

    def _bodies(self, declared: _Declared, tasks: Sequence[FileTask]) -> "Bodies | None":
        """Return the bodies of the sources; None if there are none, or `execute` is off.

        A fault in a body is logged; its routine is left out.
        """
        if declared.declarations is None or not self.config.execute:
            self._log_unreached(declared.unreached)
            return None
        from achse.native.backend import compiler_installed
        from achse.plc.bodies import Bodies
        from achse.plc.code.execution import CodeForm
        from achse.plc.coverage.counters import is_own
        from achse.st.check import check  # as above

        if self.config.code == CodeForm.MACHINE.value and not compiler_installed():
            raise ConfigError(needs_extra(f"{self.key}.code: machine", "fast"))
        list_of_tasks = [Task()] * len(tasks)
        system = system_info_list(list_of_tasks, app_name="", project_name="", port=0, timestamp=0)
        project = check(
            declared.declarations,
            predefined=[system],
            check_bounds=self.config.check_bounds,
            reach=declared.reach,
            unreached=declared.unreached,
        )
        self._log_unreached(project.unreached)
        self._log_faults(declared.missing, project.faults)
        exceptions = self.config.floating_point_exceptions
        if exceptions is None:
            exceptions = has_floating_point_exceptions(tasks)
        return Bodies(
            project,
            budget=self.config.budget,
            exceptions=exceptions,
            services=self.services,
            epoch=self.epoch,
            form=CodeForm(self.config.code),
            covered=is_own if self.config.coverage else None,
            conditions=self.config.coverage == "conditions",
        )

    def _log_faults(
        self, missing: Sequence["MissingLibrary"], faults: Sequence["Diagnostic"]
    ) -> None:
        """Log the faults in bodies; those that follow from a missing library are one line."""
        from achse.st.missing.libraries import findings_by_library, line_of_library  # few need it

        libraries, apart = findings_by_library(missing, faults)
        for fault in apart[:_SHOWN_FAULTS]:
            log.warning("%s: %s", self.key, fault)
        if len(apart) > _SHOWN_FAULTS:
            log.warning(
                "%s: %d more errors in bodies: achse check %s shows all",
                self.key,
                len(apart) - _SHOWN_FAULTS,
                self.config.sources,
            )
        for library, following in libraries:
            log.warning("%s: %s", self.key, line_of_library(library, following))

    def _log_unreached(self, faults: Sequence["Diagnostic"]) -> None:
        """Log which files have units that are left out: they have faults, and no task reaches
        them."""
        if not faults:
            return
        files = list(dict.fromkeys(fault.location.path for fault in faults))
        more = f" and {len(files) - _SHOWN_FILES} more" if len(files) > _SHOWN_FILES else ""
        log.warning(
            "%s: %d errors in units that no task reaches, which are left out: %s%s;"
            " achse check shows them",
            self.key,
            len(faults),
            ", ".join(files[:_SHOWN_FILES]),
            more,
        )

    @collection_paused()
    def reload(self, plc: PlcRuntime) -> None:
        """Read the declarations again and let the running PLC go on with them."""
        declared, tasks, globals, programs = self._read()
        if [(task.name, task.cycle_ns) for task in tasks] != [
            (task.name, task.cycle_ns) for task in plc.tasks
        ]:
            raise ConfigError(f"{self.key}: tasks and their cycles take a restart to change")
        sizes = area_sizes([*globals, *(one for of_task in programs.values() for one in of_task)])
        bodies = self._bodies(declared, tasks)
        self._refuse_new_faults(plc.bodies, bodies)
        self._checked("", lambda: plc.online_change(globals, programs, sizes, bodies))

    def _refuse_new_faults(self, running: "Bodies | None", bodies: "Bodies | None") -> None:
        """Refuse to replace a running routine by one with errors, which would stop the PLC."""
        from achse.st.lexis.source import SourceError

        if running is None or bodies is None:
            return
        known = Counter(fault.message for fault in running.project.faults)
        new = []
        for fault in bodies.project.faults:
            if known[fault.message]:
                known[fault.message] -= 1
            else:
                new.append(fault)
        if new:
            raise ConfigError(f"{self.key}.sources: {SourceError(new)}")

    def files(self) -> Mapping[str, str]:
        """Return the paths of the project's own source files, by the names they have in faults."""
        if self.config.sources is None:
            return {}
        from achse.st.files.files import source_files
        from achse.st.lexis.source import SourceError

        try:
            files = source_files(self.base / self.config.sources)
        except SourceError:
            return {}
        return {name: str(file.resolve()) for file, name in files}

    def stamps(self) -> Mapping[Path, tuple[int, int]]:
        """Return the files that the declarations come from, with their time of change and size."""
        from achse.st.files.forms import form_of

        config = self.config
        files = [self.base / name for name in (config.symbols,) if name is not None]
        for name in (config.sources, *config.libraries):
            if name is None:
                continue
            root = self.base / name
            files += (
                [file for file in root.rglob("*") if form_of(file)] if root.is_dir() else [root]
            )
        names = [*config.behaviour, *config.globals]
        names += [name for task in config.task for name in task.programs]
        modules = {name.rpartition(":")[0] for name in names}
        files += [self.base / name for name in modules if name.endswith(".py")]
        stamps = {}
        for file in files:
            try:
                state = file.stat()
            except OSError:
                continue
            stamps[file] = (state.st_mtime_ns, state.st_size)
        return stamps

    # reading ---------------------------------------------------------------------------------

    def _read(
        self,
    ) -> tuple[_Declared, list[FileTask], list[type[StaticRecord]], dict[str, list[type[Program]]]]:
        """Return the declarations, the tasks, the units that no task calls, and the programs of
        each task."""
        config = self.config
        modules: dict[str, ModuleType] = {}
        declared = self._declared()
        behaviours = [
            self._python(name, object, f"{self.key}.behaviour", modules)
            for name in config.behaviour
        ]
        units = self._checked(
            ".behaviour", lambda: with_behaviour(declared.units, behaviours, declared.types)
        )
        named = {unit.__iec__.name.lower(): unit for unit in units}
        tasks = _tasks(config.task, declared)
        programs: dict[str, list[type[Program]]] = {}
        for number, task in enumerate(tasks, 1):
            where = f"{self.key}.task[{number}].programs" if config.task else self.key
            programs[task.name] = [
                self._program(name, where, named, modules) for name in task.programs
            ]
        globals: list[type[StaticRecord]] = [
            self._python(name, GlobalVariables, f"{self.key}.globals", modules)
            for name in config.globals
        ]
        called = {program for of_task in programs.values() for program in of_task}
        return declared, tasks, [*globals, *(u for u in units if u not in called)], programs

    def _declared(self) -> _Declared:
        config = self.config
        if config.sources is not None:
            from achse.st.project import load_project  # a quarter of a start; few need it

            root = self.base / config.sources
            if not root.exists():
                raise ConfigError(f"{self.key}.sources: {root} does not exist")
            libraries = [self.base / name for name in config.libraries]
            called = [name for task in config.task for name in task.programs]
            project = self._checked(
                ".sources",
                lambda: load_project(
                    root,
                    libraries=libraries,
                    unknown=config.unknown_types,
                    programs=called or None,
                ),
            )
            if project.stubs:
                lines = sum(text.count("\n") for text in project.stubs.values())
                log.warning(
                    "%s: %d lines of stubs for undeclared names;"
                    " achse check %s --stubs FOLDER writes them",
                    self.key,
                    lines,
                    config.sources,
                )
            for library in project.missing:
                log.warning("%s: %s", self.key, library)
            declarations = project.declarations
            return _Declared(
                declarations.units,
                list(declarations.types.values()),
                [FileTask(*task) for task in project.tasks],
                root.resolve().stem,
                project.rules.pointer_size,
                declarations,
                project.reach,
                project.unreached,
                project.missing,
            )
        if config.symbols is not None:
            from achse.st.symbolfiles import read_symbol_file  # few need it

            path = self.base / config.symbols
            try:
                data = path.read_bytes()
            except OSError as failure:
                raise ConfigError(
                    f"{self.key}.symbols: {path} cannot be read: {failure.strerror}"
                ) from None
            file = self._checked(".symbols", lambda: read_symbol_file(data, str(path)))
            return _Declared(
                self._checked(".symbols", file.units),
                file.types,
                file.called_tasks(),
                file.name,
                file.pointer_size,
            )
        return _Declared()

    def _program(
        self,
        name: str,
        key: str,
        named: Mapping[str, type[StaticRecord]],
        modules: dict[str, ModuleType],
    ) -> type[Program]:
        if ":" in name:
            return self._python(name, Program, key, modules)
        program = named.get(name.lower())
        if program is None or not issubclass(program, Program):
            known = ", ".join(u.__iec__.name for u in named.values() if issubclass(u, Program))
            expected = f"one of {known}, or " if known else ""
            raise ConfigError(
                f"{key}: expected {expected}module:Class or file.py:Class, got {name!r}"
            )
        return program

    def _python(
        self, name: str, kind: type[T], key: str, modules: dict[str, ModuleType]
    ) -> type[T]:
        """Return the class that `module:Class` or `file.py:Class` names."""
        source, _, attribute = name.rpartition(":")
        if not source or not attribute:
            raise ConfigError(f"{key}: expected module:Class or file.py:Class, got {name!r}")
        module = modules.get(source)
        if module is None:
            try:
                module = modules[source] = _module(source, self.base)
            except (Exception, SystemExit) as failure:
                raise ConfigError(
                    f"{key}: {source} cannot be imported: {_in_words(failure)}"
                ) from failure
        declared = getattr(module, attribute, None)
        if not (isinstance(declared, type) and issubclass(declared, kind)):
            what = "class" if kind is object else kind.__name__
            raise ConfigError(f"{key}: {source} has no {what} {attribute!r}")
        return declared

    def _checked(self, key: str, make: Callable[[], T]) -> T:
        try:
            return make()
        except (DeclarationError, ConfigError) as fault:
            raise ConfigError(f"{self.key}{key}: {fault}") from fault
        except Exception as failure:  # of the user's Python: reported with its place
            raise ConfigError(f"{self.key}{key}: {_in_words(failure)}") from failure


def _in_words(failure: BaseException) -> str:
    """`NameError: name 'x' is not defined (feeder.py, line 3)`."""
    if isinstance(failure, SyntaxError):
        return f"SyntaxError: {failure.msg} ({failure.filename}, line {failure.lineno})"
    frames = traceback.extract_tb(failure.__traceback__)
    ours = str(Path(__file__).parents[2])
    users = [frame for frame in frames if not frame.filename.startswith((ours, "<"))]
    place = f" ({users[-1].filename}, line {users[-1].lineno})" if users else ""
    return f"{type(failure).__name__}: {failure}{place}"


def _tasks(configured: Sequence[TaskConfig], declared: _Declared) -> list[FileTask]:
    """Return the tasks of station.toml, else those of the declarations, else one for all
    programs."""
    if configured:
        return [
            FileTask(task.name, task.cycle, task.priority, tuple(task.programs))
            for task in configured
        ]
    programs = [u.__iec__.name for u in declared.units if issubclass(u, Program)]
    if declared.tasks and not programs:
        log.warning("no programs are declared, as in a library: the tasks call nothing")
    return called_tasks(declared.tasks, programs)


def _module(source: str, base: Path) -> ModuleType:
    if not source.endswith(".py"):
        return importlib.import_module(source)
    path = (base / source).resolve()
    digest = hashlib.blake2b(str(path).encode(), digest_size=4).hexdigest()
    spec = importlib.util.spec_from_file_location(f"achse_plc_{path.stem}_{digest}", path)
    if spec is None or spec.loader is None:
        raise ImportError(f"{path} is not a Python file")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
