"""Continuous function charts lowered to statements: elements one after the other, in their order.

An output of a function block is read from the instance when its consumer runs. The result of an
operator, function or method is kept until it is computed again; a consumer that runs before its
producer gets the result of the cycle before, which the unit keeps.

Source: CFC bodies of public TwinCAT 3 projects; when values are kept is our choice.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from typing import TypeAlias

from achse.st.graphical.body import BodyScope, GraphicalBody, Refused
from achse.st.graphical.boxes import COMPARISONS, BoxWriter, memory_of, sign_of_operator
from achse.st.graphical.execution_order import execution_order
from achse.st.graphical.function_charts import (
    ChartBox,
    ChartComposer,
    ChartInput,
    ChartLabel,
    ChartLeave,
    ChartOutput,
    ChartPin,
    ChartSelector,
    FunctionChart,
    Ordered,
    read_explicit_order,
    read_function_chart,
)
from achse.st.graphical.networks import Box, BoxInput, Modifier, NetworkOperand
from achse.st.graphical.writer import call_of, implicit_block
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.nodes import changed
from achse.st.syntax.tree import (
    Call,
    Expression,
    Jump,
    Label,
    Literal,
    Member,
    Name,
    NamedType,
    Return,
    Statements,
    TypeSpec,
    Unary,
    VarBlock,
)

ChartReader: TypeAlias = Callable[[str], FunctionChart]
"""Reads the chart of a body. Raises `Unexpected` for what its form does not have."""

_STANDARD_PINS = {
    ("SR", "S1"): "SET1",
    ("SR", "R"): "RESET",
    ("RS", "S"): "SET",
    ("RS", "R1"): "RESET1",
    ("CTU", "R"): "RESET",
    ("CTD", "LD"): "LOAD",
    ("CTUD", "R"): "RESET",
    ("CTUD", "LD"): "LOAD",
}
"""Pins that the standard's blocks and the vendor's name differently.

Source: IEC 61131-3 (2013) tables 43 and 45."""

_BITS = frozenset(("AND", "OR", "XOR", "NOT"))
_NAME = re.compile(r"[A-Za-z_]\w*", re.ASCII)
_BOOL = NamedType("BOOL")


def implicit_variables_of_function_chart(
    body: GraphicalBody, read: ChartReader = read_function_chart
) -> tuple[VarBlock, ...]:
    """Return what a unit keeps for a chart: structures, results that go back, edges."""
    try:
        chart = read(body.text)
    except Unexpected:
        return ()
    if not body.owner.keeps_memory:
        return ()
    variables: list[tuple[str, TypeSpec | str]] = [
        (_pin_variable(body, element.output.id), element.type)
        for element in chart.ordered
        if isinstance(element, ChartComposer)
    ]
    connections = _Connections(body, chart)
    for element in connections.looking_back:
        type = connections.type_of(element)
        if type is not None:
            variables.append((_pin_variable(body, element.outputs[0].id), type))
    variables += [
        (memory_of(body, f"pin{pin.id}"), "BOOL")
        for element in chart.ordered
        for pin in _inputs_of(element)
        if pin.edge
    ]
    return (implicit_block(variables),) if variables else ()


def lowered_function_chart(
    body: GraphicalBody, scope: BodyScope, read: ChartReader = read_function_chart
) -> Statements:
    """Return the statements of a chart. Raises `Refused` and `Unexpected`."""
    try:
        chart = read(body.text)
    except Unexpected as fault:
        raise Refused(body.name_place(fault.at, "the chart"), fault.message, fault.code) from None
    ordered = tuple(
        _with_names(element, scope) if isinstance(element, ChartBox) else element
        for element in chart.ordered
    )
    chart = changed(chart, ordered=ordered)
    return _Lowering(body, scope, _Connections(body, chart)).statements()


def _with_names(element: ChartBox, scope: BodyScope) -> ChartBox:
    """Return a box of a unit whose pins have only an order gets their names, and the kind of the
    unit."""
    if element.call == "Operator":
        return element
    pins = scope.pins(element.type)
    if pins is None:
        return element
    if element.call == "Function" and pins.kind == "Program":
        element = changed(element, call="Program")
    if not any(pin.name for pin in (*element.inputs, *element.outputs)):
        inputs = _in_order(element.inputs, pins.inputs)
        return changed(element, inputs=inputs, outputs=_in_order(element.outputs, pins.outputs))
    if element.call == "Function" and pins.outputs:
        known = {name.lower() for name in pins.outputs}
        outputs = (  # files name the result as they like
            pin if pin.name.lower() in known else changed(pin, name=pins.outputs[0])
            for pin in element.outputs
        )
        element = changed(element, outputs=tuple(outputs))
    return changed(
        element,
        inputs=tuple(_renamed(pin, element.type, pins.inputs) for pin in element.inputs),
    )


def _renamed(pin: ChartPin, type: str, names: Sequence[str]) -> ChartPin:
    """Return a pin, with the vendor's name for one with the standard's."""
    other = _STANDARD_PINS.get((type.upper(), pin.name.upper()))
    if other is None or pin.name.lower() in (name.lower() for name in names):
        return pin
    return changed(pin, name=other)


def _in_order(pins: Sequence[ChartPin], names: Sequence[str]) -> tuple[ChartPin, ...]:
    return tuple(changed(pin, name=name) for pin, name in zip(pins, names, strict=False))


def _pin_variable(body: GraphicalBody, id: int) -> str:
    return f"__{body.owner.unit}_{body.owner.part}_pin{id}"


def _inputs_of(element: Ordered) -> Sequence[ChartPin]:
    """Return the input pins of an element, EN first."""
    match element:
        case ChartOutput() | ChartSelector() | ChartLeave():
            return (element.input,)
        case ChartLabel():
            return ()
        case ChartBox(enable=ChartPin() as enable):
            return (enable, *element.inputs)
    return element.inputs


def _outputs_of(element: Ordered) -> Sequence[ChartPin]:
    """Return the output pins of an element, ENO first."""
    match element:
        case ChartOutput() | ChartLeave() | ChartLabel():
            return ()
        case ChartComposer():
            return (element.output,)
        case ChartBox(enable_output=ChartPin() as enable):
            return (enable, *element.outputs)
    return element.outputs


class _Connections:
    """A chart in its order of execution, and what leads to each of its pins."""

    def __init__(self, body: GraphicalBody, chart: FunctionChart) -> None:
        self.source = dict(chart.sources)
        """Pins that others lead to, by those."""
        self.texts: dict[int, ChartInput] = {one.output.id: one for one in chart.inputs}
        self.producers: dict[int, tuple[Ordered, ChartPin]] = {
            pin.id: (element, pin) for element in chart.ordered for pin in _outputs_of(element)
        }
        self.passed: dict[int, ChartPin] = {
            pin.id: pin for element in chart.ordered for pin in _inputs_of(element) if pin.is_in_out
        }
        self._variables = body.owner.variables
        is_explicit = read_explicit_order(body.settings)
        if is_explicit is None:
            is_explicit = not chart.knows_feedback
        self.order = list(chart.ordered)
        if not is_explicit:
            self.order = execution_order(self.order, self._edges(self.order))
        self.position = {id(element): number for number, element in enumerate(self.order)}

    def _edges(self, elements: Sequence[Ordered]) -> Iterator[tuple[int, int]]:
        """Yield numbers of elements: `(producer, consumer)`."""
        number = {id(element): index for index, element in enumerate(elements)}
        for index, element in enumerate(elements):
            for pin in _inputs_of(element):
                producer = self.producers.get(self.source.get(pin.id, -1))
                if producer is not None:
                    yield number[id(producer[0])], index

    @property
    def looking_back(self) -> list[ChartBox]:
        """Boxes whose result is read before they run: of operators, functions and methods."""
        boxes: dict[int, ChartBox] = {}
        for element in self.order:
            for pin in _inputs_of(element):
                producer = self.producers.get(self.source.get(pin.id, -1))
                if producer is None or not (
                    self.is_back(producer[0], element) or self._may_be_old(producer, element)
                ):
                    continue
                box = producer[0]
                if not isinstance(box, ChartBox) or box.call not in _WITH_RESULT:
                    continue
                if producer[1] is not box.outputs[0]:
                    continue
                if not self._is_stored(box, element, pin):
                    boxes[id(box)] = box
        return list(boxes.values())

    def _may_be_old(self, producer: tuple[Ordered, ChartPin], consumer: Ordered) -> bool:
        """Return True if a box reads the result of one that its EN may have left out."""
        box, pin = producer
        return (
            isinstance(box, ChartBox)
            and box.enable is not None
            and pin is not box.enable_output
            and not isinstance(consumer, ChartOutput)
        )

    def is_back(self, producer: Ordered, consumer: Ordered) -> bool:
        """Return True if a consumer runs before its producer."""
        return self.position[id(producer)] >= self.position[id(consumer)]

    def _is_stored(self, producer: ChartBox, element: Ordered, pin: ChartPin) -> bool:
        """Return True if a result is written to the input of an instance, which keeps it."""
        return (
            isinstance(element, ChartBox)
            and element.call == "FunctionBlock"
            and not pin.is_in_out
            and self.type_of(producer) is None
        )

    def type_of(self, element: ChartBox) -> TypeSpec | None:
        """Return the type of a result as far as the declarations of the unit show it."""
        return self._type(element, set())

    def _type(self, element: ChartBox, seen: set[int]) -> TypeSpec | None:
        if id(element) in seen or element.call != "Operator":
            return None
        seen.add(id(element))
        operator = element.type.upper()
        if sign_of_operator(operator) in COMPARISONS:
            return _BOOL
        if "TO_" in operator and operator != "MOVE":
            return NamedType(operator.rpartition("TO_")[2])
        pins = element.inputs[1:] if operator in ("SEL", "MUX") else element.inputs
        for pin in pins:
            source = self.source.get(pin.id, -1)
            if source in self.texts:
                text = self.texts[source].text
                if _NAME.fullmatch(text) and text.lower() in self._variables:
                    return self._variables[text.lower()]
                if text.upper() in ("TRUE", "FALSE"):
                    return _BOOL
            producer = self.producers.get(source)
            if producer is not None and isinstance(producer[0], ChartBox):
                type = self._type(producer[0], seen)
                if type is not None:
                    return type
        ids = {output.id for output in element.outputs}
        for consumer in self.order:
            if isinstance(consumer, ChartOutput) and self.source.get(consumer.input.id) in ids:
                type = self._variables.get(consumer.text.lower())
                if type is not None:
                    return type
        return _BOOL if operator in _BITS else None


_WITH_RESULT = ("Operator", "Function", "Method", "LocalMethod")


class _Lowering(BoxWriter):
    """Writes the statements of one chart."""

    def __init__(self, body: GraphicalBody, scope: BodyScope, connections: _Connections) -> None:
        super().__init__(body, scope)
        self._of = connections
        self._results: dict[int, Expression] = {}
        """Results so far, by the pin."""
        self._enables: dict[int, Expression] = {}
        """Values of EN so far, by the box."""
        self._stored_pins = {
            box.outputs[0].id: box
            for box in connections.looking_back
            if connections.type_of(box) is not None
        }

    def statements(self) -> Statements:
        for number, element in enumerate(self._of.order, 1):
            match element:
                case ChartOutput():
                    self.location = f"output {element.text} ({number})"
                    self._write_output(element)
                case ChartBox():
                    self.location = (
                        f"box {element.type} {element.instance}".rstrip() + f" ({number})"
                    )
                    self._write_box(element)
                case ChartComposer():
                    self.location = f"composer {element.type} ({number})"
                    self._write_composer(element)
                case ChartSelector():
                    self.location = f"selector {element.type} ({number})"
                    self.at(element.at)
                case ChartLabel():
                    self.location = f"label {element.name}"
                    self.out.append(Label(element.name, self.at(element.at)))
                case ChartLeave():
                    self.location = (
                        f"jump {element.label} ({number})" if element.label else "return"
                    )
                    self._write_leave(element)
        return tuple(self.out)

    # values ------------------------------------------------------------------------------------

    def _input(self, pin: ChartPin, consumer: Ordered, at: int) -> Expression | None:
        """Return the value at an input pin; None for one that is not wired."""
        source = self._of.source.get(pin.id)
        value = None if source is None else self._source(source, consumer, at)
        if value is None:
            return None
        modifiers = pin.edge | (Modifier.NEGATED if pin.is_negated else 0)
        return self.modified(value, modifiers, f"pin{pin.id}", at)

    def _source(self, id: int, consumer: Ordered, at: int) -> Expression | None:
        """Return the value of a pin; None if the pin is gone."""
        text = self._of.texts.get(id)
        if text is not None:
            return self.expression(text.text, at) if text.text else None
        passed = self._of.passed.get(id)
        if passed is not None:
            return self._input(passed, consumer, at)
        producer = self._of.producers.get(id)
        if producer is None:
            return None
        element, pin = producer
        value = self._produced(element, pin, consumer, at)
        return Unary("NOT", value, at) if pin.is_negated else value

    def _produced(self, element: Ordered, pin: ChartPin, consumer: Ordered, at: int) -> Expression:
        if isinstance(element, ChartSelector):
            whole = self._input(element.input, consumer, at)
            if whole is None:
                raise Refused(
                    at, f"the selector {element.type} has no input", Code.INCOMPLETE_DRAWING
                )
            return Member(whole, pin.name, at)
        if isinstance(element, ChartComposer) or pin.id in self._stored_pins:
            return Name(_pin_variable(self.body, pin.id), at)
        assert isinstance(element, ChartBox)
        if pin is element.enable_output and pin.id in self._results:
            return self._results[pin.id]
        if element.call == "FunctionBlock" and pin is not element.enable_output:
            return Member(self._instance(element, at), pin.name, at)
        if element.call == "Program":
            return Member(self.expression(element.type, at), pin.name, at)
        if pin.id not in self._results:
            raise Refused(
                at,
                f"{element.type} is read before it runs, and its type is not known",
                Code.INCOMPLETE_DRAWING,
            )
        return self._results[pin.id]

    def _instance(self, element: ChartBox, at: int) -> Expression:
        if element.instance.upper().replace(" ", "") == "SUPER^":
            return self.expression("THIS^", at)
        if not element.instance or element.instance == "???":
            raise Refused(at, f"the box {element.type} has no instance", Code.INCOMPLETE_DRAWING)
        return self.expression(element.instance, at)

    # elements ----------------------------------------------------------------------------------

    def _write_output(self, element: ChartOutput) -> None:
        at = self.at(element.at)
        value = self._input(element.input, element, at)
        if value is None:
            return
        if not element.text or element.text == "???":
            raise Refused(
                at,
                "an output is not filled in: expected a variable, got '???'",
                Code.INCOMPLETE_DRAWING,
            )
        operator = {"Set": "S=", "Reset": "R="}.get(element.storing, ":=")
        target = self.expression(element.text, at)
        producer = self._of.producers.get(self._of.source.get(element.input.id, -1))
        enable = None
        if producer is not None and isinstance(producer[0], ChartBox):
            enable = self._enables.get(id(producer[0]))
            if producer[1] is producer[0].enable_output:
                enable = None
        self.when(enable, lambda: self.assign(target, value, at, operator), at)

    def _write_leave(self, element: ChartLeave) -> None:
        at = self.at(element.at)
        value = self._input(element.input, element, at) or Literal("boolean", "TRUE", at)
        self.leave(Jump(element.label, at) if element.label else Return(at), value, at)

    def _write_composer(self, element: ChartComposer) -> None:
        at = self.at(element.at)
        if not self.body.owner.keeps_memory:
            raise Refused(
                at, "a function keeps no memory: a composer needs one", Code.INCOMPLETE_DRAWING
            )
        for pin in element.inputs:
            value = self._input(pin, element, at)
            if value is not None:
                target = Member(Name(_pin_variable(self.body, element.output.id), at), pin.name, at)
                self.assign(target, value, at)

    def _arguments(self, element: ChartBox, at: int) -> list[tuple[str, Expression, bool]]:
        arguments = []
        for pin in element.inputs:
            if self._comes_later(pin, element):
                continue
            value = self._input(pin, element, at)
            if value is not None:
                arguments.append((pin.name, value, False))
        return arguments

    def _comes_later(self, pin: ChartPin, element: ChartBox) -> bool:
        """Return True if a result was stored into the instance's input when it was computed."""
        producer = self._of.producers.get(self._of.source.get(pin.id, -1))
        return (
            producer is not None
            and element.call == "FunctionBlock"
            and not pin.is_in_out
            and isinstance(producer[0], ChartBox)
            and producer[0].call in _WITH_RESULT
            and producer[1].id not in self._stored_pins
            and self._of.is_back(producer[0], element)
        )

    def _write_box(self, element: ChartBox) -> None:
        at = self.at(element.at)
        enable: Expression | None = None
        if element.enable is not None:
            enable = self._input(element.enable, element, at)
        if enable is not None:
            enable = self._enables[id(element)] = self.let(self.hidden("en"), enable, at)
        if element.enable_output is not None:
            eno = enable or Literal("boolean", "TRUE", at)
            self._results[element.enable_output.id] = eno
        self.when(enable, lambda: self._execute(element, at), at)

    def _execute(self, element: ChartBox, at: int) -> None:
        match element.call:
            case "FunctionBlock":
                instance = self._instance(element, at)
                if element.instance.upper().replace(" ", "") == "SUPER^":
                    instance = self.expression("SUPER^", at)
                self.out.append(call_of(instance, self._arguments(element, at), at))
            case "Program":
                of = self.expression(element.type, at)
                self.out.append(call_of(of, self._arguments(element, at), at))
            case "Operator":
                self._result(element, self._of_operator(element, at), at)
            case "Function" | "Method" | "LocalMethod":
                self._of_routine(element, at)
            case _:
                raise Refused(
                    at,
                    f"a call of kind '{element.call[:20]}' is not supported",
                    Code.UNSUPPORTED_DRAWING,
                )

    def _of_operator(self, element: ChartBox, at: int) -> Expression:
        inputs = []
        for pin in element.inputs:
            value = self._input(pin, element, at)
            if value is not None:
                inputs.append((BoxInput("", "", NetworkOperand("", 0, 0), 0), value))
        box = Box(element.type, "", element.type, (), (), None, None, None, 0, 0)
        return self.operator(box, inputs, at)

    def _of_routine(self, element: ChartBox, at: int) -> None:
        name = element.type.rpartition(".")[2]
        of = self.expression(element.type, at)
        if element.call == "LocalMethod":
            of = Name(name, at)
        elif element.call == "Method":
            of = Member(self._instance(element, at), name, at)
        arguments = self._arguments(element, at)
        result: ChartPin | None = None
        for number, pin in enumerate(element.outputs):
            if pin.name.lower() == name.lower() or (number == 0 and not pin.name):
                result = pin
                continue
            consumers = [
                one for one in self._of.order for into in _inputs_of(one)
                if self._of.source.get(into.id) == pin.id
            ]  # fmt: skip
            for one in consumers:
                if not isinstance(one, ChartOutput) or len(consumers) > 1:
                    raise Refused(
                        at, f"{element.type}: output {pin.name} leads to a box", Code.BAD_DRAWING
                    )
                arguments.append((pin.name, self.expression(one.text, at), True))
        call = call_of(of, arguments, at)
        if result is None:
            self.out.append(call)
        else:
            self._result(element, call, at)

    def _result(self, element: ChartBox, value: Expression, at: int) -> None:
        """Keep a result for its consumers."""
        if not element.outputs:
            return
        pin = element.outputs[0]
        consumers = [
            (one, into) for one in self._of.order for into in _inputs_of(one)
            if self._of.source.get(into.id) == pin.id
        ]  # fmt: skip
        if pin.id in self._stored_pins:
            self.assign(Name(_pin_variable(self.body, pin.id), at), value, at)
            return
        if not consumers and element.call != "Operator" and isinstance(value, Call):
            self.out.append(value)
            return
        result = self._results[pin.id] = self.let(self.hidden("result"), value, at)
        for consumer, into in consumers:
            if isinstance(consumer, ChartBox) and self._comes_later(into, consumer):
                stored = Unary("NOT", result, at) if pin.is_negated != into.is_negated else result
                self.assign(Member(self._instance(consumer, at), into.name, at), stored, at)
