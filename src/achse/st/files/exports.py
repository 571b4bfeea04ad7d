"""Exports of TwinCAT 2 and CoDeSys 2.3: `.EXP`, text with one object or many.

A unit is its declaration, `(* @END_DECLARATION := '0' *)`, and a body: Structured Text and
instruction lists as they are, diagrams as keywords line by line. Actions follow their unit. Tasks
are in RESOURCE; libraries, visualisations and the configuration of the hardware are passed over.

Source: exports in public repositories.
"""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TypeVar

from achse.st.files.envelope import TaskDeclaration, head_of
from achse.st.files.owners import address_for_station, with_drawn_bodies
from achse.st.graphical.body import GraphicalBody
from achse.st.graphical.exports.charts import step_bodies
from achse.st.lexis.codes import Code
from achse.st.lexis.lexer import Defines
from achse.st.lexis.literals import literal_value, whole_number
from achse.st.lexis.source import Diagnostic, Source
from achse.st.syntax.nodes import changed
from achse.st.syntax.parser import Parsed, Parser
from achse.st.syntax.tree import NO_NOTE
from achse.st.syntax.units import Action, Function, FunctionBlock, GlobalList, Program, Unit

P = TypeVar("P")
U = TypeVar("U", bound=Unit)

_ENDS = {
    "VAR_GLOBAL": "END_VAR",
    "VAR_CONFIG": "END_VAR",
    "PROGRAM": "END_PROGRAM",
    "FUNCTION_BLOCK": "END_FUNCTION_BLOCK",
    "FUNCTION": "END_FUNCTION",
    "ACTION": "END_ACTION",
    "TYPE": "END_TYPE",
    "RESOURCE": "END_RESOURCE",
    "LIBRARY": "END_LIBRARY",
    "VISUALISATION": "END_VISUALISATION",
    "PLC_CONFIGURATION": "PLC_END",
}
_BEGIN = re.compile(rf"^[ \t]*({'|'.join(_ENDS)})\b", re.MULTILINE | re.IGNORECASE)
_DECLARED = re.compile(r"\(\*\s*@END_DECLARATION\b[^*]*\*\)")
_LIST_NAME = re.compile(r"\(\*\s*@GLOBAL_VARIABLE_LIST\s*:=\s*'([^']*)'")
_ACTION_HEAD = re.compile(r"\s*ACTION\s+(\w+)\s*:?", re.IGNORECASE)
_DRAWN = re.compile(r"\s*(_LD_BODY|_FBD_BODY|_CFC_BODY|_IL_BODY)\b")
_CHART = re.compile(r"\s*(?:INITIAL_)?STEP\s+\w+\s*:(?!=)", re.IGNORECASE)
_LIST = re.compile(
    r"\s*(?:\w+\s*:(?!=)\s*)?"
    r"(?:(?:LDN?|CALC?N?|JMPC?N?)[ \t]+[^\s:=;.\[(]|RETC?N?[ \t]*(?:\r?\n|$))",
    re.IGNORECASE,
)
_LANGUAGES = {"_LD_BODY": "EXP_LD", "_FBD_BODY": "EXP_FBD", "_CFC_BODY": "EXP_CFC",
              "_IL_BODY": "EXP_IL"}  # fmt: skip
_TASK = re.compile(r"\bTASK\s+(\w+)\s*\(([^()]*)\)\s*;", re.IGNORECASE)
_END_TASK = re.compile(r"\bEND_TASK\b", re.IGNORECASE)
_CALLED = re.compile(r"^\s*(\w+)\s*\(\s*\)\s*;", re.MULTILINE)
_CYCLE_NS = 10_000_000
"""Cycle of a task without an interval, which the vendor's system runs as often as it can."""


@dataclass(frozen=True, slots=True)
class _Object:
    """An object of an export: its kind and its range in the text."""

    kind: str
    start: int
    end: int


def parse_export(text: str, path: str, name: str, defines: Defines = ()) -> Parsed:
    """Return the units of an export and all that is wrong with it; raises nothing."""
    return _Export(text, path, name, defines).parsed()


def tasks_of_export(text: str) -> list[TaskDeclaration]:
    """Return the tasks of an export. Raises `SourceError`."""
    masked = _masked(text)
    tasks: list[TaskDeclaration] = []
    for item in _objects(masked):
        if item.kind == "RESOURCE":
            start = item.start
            for end in _END_TASK.finditer(masked, item.start, item.end):
                task = _TASK.search(masked, start, end.start())
                if task is not None:
                    tasks.append(_task(task, masked[task.end() : end.start()]))
                start = end.end()
    return tasks


def _task(match: "re.Match[str]", body: str) -> TaskDeclaration:
    facts = {
        key.strip().upper(): value.strip()
        for key, _, value in (item.partition(":=") for item in match[2].split(","))
    }
    priority = facts.get("PRIORITY", "20")
    interval = facts.get("INTERVAL")
    cycle = 0 if interval is None else _nanoseconds(interval)
    return TaskDeclaration(
        match[1],
        cycle or _CYCLE_NS,
        whole_number(priority, 20),
        tuple(_CALLED.findall(body)),
    )


def _nanoseconds(text: str) -> int:
    """Return the length of a TIME literal; 0 for anything else."""
    try:
        milliseconds = literal_value(text).value
    except ValueError:
        return 0
    return int(milliseconds) * 1_000_000 if isinstance(milliseconds, int) else 0


def _masked(text: str) -> str:
    """`text` with blanks for comments, strings and pragmas, and the same offsets."""
    pieces: list[str] = []
    position = depth = start = 0
    for token in re.finditer(r"\(\*|\*\)|'[^'\n]*'|\{[^{}\n]*\}", text):
        if token[0] == "(*":
            if not depth:
                pieces.append(text[position : token.start()])
                start = token.start()
            depth += 1
        elif token[0] == "*)":
            if depth == 1:
                pieces.append(_blank(text[start : token.end()]))
                position = token.end()
            depth = max(0, depth - 1)
        elif not depth:
            pieces.append(text[position : token.start()] + _blank(token[0]))
            position = token.end()
    pieces.append(_blank(text[start:]) if depth else text[position:])
    return "".join(pieces)


def _blank(text: str) -> str:
    return re.sub(r"[^\n]", " ", text)


def _objects(masked: str) -> Iterator[_Object]:
    position = 0
    while (begin := _BEGIN.search(masked, position)) is not None:
        kind = begin[1].upper()
        end = re.compile(rf"\b{_ENDS[kind]}\b", re.IGNORECASE).search(masked, begin.end())
        position = len(masked) if end is None else end.end()
        yield _Object(kind, begin.start(1), position)


def _add(units: list[Unit], unit: Unit) -> None:
    """Add a unit; the blocks of a list that is there join it."""
    if isinstance(unit, GlobalList):
        for number, other in enumerate(units):
            if isinstance(other, GlobalList) and other.name.lower() == unit.name.lower():
                units[number] = changed(other, blocks=(*other.blocks, *unit.blocks))
                return
    units.append(unit)


def _placed(unit: U) -> U:
    """Return a unit whose variables have places that the station knows or chooses."""
    if not isinstance(unit, Program | FunctionBlock | Function | GlobalList):
        return unit
    blocks = tuple(
        changed(
            block,
            variables=tuple(
                item
                if item.address is None
                else changed(
                    item,
                    address=changed(item.address, text=address_for_station(item.address.text)),
                )
                for item in block.variables
            ),
        )
        for block in unit.blocks
    )
    return changed(unit, blocks=blocks)


class _Export:
    """Puts units together from the objects of one export."""

    def __init__(self, text: str, path: str, name: str, defines: Defines) -> None:
        self._text = text
        self._masked = _masked(text)
        self._objects = list(_objects(self._masked))
        self._list_name = re.sub(r"\W", "_", name) or "GVL"
        self._defines = defines
        self._bodies: dict[int, tuple[GraphicalBody, int]] = {}
        """Drawn bodies and where they begin, by the start of their object."""
        self._next = len(text) + 1
        self._drawings: list[GraphicalBody] = []
        for item in self._objects:
            self._find_drawing(item)
        self._source = Source(text, path, (), self._drawings)
        self._faults: list[Diagnostic] = []

    def parsed(self) -> Parsed:
        units: list[Unit] = []
        for item in self._objects:
            match item.kind:
                case "PROGRAM" | "FUNCTION_BLOCK" | "FUNCTION":
                    units += self._unit(item)
                case "ACTION":
                    self._action(item, units)
                case "TYPE" | "VAR_GLOBAL" | "VAR_CONFIG":
                    for unit in self._read(item, self._name_of_list(item)):
                        _add(units, unit)
        trees = tuple(
            with_drawn_bodies(_placed(unit))
            if isinstance(unit, Program | FunctionBlock | Function)
            else _placed(unit)
            for unit in units
        )
        return Parsed(self._source, trees, tuple(self._faults))

    def _name_of_list(self, item: _Object) -> str:
        before = self._text.rfind("@GLOBAL_VARIABLE_LIST", 0, item.start)
        marked = _LIST_NAME.match(self._text, max(0, self._text.rfind("(*", 0, max(before, 0))))
        if item.kind == "TYPE" or marked is None:
            return self._list_name
        return re.sub(r"\W", "_", marked[1])

    def _read(self, item: _Object, list_name: str) -> tuple[Unit, ...]:
        parser = Parser(self._source, item.start, item.end, self._defines)
        return self._attempt(parser, lambda: parser.units(list_name)) or ()

    def _attempt(self, parser: Parser, read: Callable[[], P]) -> P | None:
        result = parser.attempt(read)
        self._faults += parser.faults
        return result

    # bodies ------------------------------------------------------------------------------------

    def _body_start(self, item: _Object) -> int | None:
        """Offset of the body of a unit or action; None for other objects."""
        if item.kind == "ACTION":
            head = _ACTION_HEAD.match(self._masked, item.start)
            return None if head is None else head.end()
        if item.kind not in ("PROGRAM", "FUNCTION_BLOCK", "FUNCTION"):
            return None
        declared = _DECLARED.search(self._text, item.start, item.end)
        return None if declared is None else declared.end()

    def _find_drawing(self, item: _Object) -> None:
        start = self._body_start(item)
        if start is None:
            return
        end = item.end - len(_ENDS[item.kind])
        drawn = _DRAWN.match(self._masked, start, end)
        if drawn is not None:
            language = _LANGUAGES[drawn[1].upper()]
        elif _CHART.match(self._masked, start, end):
            language = "EXP_SFC"
        elif _LIST.match(self._masked, start, end):
            language = "EXP_IL"
        else:
            return
        # Whole lines, so that columns in the drawing are those in the file.
        start = self._text.find("\n", start, end) + 1 or start
        line = self._text.count("\n", 0, start) + 1
        raw = self._text[start:end]
        body = GraphicalBody(language, raw.encode(), self._next, line)
        self._bodies[item.start] = body, start
        self._drawings.append(body)
        self._next += len(raw) + 2

    def _unit(self, item: _Object) -> Iterator[Unit]:
        drawn = self._bodies.get(item.start)
        if drawn is None:
            yield from self._read(item, self._list_name)
            return
        body, start = drawn
        parser = Parser(self._source, item.start, start, self._defines)
        unit = self._attempt(parser, lambda: head_of(parser))
        if unit is None:
            return
        unit = changed(unit, body=body)
        if body.language == "EXP_SFC" and not isinstance(unit, Function):
            unit = changed(unit, parts=tuple(self._step_actions(body, start)))
        yield unit

    def _action(self, item: _Object, units: list[Unit]) -> None:
        owner = units[-1] if units else None
        if not isinstance(owner, Program | FunctionBlock):
            message = "an ACTION without a unit: expected a PROGRAM or FUNCTION_BLOCK before it"
            self._faults.append(self._source.fault(item.start, message, Code.UNEXPECTED_TOKEN))
            return
        drawn = self._bodies.get(item.start)
        parts: tuple[Action, ...]
        if drawn is None:
            parser = Parser(self._source, item.start, item.end, self._defines)
            action = self._attempt(parser, parser.action)
            parts = () if action is None else (action,)
        else:
            head = _ACTION_HEAD.match(self._masked, item.start)
            assert head is not None
            parts = (Action(head[1], drawn[0], NO_NOTE, head.start(1)),)
            if drawn[0].language == "EXP_SFC":
                parts += tuple(self._step_actions(*drawn))
        units[-1] = replace(owner, parts=(*owner.parts, *parts))

    def _step_actions(self, body: GraphicalBody, offset: int) -> Iterator[Action]:
        """Return the statements of steps as actions of their unit."""
        for step in step_bodies(body.text):
            start = offset + step.start
            parser = Parser(self._source, start, offset + step.end, self._defines)
            statements = self._attempt(parser, parser.statements.statements)
            yield Action(step.action, statements or (), NO_NOTE, start)
