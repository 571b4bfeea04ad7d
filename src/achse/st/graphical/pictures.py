"""Drawn bodies as text: rungs with their power, charts with their active steps.

`value` gives the value of a variable by its text, None where it is not known: then the picture is
that of the drawing alone. A line with power is double.

Source: IEC 61131-3 (2013) tables 73 to 76 for the signs.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from typing import TypeAlias

from achse.st.graphical.boxes import operator_of
from achse.st.graphical.chart_flow import StepFlow
from achse.st.graphical.charts import ChartStep
from achse.st.graphical.function_charts import (
    ChartBox,
    ChartComposer,
    ChartLabel,
    ChartLeave,
    ChartOutput,
    ChartPin,
    ChartSelector,
    FunctionChart,
    Ordered,
)
from achse.st.graphical.networks import (
    Assignment,
    Box,
    DrawnNetwork,
    Modifier,
    NetworkList,
    NetworkNode,
    NetworkOperand,
    NetworkWire,
    Parallel,
    Unconnected,
)

OperandValue: TypeAlias = Callable[[str], object | None]
"""The value of an expression while the program runs; None if it is not known."""

_Power: TypeAlias = bool | None
_VARIABLE = re.compile(r"(?!TRUE\b|FALSE\b)[A-Za-z_](?!\w*#)", re.ASCII | re.IGNORECASE)
_OFF, _ON = "─", "═"


def no_value(text: str) -> object | None:
    """No value, for the picture of the drawing alone."""
    return None


class _Block:
    """A part of a rung: its lines, the row of its wire, and the power behind it."""

    def __init__(self, rows: Sequence[str], wire: int, power: _Power) -> None:
        width = max(map(len, rows))
        self.rows = [
            row + _line(power) * (width - len(row)) if number == wire else row.ljust(width)
            for number, row in enumerate(rows)
        ]
        self.wire = wire
        self.power = power

    @property
    def width(self) -> int:
        return len(self.rows[0])


def _line(power: _Power) -> str:
    return _ON if power else _OFF


def _series(left: _Block, right: _Block) -> _Block:
    """Two parts, one behind the other."""
    above = max(left.wire, right.wire)
    below = max(len(left.rows) - left.wire, len(right.rows) - right.wire)
    rows = []
    for number in range(-above, below):
        first, second = (
            one.rows[one.wire + number] if 0 <= one.wire + number < len(one.rows)
            else " " * one.width
            for one in (left, right)
        )  # fmt: skip
        rows.append(first + (_line(left.power) if number == 0 else " ") + second)
    return _Block(rows, above, right.power)


def _branches(parts: Sequence[_Block], before: _Power) -> _Block:
    """Parts below each other, between two bars."""
    power: _Power = None if any(one.power is None for one in parts) else False
    power = True if any(one.power for one in parts) else power
    width = max(one.width for one in parts)
    rows: list[str] = []
    wires = []
    for one in parts:
        wires.append(len(rows) + one.wire)
        rows += [
            row + (_line(one.power) if number == one.wire else " ") * (width - len(row))
            for number, row in enumerate(one.rows)
        ]
    framed = []
    for number, row in enumerate(rows):
        sign = "┬" if number == wires[0] else "└" if number == wires[-1] else "├"
        close = "┬" if number == wires[0] else "┘" if number == wires[-1] else "┤"
        inside = wires[0] < number < wires[-1]
        if number not in wires:
            sign = close = "│" if inside else " "
        framed.append(f"{sign}{row}{close}")
    return _Block(framed, wires[0], power if parts else before)


class _Networks:
    """Draws the networks of one body."""

    def __init__(self, value: OperandValue) -> None:
        self._value = value
        self._wires: dict[int, _Power] = {}

    def lines(self, networks: NetworkList) -> Iterator[str]:
        for network in networks.networks:
            yield self._head(network)
            if network.is_disabled:
                continue
            for line in network.lines:
                sign = f"{line.prefix}{line.operator} {line.operand.text}{line.postfix}".strip()
                yield f"    {sign}{self._shown(line.operand.text)}"
            for item in network.items:
                yield from (f"    {row}".rstrip() for row in self._item(item).rows)

    def _head(self, network: DrawnNetwork) -> str:
        label = f"{network.label}: " if network.label else ""
        title = f" {network.title.splitlines()[0]}" if network.title else ""
        off = " (commented out)" if network.is_disabled else ""
        return f"{label}network {network.number}{title}{off}"

    def _shown(self, text: str) -> str:
        return _shown_value(text, self._value)

    def _item(self, node: NetworkNode) -> _Block:
        power = None if self._value is no_value else True
        return _series(_Block(["├"], 0, power), self._node(node, power))

    def _truth(self, node: NetworkOperand) -> _Power:
        """Return the power behind a contact; unknown for an edge."""
        value = self._value(node.text)
        if not isinstance(value, bool) or node.modifiers & (Modifier.RISING | Modifier.FALLING):
            return None
        return not value if node.modifiers & Modifier.NEGATED else value

    def _node(self, node: NetworkNode, power: _Power) -> _Block:
        match node:
            case Unconnected():
                return _Block([_line(power)], 0, power)
            case NetworkOperand():
                return self._contact(node, power)
            case NetworkWire(input=None):
                wire = _both(power, self._wires.get(node.number))
                return _Block([f"<{node.number}>"], 0, wire)
            case NetworkWire():
                assert node.input is not None
                block = self._node(node.input, power)
                self._wires[node.number] = block.power
                return _series(block, _Block([f"<{node.number}>"], 0, block.power))
            case Parallel():
                parts = [self._node(one, power) for one in node.branches]
                joint = _branches(parts, power)
                if node.input is not None:
                    joint = _series(self._node(node.input, power), joint)
                return joint
            case Assignment():
                coils = [self._coil(one) for one in node.targets]
                rung = None if node.value is None else self._node(node.value, power)
                behind = power if rung is None else rung.power
                ends = [_Block([one], 0, behind) for one in coils or [""]]
                joined = ends[0] if len(ends) == 1 else _branches(ends, behind)
                return joined if rung is None else _series(rung, joined)
            case Box():
                return self._box(node, power)

    def _contact(self, node: NetworkOperand, power: _Power) -> _Block:
        value = self._value(node.text)
        if value is not None and not isinstance(value, bool):
            return _Block([f"{node.text} = {value}"], 0, None)
        sign = "/" if node.modifiers & Modifier.NEGATED else " "
        sign = "P" if node.modifiers & Modifier.RISING else sign
        sign = "N" if node.modifiers & Modifier.FALLING else sign
        return _Block([f"┤{sign}{node.text} ├"], 0, _both(power, self._truth(node)))

    def _coil(self, node: NetworkOperand) -> str:
        if node.modifiers & Modifier.JUMP:
            return f">>{node.text}"
        if node.modifiers & Modifier.RETURN:
            return "<RETURN>"
        sign = "/" if node.modifiers & Modifier.NEGATED else " "
        if node.modifiers & Modifier.SET:
            sign = "R" if node.modifiers & Modifier.NEGATED else "S"
        return f"({sign}{node.text} ){self._shown(node.text)}"

    def _box(self, node: Box, power: _Power) -> _Block:
        kind = operator_of(node)
        if kind in ("and", "or") and node.enable is None and not node.modifiers:
            if kind == "or":
                return _branches([self._node(pin.node, power) for pin in node.inputs], power)
            block: _Block | None = None
            for pin in node.inputs:
                behind = power if block is None else block.power
                part = self._node(pin.node, behind)
                block = part if block is None else _series(block, part)
            if block is not None:
                return block
        first = node.enable or next(iter(node.inputs), None)
        fed = None if first is None else self._node(first.node, power)
        pins = [one for one in node.inputs if one is not first]
        lines = [f"{pin.name} := " * bool(pin.name) + self._text(pin.node) for pin in pins]
        for output in node.outputs:
            if output.target is not None:
                name = output.name.strip("' ") or "="
                lines.append(f"{name} => {output.target.text}{self._shown(output.target.text)}")
        title = f"{node.type} {node.instance}".strip()
        name = "" if first is None else first.name
        width = max(len(title) + 2, *(len(one) for one in (*lines, name)), 3)
        rows = [f"┌{title:─^{width}}┐", f"┤{name:<{width}}├"]
        rows += [f"│{one:<{width}}│" for one in lines] + [f"└{'─' * width}┘"]
        read = next((one.name for one in node.outputs if one.is_read), "")
        result = self._value(f"{node.instance}.{read}") if node.instance and read else None
        block = _Block(rows, 1, result if isinstance(result, bool) else None)
        return block if fed is None else _series(fed, block)

    def _text(self, node: NetworkNode) -> str:
        """Return a node in a line."""
        match node:
            case NetworkOperand():
                sign = "NOT " if node.modifiers & Modifier.NEGATED else ""
                return f"{sign}{node.text}{self._shown(node.text)}"
            case NetworkWire():
                return f"<{node.number}>"
            case Box():
                inside = ", ".join(self._text(pin.node) for pin in node.inputs)
                return f"{node.instance or node.type}({inside})"
        return "…"


def _both(left: _Power, right: _Power) -> _Power:
    if left is False or right is False:
        return False
    return None if left is None or right is None else True


def network_lines(networks: NetworkList, value: OperandValue = no_value) -> list[str]:
    """Return networks as lines of text."""
    return list(_Networks(value).lines(networks))


def chart_lines(flow: StepFlow, value: OperandValue = no_value) -> list[str]:
    """Return a sequential function chart as lines of text; active steps have a star."""
    lines: list[str] = []
    for step in flow.steps:
        star = "*" if value(f"{step.name}.x") is True else " "
        frame = f"[[{step.name}]]" if step.is_initial else f"[{step.name}]"
        lines.append(f"{star} {frame}{_actions(step)}")
        for firing in flow.firings:
            if firing.left[-1] is step:
                others = [one.name for one in firing.left[:-1]]
                joined = f" with {', '.join(others)}" if others else ""
                text = firing.transition.text
                shown = _readable(text, "(drawn)") + _shown_value(text, value)
                targets = ", ".join(one.name for one in firing.activated)
                lines.append(f"    ┼ {shown}{joined} → {targets}")
    return lines


def _readable(name: str, unnamed: str) -> str:
    """Return a name of the user, or a general word for an unnamed element."""
    return unnamed if name.startswith("__") else name


def _shown_value(text: str, value: OperandValue) -> str:
    """Return the value of a variable as an addition to its text; none of a literal."""
    shown = value(text) if _VARIABLE.match(text) else None
    return "" if shown is None else f" = {shown}"


def _actions(step: ChartStep) -> str:
    named = [
        f"{word} {_readable(name, '(statements)')}"
        for word, name in (("entry", step.entry), ("main", step.main), ("exit", step.exit))
        if name
    ]
    named += [
        f"{one.qualifier}{' ' + one.time if one.time else ''} {_readable(one.name, '(statements)')}"
        for one in step.associations
    ]
    return f"  {'; '.join(named)}" if named else ""


def function_chart_lines(chart: FunctionChart, value: OperandValue = no_value) -> list[str]:
    """Return a function chart as lines of text, an element each in the order of the file."""
    return list(_Elements(chart, value).lines())


class _Elements:
    """Names the elements of a function chart."""

    def __init__(self, chart: FunctionChart, value: OperandValue) -> None:
        self._chart = chart
        self._value = value
        self._source = dict(chart.sources)
        self._texts = {one.output.id: one.text for one in chart.inputs}
        self._names: dict[int, str] = {}
        for number, element in enumerate(chart.ordered, 1):
            match element:
                case ChartBox():
                    pins = element.outputs
                    if element.enable_output is not None:
                        pins = (*pins, element.enable_output)
                    base = element.instance or f"#{number}"
                    for pin in pins:
                        self._names[pin.id] = f"{base}.{pin.name}" if pin.name else base
                case ChartComposer():
                    self._names[element.output.id] = f"#{number}"
                case ChartSelector():
                    for pin in element.outputs:
                        self._names[pin.id] = f"#{number}.{pin.name}"

    def lines(self) -> Iterator[str]:
        for number, element in enumerate(self._chart.ordered, 1):
            yield f"{number:>4}  {self._line(element)}"

    def _line(self, element: Ordered) -> str:
        match element:
            case ChartOutput():
                sign = {"Set": "S=", "Reset": "R="}.get(element.storing, ":=")
                return (
                    f"{element.text} {sign} {self._pin(element.input)}{self._shown(element.text)}"
                )
            case ChartLabel():
                return f"{element.name}:"
            case ChartLeave():
                leave = f"JMP {element.label}" if element.label else "RETURN"
                return f"IF {self._pin(element.input)} THEN {leave}"
            case ChartSelector():
                return f"{element.type} of {self._pin(element.input)}"
            case ChartComposer():
                return f"{element.type}({', '.join(map(self._named, element.inputs))})"
        pins = element.inputs if element.enable is None else (element.enable, *element.inputs)
        name = f"{element.instance} : {element.type}" if element.instance else element.type
        return f"{name}({', '.join(map(self._named, pins))})"

    def _named(self, pin: ChartPin) -> str:
        return f"{pin.name} := {self._pin(pin)}" if pin.name else self._pin(pin)

    def _pin(self, pin: ChartPin) -> str:
        """Return the source of a pin as text."""
        source = self._source.get(pin.id, 0)
        text = self._texts.get(source) or self._names.get(source, "…")
        sign = "NOT " if pin.is_negated else ""
        sign = {Modifier.RISING: "↑", Modifier.FALLING: "↓"}.get(Modifier(pin.edge), "") + sign
        return f"{sign}{text}{self._shown(text)}"

    def _shown(self, text: str) -> str:
        return _shown_value(text, self._value)
