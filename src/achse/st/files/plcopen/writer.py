"""Sources as PLCopen XML (TC6): units, types and lists with their texts, and tasks.

Each declaration is there twice: as the elements of the schema, which any editor reads, and as text,
which says what the schema has no elements for. Methods, properties and interfaces are in the
`addData` that TwinCAT and CODESYS read. Bodies are written as text; those that are drawn are left
out and named.

Source: PLCopen TC6 XML schema 2.00; exports of TwinCAT in public repositories.
"""

import re
from bisect import bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from achse.iec.names import ELEMENTARY
from achse.st.files.envelope import TaskDeclaration
from achse.st.graphical.body import GraphicalBody
from achse.st.graphical.writer import IMPLICIT
from achse.st.lexis.source import Source
from achse.st.lexis.xml import escape
from achse.st.syntax.nodes import changed
from achse.st.syntax.parser import Parsed
from achse.st.syntax.printer import (
    print_expression,
    print_initial,
    print_statements,
    print_type,
    print_units,
)
from achse.st.syntax.tree import (
    NO_NOTE,
    ArrayOf,
    EnumOf,
    Expression,
    NamedType,
    PointerTo,
    Range,
    StringOf,
    StructOf,
    Subrange,
    TypeSpec,
    VarBlock,
)
from achse.st.syntax.units import (
    Accessor,
    Action,
    Body,
    Function,
    FunctionBlock,
    GlobalList,
    Interface,
    Method,
    Namespace,
    Program,
    Property,
    TypeDeclaration,
    Unit,
)

_NAMESPACE = "http://www.plcopen.org/xml/tc6_0200"
_XHTML = "http://www.w3.org/1999/xhtml"
_VENDOR = "http://www.3s-software.com/plcopenxml"
_SECTIONS = {
    "VAR_INPUT": "inputVars",
    "VAR_OUTPUT": "outputVars",
    "VAR_IN_OUT": "inOutVars",
    "VAR_TEMP": "tempVars",
    "VAR_EXTERNAL": "externalVars",
    "VAR_GLOBAL": "globalVars",
}
_QUALIFIERS = {"CONSTANT": "constant", "RETAIN": "retain", "PERSISTENT": "persistent"}
_KINDS = {Program: "program", FunctionBlock: "functionBlock", Function: "function"}
_ENDS = ("END_PROGRAM", "END_FUNCTION_BLOCK", "END_FUNCTION", "END_METHOD", "END_PROPERTY",
         "END_INTERFACE")  # fmt: skip
_KEYWORD = re.compile(
    r"\b(?:TYPE|VAR_GLOBAL|PROGRAM|FUNCTION|FUNCTION_BLOCK|METHOD|PROPERTY|INTERFACE)\b",
    re.IGNORECASE,
)
_OTHER_NAMES = {"time_of_day": "TOD", "date_and_time": "DT"}


@dataclass(slots=True)
class PlcopenDocument:
    """A document, and what it does not have."""

    text: str
    left_out: list[str] = field(default_factory=list)
    """Names of units and parts whose body is drawn, and of name spaces."""


def plcopen_document(
    sources: Iterable[Parsed], tasks: Sequence[TaskDeclaration], name: str, created: str
) -> PlcopenDocument:
    """Return sources as a document with a name; `created` is the time as XML has it."""
    return _Writer().document(sources, tasks, name, created)


def _element(tag: str, inside: str = "", **attributes: str) -> str:
    facts = "".join(f' {key}="{escape(value)}"' for key, value in attributes.items())
    return f"<{tag}{facts}>{inside}</{tag}>\n" if inside else f"<{tag}{facts} />\n"


def _data(kind: str, inside: str) -> str:
    return _element("data", inside, name=f"{_VENDOR}/{kind}", handleUnknown="implementation")


def _xhtml(text: str) -> str:
    return f'<xhtml xmlns="{_XHTML}">{escape(text)}</xhtml>'


def _plain(text: str) -> str:
    return _element("InterfaceAsPlainText", _xhtml(text))


class _Writer:
    """Writes one document."""

    def __init__(self) -> None:
        self._left_out: list[str] = []
        self._source = Source("")

    def document(
        self, sources: Iterable[Parsed], tasks: Sequence[TaskDeclaration], name: str, created: str
    ) -> PlcopenDocument:
        types, pous, lists, interfaces = "", "", "", ""
        for parsed in sources:
            self._source = parsed.source
            for unit in parsed.units:
                match unit:
                    case TypeDeclaration():
                        types += self._type(unit)
                    case GlobalList():
                        lists += self._list(unit)
                    case Interface():
                        interfaces += _data("interface", self._interface(unit))
                    case Namespace():
                        self._left_out.append(f"NAMESPACE {unit.name}")
                    case _:
                        pous += self._unit(unit)
        scales = "".join(
            _element(tag, _element("scaling", x="1", y="1")) for tag in ("fbd", "ld", "sfc")
        )
        header = _element(
            "fileHeader", companyName="", productName="achse", productVersion="",
            creationDateTime=created,
        )  # fmt: skip
        content = _element(
            "contentHeader", _element("coordinateInfo", scales), name=name,
            modificationDateTime=created,
        )  # fmt: skip
        resource = _element("resource", "".join(map(_task, tasks)) + lists, name="PLC")
        instances = _element("configurations", _element("configuration", resource, name=name))
        inside = header + content
        inside += _element("types", _element("dataTypes", types) + _element("pous", pous))
        inside += _element("instances", instances)
        inside += _element("addData", interfaces) if interfaces else ""
        head = '<?xml version="1.0" encoding="utf-8"?>\n'
        return PlcopenDocument(head + _element("project", inside, xmlns=_NAMESPACE), self._left_out)

    # texts -------------------------------------------------------------------------------------

    def _source_text(self, at: int) -> str:
        """Return the text of the file that a place is in; empty where one text has everything."""
        source = self._source
        if len(source.pieces) < 2 or not 0 <= at < len(source.text):
            return ""
        starts = [piece.start for piece in source.pieces]
        index = bisect_right(starts, at)
        end = starts[index] - 1 if index < len(starts) else len(source.text)
        return source.text[starts[index - 1] : end]

    def _declaration(self, unit: Unit | Method | Property) -> str:
        """Return the declaration of a unit or part as text."""
        text = self._source_text(unit.at)
        if _KEYWORD.search(text):
            return text
        match unit:
            case Method() | Function():
                bare: Unit | Method | Property = changed(unit, body=())
            case Property():
                bare = unit
            case FunctionBlock() | Program():
                bare = changed(unit, body=(), parts=(), blocks=_declared(unit.blocks))
            case Interface() | GlobalList():
                bare = changed(unit, parts=())
            case _:
                bare = unit
        if isinstance(bare, Method | Property):
            holder = FunctionBlock("_", (), (), (bare,), (), bare.note)
            lines = [line.strip() for line in print_units([holder]).split("\n")][1:-2]
            if isinstance(bare, Property):
                return lines[[line.startswith("PROPERTY") for line in lines].index(True)]
        else:
            lines = print_units([bare]).rstrip().split("\n")
        return "\n".join(line for line in lines if line.strip() not in _ENDS)

    def _added(self, unit: Unit, more: str = "") -> str:
        """Return the declaration as text, as vendors add it."""
        text = _plain(self._declaration(unit))
        return _element("addData", more + _data("interfaceasplaintext", text))

    def _body(self, body: Body, name: str) -> str:
        if isinstance(body, GraphicalBody) or body is None:
            self._left_out.append(name)
            text = ""
        else:
            text = self._source_text(body[0].at) if body else ""
            text = text or print_statements(body)
        return _element("body", _element("ST", _xhtml(text)))

    # units -------------------------------------------------------------------------------------

    def _type(self, unit: TypeDeclaration) -> str:
        inside = _element("baseType", self._spec(unit.type))
        if unit.initial is not None:
            inside += _initial(print_initial(unit.initial))
        inside += _element(
            "addData", _data("interfaceasplaintext", _plain(self._declaration(unit)))
        )
        return _element("dataType", inside, name=unit.name)

    def _list(self, unit: GlobalList) -> str:
        inside = "".join(self._variables(block) for block in unit.blocks)
        inside += _element(
            "addData", _data("interfaceasplaintext", _plain(self._declaration(unit)))
        )
        return _element("globalVars", inside, name=unit.name)

    def _unit(self, unit: Program | FunctionBlock | Function) -> str:
        parts = () if isinstance(unit, Function) else unit.parts
        returns = unit.returns if isinstance(unit, Function) else None
        inside = self._interface_of(unit.blocks, returns)
        actions = "".join(
            _element("action", self._body(part.body, f"{unit.name}.{part.name}"), name=part.name)
            for part in parts
            if isinstance(part, Action)
        )
        inside += _element("actions", actions) if actions else ""
        inside += self._body(unit.body, unit.name)
        added = "".join(self._part(part, unit.name) for part in parts)
        inside += self._added(unit, added)
        return _element("pou", inside, name=unit.name, pouType=_KINDS[type(unit)])

    def _part(self, part: Method | Property | Action, owner: str) -> str:
        match part:
            case Method():
                return _data("method", self._method(part, owner))
            case Property():
                return _data("property", self._property(part, owner))
        return ""

    def _method(self, part: Method, owner: str, *, has_body: bool = True) -> str:
        inside = self._interface_of(part.blocks, part.returns)
        inside += self._body(part.body, f"{owner}.{part.name}") if has_body else ""
        return _element("Method", inside + _plain(self._declaration(part)), name=part.name)

    def _property(self, part: Property, owner: str, *, has_body: bool = True) -> str:
        inside = self._interface_of((), part.type)
        for tag, accessor in (("GetAccessor", part.get), ("SetAccessor", part.set)):
            if accessor is not None:
                inner = self._interface_of(accessor.blocks, None)
                name = f"{owner}.{part.name}"
                inner += self._body(accessor.body, name) if has_body else ""
                inside += _element(tag, inner + _plain(self._head(accessor)))
        return _element("Property", inside + _plain(self._declaration(part)), name=part.name)

    def _head(self, accessor: Accessor) -> str:
        bare = Property("_", (), NamedType("BOOL"), changed(accessor, body=()), None, accessor.note)
        text = print_units([FunctionBlock("_", (), (), (bare,), (), accessor.note)])
        lines = [line.strip() for line in text.split("\n")]
        start = next(number for number, line in enumerate(lines) if line.startswith("GET"))
        modifiers = lines[start].removeprefix("GET").strip()
        return "\n".join([modifiers, *lines[start + 1 : lines.index("END_GET")]]).strip()

    def _interface(self, unit: Interface) -> str:
        methods = "".join(
            self._method(part, unit.name, has_body=False)
            for part in unit.parts
            if isinstance(part, Method)
        )
        properties = "".join(
            self._property(part, unit.name, has_body=False)
            for part in unit.parts
            if isinstance(part, Property)
        )
        inside = _element("Methods", methods) + _element("Properties", properties)
        return _element("Interface", inside + _plain(self._declaration(unit)), name=unit.name)

    # interfaces --------------------------------------------------------------------------------

    def _interface_of(self, blocks: Iterable[VarBlock], returns: TypeSpec | None) -> str:
        inside = "" if returns is None else _element("returnType", self._spec(returns))
        for block in _declared(blocks):
            facts = {_QUALIFIERS[word]: "true" for word in block.qualifiers if word in _QUALIFIERS}
            tag = _SECTIONS.get(block.section, "localVars")
            inside += _element(tag, self._variables(block), **facts)
        return _element("interface", inside)

    def _variables(self, block: VarBlock) -> str:
        text = ""
        for declaration in block.variables:
            inside = _element("type", self._spec(declaration.type))
            if declaration.initial is not None:
                inside += _initial(print_initial(declaration.initial))
            address = {} if declaration.address is None else {"address": declaration.address.text}
            for item in declaration.names:
                text += _element("variable", inside, name=item.name, **address)
        return text

    def _spec(self, spec: TypeSpec) -> str:
        match spec:
            case NamedType() if spec.name.lower() in ELEMENTARY:
                name = _OTHER_NAMES.get(spec.name.lower(), spec.name.upper())
                return _element(name.lower() if name in ("STRING", "WSTRING") else name)
            case StringOf():
                length = None if spec.length is None else print_expression(spec.length)
                return _element(
                    spec.family.lower(), **({} if length is None else {"length": length})
                )
            case ArrayOf():
                bounds = "".join(
                    _range("dimension", one) for one in spec.dimensions if one is not None
                )
                return _element("array", bounds + _element("baseType", self._spec(spec.element)))
            case PointerTo():
                return _element("pointer", _element("baseType", self._spec(spec.target)))
            case StructOf():
                block = VarBlock("VAR", (), spec.members, NO_NOTE)
                return _element("struct", self._variables(block))
            case EnumOf():
                values = "".join(
                    _element("value", name=one.name, **_valued(one.value)) for one in spec.values
                )
                return _element("enum", _element("values", values))
            case Subrange():
                bounds = _range("range", spec.limits)
                base = _element("baseType", self._spec(spec.base))
                return _element("subrangeSigned", bounds + base)
        return _element("derived", name=" ".join(print_type(spec).split()))


def _declared(blocks: Iterable[VarBlock]) -> tuple[VarBlock, ...]:
    """Blocks without what drawn bodies bring."""
    return tuple(block for block in blocks if IMPLICIT not in block.qualifiers)


def _range(tag: str, limits: Range) -> str:
    low, high = print_expression(limits.low), print_expression(limits.high)
    return _element(tag, lower=low, upper=high)


def _valued(value: Expression | None) -> dict[str, str]:
    return {} if value is None else {"value": print_expression(value)}


def _initial(text: str) -> str:
    return _element("initialValue", _element("simpleValue", value=" ".join(text.split())))


def _task(task: TaskDeclaration) -> str:
    inside = "".join(_element("pouInstance", name=name, typeName=name) for name in task.programs)
    seconds = f"PT{task.cycle_ns / 1_000_000_000:.9f}".rstrip("0").rstrip(".") + "S"
    return _element("task", inside, name=task.name, interval=seconds, priority=str(task.priority))
