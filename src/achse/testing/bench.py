"""One function block, function or program of a PLC project, alone: for tests of PLC code.

press = plc_unit("press.st", "FB_Press")
press.bStart = True
press.cycle(0.3)
assert press.bDown
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from datetime import timedelta
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from achse.iec import Record, StructType
from achse.iec.declare import Program as ProgramClass
from achse.plc import PlcRuntime, PlcState, Task
from achse.plc.behaviour import with_behaviour
from achse.plc.bodies import Bodies
from achse.plc.code.faults import CATCHABLE, FaultReport, report_of
from achse.plc.system_info import lists_of_runtime
from achse.st.check import check
from achse.st.declare import Declarations, declare
from achse.st.files.files import LIBRARY_TYPES, parse_file, source_files, symbol_files
from achse.st.lexis.codes import Code
from achse.st.lexis.lexer import Defines
from achse.st.lexis.source import Diagnostic, Location, Source, SourceError
from achse.st.symbolfiles.library import LibraryTypes
from achse.st.syntax.parser import Parsed, parse
from achse.st.syntax.printer import print_initial, print_type
from achse.st.syntax.tree import ArrayOf, TypeSpec, VarBlock
from achse.st.syntax.units import Function, FunctionBlock, Namespace, Program, Unit

_BENCH = "AchseBench"
_INSTANCE = "unit_under_test"
_RESULT = "result_under_test"


class PlcUnitFault(Exception):
    """The code under test was stopped by an exception of the PLC: `fault` has code and place."""

    def __init__(self, fault: FaultReport) -> None:
        self.fault = fault
        super().__init__(str(fault))


def plc_unit(
    project: str | Path,
    name: str,
    *,
    init: Mapping[str, object] | None = None,
    libraries: Iterable[str | Path] = (),
    behaviour: Iterable[type] = (),
    defines: Defines = (),
    cycle_time: float = 0.01,
    floating_point_exceptions: bool = True,
    check_bounds: bool = True,
) -> "PlcUnit":
    """Function block, function or program `name` of a project, with nothing else running.

    `project` is a folder of sources, a `.plcproj` or one file. Of it only what `name` needs is
    looked at. `init` are the arguments of FB_init: numbers, booleans and texts; anything else is
    Structured Text in a string that begins with `=`. `behaviour`: Python classes that replace
    blocks of their name, as in station.toml. `cycle_time`: seconds, above 0.
    `floating_point_exceptions` and `check_bounds` are the keys of `[[plc]]`.

    Blocks that need the router (ADSREAD, FB_FileOpen, …) get no answer: test them in a station.
    Raises `SourceError` for what cannot be read, or has errors, and for a name that is not there.
    """
    sources = [
        parse_file(file, shown, defines=defines) for file, shown in source_files(Path(project))
    ]
    further = list(libraries)
    others = [item for item in map(Path, further) if item.suffix.lower() != LIBRARY_TYPES]
    tables = [item for item in map(Path, further) if item.suffix.lower() == LIBRARY_TYPES]
    library_sources = [
        parse_file(file, shown, defines=defines)
        for item in others
        for file, shown in source_files(item)
    ]
    unit = _named(name, sources, str(project))
    text, parameters = _bench(unit, init or {}, [*sources, *library_sources])
    bench = parse(Source(text, _BENCH))
    types = LibraryTypes(
        (item.read_bytes(), item.name) for item in (*tables, *symbol_files(Path(project)))
    )
    declared = declare([bench], libraries=[*sources, *library_sources], further=types)
    return PlcUnit(
        unit.name,
        _runtime(declared, behaviour, cycle_time, floating_point_exceptions, check_bounds),
        is_function=isinstance(unit, Function),
        is_program=isinstance(unit, Program),
        parameters=parameters,
    )


class PlcUnit:
    """Unit under test, as `plc_unit` returns it: its variables are attributes, in any case.

    Inputs and in/outs keep an assigned value until the next assignment. Every variable can be read
    and written, also inside a block: `press.fbDown.ET`. Methods are called with their inputs by
    name or in order: `press.Start(target=5.0)`. The result of a function is `result`.
    """

    def __init__(
        self,
        name: str,
        plc: PlcRuntime,
        *,
        is_function: bool,
        is_program: bool,
        parameters: Mapping[str, str],
    ) -> None:
        bench = plc.instance(_BENCH)
        if is_program:
            record: Record = plc.instance(name)
        else:
            record = bench if is_function else bench[_INSTANCE]
        own: dict[str, Any] = {
            "name": name,
            "plc": plc,
            "_bench": bench,
            "_record": record,
            "_parameters": {name.lower(): own for name, own in parameters.items()},
        }
        self.__dict__.update(own)
        self._raise()

    name: str
    """Name in the source."""
    plc: PlcRuntime
    """The PLC it runs in: memory, state, variable lists (`plc.instance("GVL")`)."""
    _bench: Record
    _record: Record
    _parameters: Mapping[str, str]

    # variables -------------------------------------------------------------------------------

    def _place(self, name: str) -> tuple[Record, str] | None:
        """Return the record that has a variable, and what it is called there."""
        own = self._parameters.get(name.lower())
        if own is not None:
            return self._bench, own
        return (self._record, name) if _type_of(self._record).has_member(name) else None

    def __getitem__(self, name: str) -> Any:
        """Return a variable whose name is one of this class, too: `unit["name"]`."""
        place = self._place(name)
        if place is None:
            raise KeyError(self._unknown(name))
        return place[0][place[1]]

    def __setitem__(self, name: str, value: object) -> None:
        place = self._place(name)
        if place is None:
            raise KeyError(self._unknown(name))
        place[0][place[1]] = value

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        if self._place(name) is not None:
            return self[name]
        if self._bodies.calls.has(self._record, name):
            return lambda *values, **inputs: self._call(name, values, inputs)
        if self._bodies.calls.has(self._record, f"__get{name}"):
            return self._call(f"__get{name}", (), {})
        raise AttributeError(self._unknown(name))

    def __setattr__(self, name: str, value: object) -> None:
        if self._place(name) is not None:
            self[name] = value
            return
        if not self._bodies.calls.has(self._record, f"__set{name}"):
            raise AttributeError(self._unknown(name))
        self._call(f"__set{name}", (value,), {})

    def __dir__(self) -> list[str]:
        members = [item.name for item in _type_of(self._record).members]
        return sorted({*super().__dir__(), *members})

    def __repr__(self) -> str:
        return f"<{self.name} at {self.time:.9g} s>"

    def _unknown(self, name: str) -> str:
        members = [item.name for item in _type_of(self._record).members]
        near = get_close_matches(name, members, 1)
        hint = f"; near: {near[0]}" if near else ""
        return f"{self.name} has no variable, method or property {name!r}{hint}"

    @property
    def _bodies(self) -> Bodies:
        bodies = self.plc.bodies
        assert bodies is not None
        return bodies

    # time ------------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """Seconds since the start."""
        return (self.plc.next_due_ns - self.plc.tasks[0].cycle_ns) / 1e9

    def cycle(self, seconds: float | timedelta | None = None) -> None:
        """Run one cycle; with a time, all cycles of that time (at least one).

        Raises `PlcUnitFault` if an exception stops the code, with file and line.
        """
        if isinstance(seconds, timedelta):
            seconds = seconds.total_seconds()
        count = 1
        if seconds is not None:
            if not 0 <= seconds < float("inf"):
                raise ValueError(f"time goes forward and ends, got {seconds} s")
            count = max(round(seconds * 1e9 / self.plc.tasks[0].cycle_ns), 1)
        for _ in range(count):
            self.plc.run_due(self.plc.next_due_ns)
            self._raise()

    def cycle_until(self, condition: Callable[[], object], limit: float = 60.0) -> float:
        """Run cycles until `condition()` holds after one; the seconds that took.

        Raises AssertionError after `limit` seconds of PLC time.
        """
        began = self.time
        while True:
            self.cycle()
            if condition():
                return self.time - began
            if self.time - began >= limit:
                raise AssertionError(f"{self.name}: not within {limit:g} s of PLC time")

    def __call__(self, **inputs: object) -> Any:
        """Set inputs by name and run one cycle; gives the result of a function, else None."""
        for name, value in inputs.items():
            setattr(self, name, value)
        self.cycle()
        has_result = _type_of(self._bench).has_member(_RESULT)
        return self._bench[_RESULT] if has_result else None

    # faults ----------------------------------------------------------------------------------

    def _call(self, name: str, values: Sequence[object], inputs: Mapping[str, object]) -> Any:
        try:
            return self._bodies.calls.call(self._record, name, values, inputs)
        except CATCHABLE as failure:
            raise PlcUnitFault(report_of(failure, self._bodies.paths)) from None

    def _raise(self) -> None:
        if self.plc.state is PlcState.EXCEPTION:
            assert self.plc.fault is not None
            raise PlcUnitFault(self.plc.fault)


def _type_of(record: Record) -> StructType[Any]:
    return type(record).__iec__


# the bench -----------------------------------------------------------------------------------


def _units(parsed: Iterable[Parsed]) -> "Iterator[Unit]":
    waiting = [unit for each in parsed for unit in each.units]
    for unit in waiting:
        if isinstance(unit, Namespace):
            waiting += unit.units
        yield unit


def _named(
    name: str, sources: Iterable[Parsed], project: str
) -> FunctionBlock | Function | Program:
    known = {
        unit.name.lower(): unit
        for unit in _units(sources)
        if isinstance(unit, FunctionBlock | Function | Program)
    }
    tree = known.get(name.lower())
    if tree is None:
        near = get_close_matches(name.lower(), known, 1)
        hint = f"; near: {known[near[0]].name}" if near else ""
        raise SourceError(
            [
                _diagnostic(
                    project, f"no function block, function or program is named {name!r}{hint}"
                )
            ]
        )
    return tree


def _diagnostic(path: str, message: str) -> Diagnostic:
    return Diagnostic(Location(path, 1, 1), message, Code.UNKNOWN_NAME)


def _bench(
    unit: FunctionBlock | Function | Program, init: Mapping[str, object], sources: Sequence[Parsed]
) -> tuple[str, dict[str, str]]:
    """Return a program that calls the unit, and the names of its own variables that tests see."""
    lines: list[str] = []
    names: dict[str, str] = {}
    arguments: list[str] = []

    def hold(section: str, name: str, type: TypeSpec, initial: str = "") -> None:
        if isinstance(type, ArrayOf) and None in type.dimensions:
            raise SourceError(
                [
                    _diagnostic(
                        unit.name,
                        f"{name} takes arrays of any size: test it through a block that calls it",
                    )
                ]
            )
        lines.append(f"    {name} : {print_type(type)}{initial};")
        names[name] = name
        arguments.append(f"{name} {'=>' if section == 'VAR_OUTPUT' else ':='} {name}")

    if isinstance(unit, Function):
        for block in unit.blocks:
            if block.section in ("VAR_INPUT", "VAR_IN_OUT", "VAR_OUTPUT"):
                for name, type, initial in _variables(block):
                    hold(block.section, name, type, initial)
        call = f"{unit.name}({', '.join(arguments)});"
        if unit.returns is not None:
            lines.append(f"    {_RESULT} : {print_type(unit.returns)};")
            names.setdefault("result", _RESULT)
            call = f"{_RESULT} := {call}"
    elif isinstance(unit, FunctionBlock):
        for block in _all_blocks(unit, sources):
            if block.section == "VAR_IN_OUT":
                for name, type, _ in _variables(block):
                    hold(block.section, name, type)
        inputs = ", ".join(f"{name} := {_literal(value)}" for name, value in init.items())
        lines.append(f"    {_INSTANCE} : {unit.name}{f'({inputs})' if inputs else ''};")
        call = f"{_INSTANCE}({', '.join(arguments)});"
    else:
        call = f"{unit.name}();"
    text = "\n".join([f"PROGRAM {_BENCH}", "VAR", *lines, "END_VAR", call, "END_PROGRAM"])
    return text, names


def _variables(block: VarBlock) -> "Iterator[tuple[str, TypeSpec, str]]":
    for declaration in block.variables:
        initial = "" if declaration.initial is None else f" := {print_initial(declaration.initial)}"
        for name in declaration.names:
            yield name.name, declaration.type, initial


def _all_blocks(unit: FunctionBlock, sources: Sequence[Parsed]) -> "Iterator[VarBlock]":
    """Variables of a block, those of its bases first."""
    if unit.extends is not None:
        wanted = unit.extends.name.rpartition(".")[2].lower()
        for base in _units(sources):
            if isinstance(base, FunctionBlock) and base.name.lower() == wanted and base is not unit:
                yield from _all_blocks(base, sources)
                break
    yield from unit.blocks


def _literal(value: object) -> str:
    if isinstance(value, bool):
        return str(value).upper()
    if isinstance(value, int | float):
        return repr(value)
    text = str(value)
    if text.startswith("="):
        return text[1:]
    return "'" + text.replace("$", "$$").replace("'", "$'") + "'"


def _runtime(
    declared: Declarations,
    behaviour: Iterable[type],
    cycle_time: float,
    floating_point_exceptions: bool,
    check_bounds: bool,
) -> PlcRuntime:
    cycle_ns = round(cycle_time * 1e9)
    project = check(declared, predefined=lists_of_runtime(()), check_bounds=check_bounds)
    if project.faults:
        raise SourceError(list(project.faults))
    units = [
        unit.declared
        for unit in project.units.values()
        if unit.declared is not None and unit.declared not in declared.units
    ]
    programs = with_behaviour(
        [*declared.units, *units], behaviour, [block.type for block in project.blocks.values()]
    )
    bench = next(unit for unit in programs if unit.__iec__.name == _BENCH)
    assert issubclass(bench, ProgramClass)
    return PlcRuntime(
        [Task("Bench", cycle_ns, [bench])],
        [unit for unit in programs if unit is not bench],
        project="bench",
        bodies=Bodies(project, exceptions=floating_point_exceptions),
    )
