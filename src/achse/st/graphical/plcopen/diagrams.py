"""Ladders and function block diagrams in PLCopen XML as function charts.

A contact is an AND of what leads to it and its variable, several connections on one pin are an OR,
a coil is an output. Networks are elements that are connected, rails aside; they run from top to
bottom, or by the order that the file has, elements of one by their data flow.

Source: PLCopen TC6 XML schema 2.01; IEC 61131-3 (2013) §8; order without numbers is our choice.
"""

from collections.abc import Iterable

from achse.st.graphical.boxes import UNFINISHED, call_of_operator
from achse.st.graphical.execution_order import execution_order
from achse.st.graphical.function_charts import (
    ChartBox,
    ChartInput,
    ChartLabel,
    ChartLeave,
    ChartOutput,
    ChartPin,
    FunctionChart,
    Ordered,
)
from achse.st.graphical.networks import Modifier
from achse.st.graphical.plcopen.elements import DiagramElements, connections_of
from achse.st.lexis.codes import Code
from achse.st.lexis.literals import whole_number
from achse.st.lexis.xml import Element

_EDGES = {"": 0, "none": 0, "rising": int(Modifier.RISING), "falling": int(Modifier.FALLING)}
_STORING = {"": "None", "none": "None", "set": "Set", "reset": "Reset"}
_RAILS = ("leftPowerRail", "rightPowerRail")
_SILENT = ("comment", "vendorElement", "error", *_RAILS)
_UNASKED = ("comment", "vendorElement", "error", "rightPowerRail")
"""Elements that nothing leads from."""
_CALLS = {"functionblock": "FunctionBlock", "operator": "Operator", "function": "Function",
          "program": "Program", "method": "Method"}  # fmt: skip
_CHART = frozenset(
    ["step", "transition", "selectionDivergence", "selectionConvergence", "jumpStep", "macroStep",
     "simultaneousDivergence", "simultaneousConvergence", "actionBlock"]
)  # fmt: skip
_DEEPEST = 100
_LAST = 1 << 30


def read_diagram(text: str) -> FunctionChart:
    """Return a diagram as a function chart. Raises `Unexpected` for what is not supported."""
    return _Diagram(DiagramElements(text)).chart()


class _Diagram:
    """Makes the elements of one chart."""

    def __init__(self, elements: DiagramElements) -> None:
        self._of = elements
        self._inputs: list[ChartInput] = []
        self._items: list[tuple[Element, Ordered]] = []
        self._sources: list[tuple[int, int]] = []
        self._outputs: dict[int, dict[str, int]] = {}
        self._source_pins: dict[int, list[int]] = {}
        """Source pins of coils and connectors, kept for further requests."""
        """Output pins of elements, by number and by name."""
        self._next = 0
        self._depth = 0

    def chart(self) -> FunctionChart:
        everything = self._elements()
        self._continued = {
            element.attributes.get("name", ""): element
            for element in everything
            if element.tag == "connector" and element.attributes.get("name")
        }
        for element in everything:
            self._announce(element)
        for element in everything:
            self._make(element)
        self._condition()
        ordered = self._ordered()
        return FunctionChart(tuple(self._inputs), tuple(ordered), tuple(self._sources), False)

    def _elements(self) -> list[Element]:
        """Return the elements of a diagram; of a condition in a chart those that lead to it."""
        everything = self._of.root.children
        if not self._of.condition:
            return everything
        labels = {one.attributes.get("name"): one for one in everything if one.tag == "connector"}
        reached: dict[int, Element] = {}
        waiting = [self._transition()]
        while waiting:
            element = waiting.pop()
            if element.tag == "continuation" and element.attributes.get("name") in labels:
                waiting.append(labels[element.attributes.get("name")])
            for part in element.walk():
                for key, _ in connections_of(part):
                    other = self._of.by_id.get(key)
                    if other is not None and id(other) not in reached and other.tag not in _CHART:
                        reached[id(other)] = other
                        waiting.append(other)
        return [one for one in everything if id(one) in reached]

    def _transition(self) -> Element:
        """Return the condition of the transition that counts."""
        element = self._of.by_id.get(self._of.condition.get("of", ""))
        condition = None if element is None else element.find("condition")
        if condition is None:
            raise self._of.fault(self._of.root, "a transition has no condition", Code.BAD_DRAWING)
        return condition

    def _condition(self) -> None:
        """Write what leads to a condition."""
        if self._of.condition:
            element = self._transition()
            pin = self._pin()
            self._connect(pin, element, element)
            at, name = self._of.at(element), self._of.condition.get("name", "")
            output = ChartOutput(name, pin, "None", (0, _LAST), at)
            self._items.append((element, output))

    # pins --------------------------------------------------------------------------------------

    def _pin(self, name: str = "", element: Element | None = None, *, by: bool = False) -> ChartPin:
        """Return a new pin, negated and with the edge that an element says."""
        self._next += 1
        attributes = {} if element is None else element.attributes
        edge = _EDGES.get(attributes.get("edge", ""))
        if edge is None and element is not None:
            raise self._of.fault(element, f"edge {attributes['edge'][:20]} is not supported")
        return ChartPin(self._next, name, attributes.get("negated") == "true", by, edge or 0)

    def _announce(self, element: Element) -> None:
        """Make the output pins of an element: others lead to them before it is made."""
        key = element.attributes.get("localId", "")
        if key and element.tag not in _UNASKED and self._of.by_id[key] is not element:
            raise self._of.fault(
                element, f"several elements have localId '{key[:20]}'", Code.BAD_DRAWING
            )
        names = [""]
        if element.tag == "block":
            names = [
                one.attributes.get("formalParameter", "")
                for group in ("inOutVariables", "outputVariables")
                for outer in element.all(group)
                for one in outer.all("variable")
            ]
        pins = self._outputs[id(element)] = {}
        for name in names:
            self._next += 1
            pins[name] = self._next

    def _output(self, element: Element) -> int:
        """Return the only output pin of an element."""
        return self._outputs[id(element)][""]

    def _connect(self, pin: ChartPin, owner: Element, point: Element) -> bool:
        """Lead what a connection point names to a pin. Return True if there is anything."""
        sources = [
            source
            for key, name in connections_of(point)
            for source in self._source(key, name, owner)
        ]
        if not sources:
            return False
        if len(sources) > 1:
            pins = [self._pin() for _ in sources]
            self._sources += [(one.id, source) for one, source in zip(pins, sources, strict=True)]
            sources = [self._operator("OR", pins, owner).id]
        self._sources.append((pin.id, sources[0]))
        return True

    def _source(self, key: str, name: str, target: Element) -> list[int]:
        """Return the output pins that a connection leads to, through coils and connectors."""
        element = self._of.by_id.get(key)
        if element is None:
            return []
        if element.tag == "continuation":
            label = element.attributes.get("name", "")
            if label not in self._continued:
                raise self._of.fault(element, f"no connector is named '{label[:40]}'",
                                     Code.INCOMPLETE_DRAWING)  # fmt: skip
            element = self._continued[label]
        if id(element) in self._source_pins:
            return self._source_pins[id(element)]
        if element.tag in ("coil", "connector"):
            self._depth += 1
            if self._depth > _DEEPEST:
                raise self._of.fault(target, "connectors lead in a circle", Code.INCOMPLETE_DRAWING)
            sources = [
                source
                for inner, inner_name in connections_of(element)
                for source in self._source(inner, inner_name, target)
            ]
            self._depth -= 1
            self._source_pins[id(element)] = sources = list(dict.fromkeys(sources))
            return sources
        pins = self._outputs.get(id(element), {})
        if name in pins:
            return [pins[name]]
        rest = [pin for label, pin in pins.items() if label.upper() != "ENO"]
        return rest[:1] or list(pins.values())[:1]

    def _operator(
        self, name: str, inputs: Iterable[ChartPin], element: Element, output: int = 0
    ) -> ChartPin:
        """Return a box of an operator that the drawing does not show as one."""
        pin = self._pin() if not output else ChartPin(output, "", False)
        at, bounds = self._of.at(element), self._of.position(element)
        box = ChartBox("Operator", name, "", tuple(inputs), (pin,), False, bounds, at)
        self._items.append((element, box))
        return pin

    # elements ----------------------------------------------------------------------------------

    def _make(self, element: Element) -> None:
        at, bounds = self._of.at(element), self._of.position(element)
        match element.tag:
            case "leftPowerRail":
                self._inputs.append(ChartInput("TRUE", ChartPin(self._output(element), "", False)))
            case "inVariable":
                self._value(element, "expression", self._output(element))
            case "outVariable":
                self._written(element, "expression")
            case "inOutVariable":
                self._value(element, "expression", self._output(element))
                if any(True for _ in connections_of(element)):
                    self._written(element, "expression")
            case "contact":
                self._contact(element)
            case "coil":
                self._written(element, "variable")
            case "block":
                self._block(element)
            case "label":
                label = ChartLabel(element.attributes.get("label", ""), bounds, at)
                self._items.append((element, label))
            case "jump" | "return":
                pin = self._pin(element=element)
                self._connect(pin, element, element)
                label_name = element.attributes.get("label", "") if element.tag == "jump" else ""
                self._items.append((element, ChartLeave(label_name, pin, bounds, at)))
            case "connector" | "continuation":
                pass
            case tag if tag not in _SILENT:
                raise self._of.fault(element, f"'{tag[:40]}' is not supported in a diagram")

    def _text(self, element: Element, tag: str) -> str:
        return element.text_of(tag).strip() or UNFINISHED

    def _value(self, element: Element, tag: str, output: int) -> None:
        """Read an expression; one that is negated or has an edge goes through a box."""
        at, text = self._of.at(element), self._text(element, tag)
        through = self._pin(element=element)
        if not through.is_negated and not through.edge:
            self._inputs.append(ChartInput(text, ChartPin(output, "", False), at))
            return
        source = self._pin()
        self._inputs.append(ChartInput(text, source, at))
        self._sources.append((through.id, source.id))
        self._operator("MOVE", [through], element, output)

    def _contact(self, element: Element) -> None:
        variable = self._pin()
        text = self._text(element, "variable")
        self._inputs.append(ChartInput(text, variable, self._of.at(element)))
        pin = self._pin(element=element)
        self._sources.append((pin.id, variable.id))
        inputs = [pin]
        rails = {
            self._of.by_id[key].tag for key, _ in connections_of(element) if key in self._of.by_id
        }
        power = self._pin()
        if rails - set(_RAILS) and self._connect(power, element, element):
            inputs.insert(0, power)
        elif not rails:
            raise self._of.fault(
                element, f"nothing leads to the contact {text[:40]}", Code.INCOMPLETE_DRAWING
            )
        output = self._output(element)
        self._operator("AND" if len(inputs) > 1 else "MOVE", inputs, element, output)

    def _written(self, element: Element, tag: str) -> None:
        storing = _STORING.get(element.attributes.get("storage", ""))
        if storing is None:
            raise self._of.fault(element, f"storage {element.attributes['storage'][:20]}")
        pin = self._pin(element=element)
        if not self._connect(pin, element, element):
            return
        at, bounds = self._of.at(element), self._of.position(element)
        output = ChartOutput(self._text(element, tag), pin, storing, bounds, at)
        self._items.append((element, output))

    def _block(self, element: Element) -> None:
        facts = element.attributes
        type, instance = facts.get("typeName", ""), facts.get("instanceName", "")
        call = "FunctionBlock" if instance else "Function"
        for data in (one for one in element.walk() if one.tag == "CallType"):
            call = _CALLS.get(data.text.strip().lower(), call)
        if call in ("Function", "Operator"):
            call = "Operator" if call_of_operator(type) else "Function"
        enable: ChartPin | None = None
        inputs: list[ChartPin] = []
        hole = ""
        for group in ("inputVariables", "inOutVariables"):
            for one in (each for outer in element.all(group) for each in outer.all("variable")):
                name = one.attributes.get("formalParameter", "")
                pin = self._pin(name, one, by=group == "inOutVariables")
                is_wired = self._connect(pin, element, one)
                if name.upper() == "EN" and group == "inputVariables":
                    enable = pin if is_wired else None
                    continue
                if is_wired and hole and call == "Operator":
                    raise self._of.fault(
                        element, f"nothing leads to {hole} of {type}", Code.INCOMPLETE_DRAWING
                    )
                hole = hole if is_wired else name or "an input"
                if is_wired or call != "Operator":
                    inputs.append(pin)
        outputs, eno = self._outputs_of(element)
        box = ChartBox(
            call, type, instance, tuple(inputs), tuple(outputs), False,
            self._of.position(element), self._of.at(element), enable, eno,
        )  # fmt: skip
        self._items.append((element, box))

    def _outputs_of(self, element: Element) -> tuple[list[ChartPin], ChartPin | None]:
        """Return the output pins of a block, and ENO."""
        known = self._outputs[id(element)]
        outputs: list[ChartPin] = []
        eno: ChartPin | None = None
        for group in ("inOutVariables", "outputVariables"):
            for one in (each for outer in element.all(group) for each in outer.all("variable")):
                facts = one.attributes
                name = facts.get("formalParameter", "")
                if facts.get("storage", "none") != "none" or facts.get("edge", "none") != "none":
                    raise self._of.fault(element, f"output {name[:40]} has a storage or an edge")
                pin = ChartPin(known[name], name, facts.get("negated") == "true")
                if name.upper() == "ENO" and group == "outputVariables":
                    eno = pin
                else:
                    outputs.append(pin)
        return outputs, eno

    # order -------------------------------------------------------------------------------------

    def _ordered(self) -> list[Ordered]:
        """Elements of networks one after the other, each by data flow."""
        numbers = [_order_of(element) for element, _ in self._items]
        if numbers and all(numbers):
            ranked = sorted(zip(numbers, self._items, strict=True), key=lambda item: item[0])
            return [element for _, (_, element) in ranked]
        networks = {} if self._of.condition else self._networks()
        groups: dict[str, list[int]] = {}
        for index, (element, _) in enumerate(self._items):
            groups.setdefault(networks.get(id(element), ""), []).append(index)

        def rank(group: list[int]) -> tuple[int, int, int, int]:
            orders = [numbers[index] for index in group if numbers[index]]
            places = [self._of.position(self._items[index][0])[::-1] for index in group]
            top, left = min(places)
            return min(orders, default=0), top, left, group[0]

        producers = {
            pin.id: index
            for index, (_, element) in enumerate(self._items)
            if isinstance(element, ChartBox)
            for pin in (
                *element.outputs,
                *((element.enable_output,) if element.enable_output else ()),
            )
        }
        consumers = {
            pin: index
            for index, (_, element) in enumerate(self._items)
            for pin in _input_ids(element)
        }
        ordered: list[Ordered] = []
        for group in sorted(groups.values(), key=rank):
            place = {index: number for number, index in enumerate(group)}
            edges = [
                (place[producers[source]], place[consumers[pin]])
                for pin, source in self._sources
                if producers.get(source) in place and consumers.get(pin) in place
            ]
            ordered += execution_order([self._items[index][1] for index in group], edges)
        return ordered

    def _networks(self) -> dict[int, str]:
        """Return a name of its network for each element."""
        leader: dict[str, str] = {}

        def root(key: str) -> str:
            while leader.setdefault(key, key) != key:
                key = leader[key]
            return key

        for element in self._of.root.children:
            own = element.attributes.get("localId", "")
            if element.tag in _RAILS:
                continue
            if element.tag in ("connector", "continuation") and element.attributes.get("name"):
                leader[root(own)] = root(f"connector {element.attributes['name']}")
            for part in element.walk():
                for key, _ in connections_of(part):
                    other = self._of.by_id.get(key)
                    if other is not None and other.tag not in _RAILS:
                        leader[root(own)] = root(key)
        return {
            id(element): root(element.attributes.get("localId", ""))
            for element in self._of.root.children
        }


def _order_of(element: Element) -> int:
    return whole_number(element.attributes.get("executionOrderId", "0"))


def _input_ids(item: Ordered) -> list[int]:
    match item:
        case ChartBox():
            pins = [pin.id for pin in item.inputs]
            return pins if item.enable is None else [item.enable.id, *pins]
        case ChartOutput() | ChartLeave():
            return [item.input.id]
    return []
