"""Sequential function charts in PLCopen XML: steps and transitions that name what leads to them.

Conditions are expressions, names of transitions, or diagrams, which become transition objects of
the unit. Statements in action blocks become actions of the unit. Vendors add entry, main and exit
actions to steps.

Source: PLCopen TC6 XML schema 2.01; IEC 61131-3 (2013) §6.7.
"""

from collections.abc import Iterator, Sequence
from itertools import product
from typing import NamedTuple

from achse.st.graphical.chart_flow import Firing, StepFlow
from achse.st.graphical.charts import (
    QUALIFIERS,
    TIMED,
    ActionAssociation,
    AttributeId,
    ChartStep,
    ChartTransition,
)
from achse.st.graphical.plcopen.elements import DiagramElements, connections_of
from achse.st.lexis.codes import Code
from achse.st.lexis.literals import whole_number
from achse.st.lexis.xml import Element
from achse.st.syntax.cursor import Unexpected

_DEEPEST = 200


class InlineAction(NamedTuple):
    """Statements in an action block, as an action of the unit."""

    name: str
    text: str
    line: int
    """Line of the first sign, from 1, in the text of the chart."""
    column: int


def inline_actions(text: str) -> Sequence[InlineAction]:
    """Return the statements in the action blocks of a chart; none if it cannot be read."""
    try:
        elements = DiagramElements(text)
    except Unexpected:
        return ()
    actions = []
    for element in elements.root.walk():
        if element.tag == "action" and (statements := _statements(element)) is not None:
            start = statements.begin_at
            name = _inline_name(elements, element)
            body = statements.text[statements.begin :]
            actions.append(InlineAction(name, body, start.line, start.column))
    return actions


def _inline_name(elements: DiagramElements, action: Element) -> str:
    return f"__inline{elements.at(action)}"


def _statements(element: Element) -> Element | None:
    """Return the element with the text of an `inline` in Structured Text."""
    inline = element.find("inline")
    body = None if inline is None else inline.find("ST")
    if body is None:
        return None
    return next((one for one in body.children if one.text.strip()), body)


def read_drawn_steps(text: str) -> Sequence[ChartStep]:
    """Return the steps of a chart, from top to bottom and left to right. Raises `Unexpected`."""
    return _Chart(text).steps


def read_drawn_flow(text: str) -> StepFlow:
    """Return the flow of a chart. Raises `Unexpected`."""
    return _Chart(text).flow()


class _Chart:
    """The steps of one chart, and the way between them."""

    def __init__(self, text: str) -> None:
        self._of = DiagramElements(text)
        self._depth = 0
        steps = [one for one in self._of.root.children if one.tag == "step"]
        steps.sort(key=lambda one: self._of.position(one)[::-1])
        self._steps = {id(one): self._step(one) for one in steps}
        self.steps = tuple(self._steps.values())

    # steps -------------------------------------------------------------------------------------

    def _step(self, element: Element) -> ChartStep:
        own = element.attributes.get("localId", "")
        associations = [
            self._association(action)
            for block in self._of.root.children
            if block.tag == "actionBlock" and own in (key for key, _ in connections_of(block))
            for action in block.all("action")
        ]
        added = {
            one.attributes.get("guid", "")[:8].lower(): one.text.strip()
            for one in element.walk()
            if one.tag == "attribute"
        }
        entry, main, exit, minimum, maximum = (
            added.get(key, "")
            for key in (
                AttributeId.ENTRY, AttributeId.MAIN, AttributeId.EXIT,
                AttributeId.MINIMUM, AttributeId.MAXIMUM,
            )
        )  # fmt: skip
        return ChartStep(
            element.attributes.get("name", ""),
            element.attributes.get("initialStep") == "true",
            entry, main, exit, minimum, maximum,
            tuple(one for one in associations if one is not None),
            self._of.at(element),
        )  # fmt: skip

    def _association(self, action: Element) -> ActionAssociation | None:
        facts = action.attributes
        reference = action.find("reference")
        name = "" if reference is None else reference.attributes.get("name", "")
        if _statements(action) is not None:
            name = _inline_name(self._of, action)
        elif action.find("inline") is not None:
            raise self._of.fault(action, "an action that is drawn in its block is not supported")
        if not name:
            return None
        qualifier = facts.get("qualifier", "N") or "N"
        if qualifier not in QUALIFIERS:
            raise self._of.fault(
                action, f"{name}: '{qualifier[:20]}' is not a qualifier", Code.INCOMPLETE_DRAWING
            )
        time = facts.get("duration", "").strip()
        if qualifier in TIMED and not time:
            raise self._of.fault(
                action, f"{name}: qualifier {qualifier} has no time", Code.INCOMPLETE_DRAWING
            )
        return ActionAssociation(
            name, qualifier, time if qualifier in TIMED else "", self._of.at(action)
        )

    # flow --------------------------------------------------------------------------------------

    def flow(self) -> StepFlow:
        for element in self._of.root.children:
            if element.tag == "macroStep":
                raise self._of.fault(element, "a macro step is not supported")
        flow = StepFlow(self.steps)
        transitions = [one for one in self._of.root.children if one.tag == "transition"]
        transitions.sort(key=self._rank)
        firings: dict[int, list[Firing]] = {}
        for element in transitions:
            drawn = ChartTransition(self._condition(element), self._of.at(element))
            firings[id(element)] = [
                Firing(drawn, left) for left in self._source_steps(element, element)
            ]
            flow.firings += firings[id(element)]
        for element in self._of.root.children:
            if element.tag == "step":
                target = self._steps[id(element)]
            elif element.tag == "jumpStep":
                target = flow.step(element.attributes.get("targetName", ""), self._of.at(element))
            else:
                continue
            for transition in self._fired_by(element, element):
                for firing in firings[id(transition)]:
                    firing.activated.append(target)
        for element in transitions:
            if not all(firing.activated for firing in firings[id(element)]):
                raise self._of.fault(
                    element, "the transition has no target step", Code.BAD_CHART_FLOW
                )
        return flow

    def _rank(self, element: Element) -> tuple[int, int, int]:
        """Transitions with a priority come first, by it; others from left to right."""
        priority = element.attributes.get("priority", "0")
        left, top = self._of.position(element)
        return whole_number(priority) or 1 << 30, left, top

    def _before(self, element: Element, target: Element) -> Iterator[Element]:
        """Return the elements that lead to an element."""
        self._depth += 1
        if self._depth > _DEEPEST:
            raise self._of.fault(target, "branches lead in a circle", Code.BAD_CHART_FLOW)
        points = [element, *(one for one in element.children if one.find("connection") is None)]
        seen: set[str] = set()
        for point in points if element.tag.endswith("Convergence") else [element]:
            for point_in in point.all("connectionPointIn"):
                for one in point_in.all("connection"):
                    key = one.attributes.get("refLocalId", "")
                    if key in self._of.by_id and key not in seen:
                        seen.add(key)
                        yield self._of.by_id[key]
        self._depth -= 1

    def _source_steps(self, element: Element, target: Element) -> list[tuple[ChartStep, ...]]:
        """Return the steps that a transition leaves: each alternative with all of its steps."""
        steps: list[tuple[ChartStep, ...]] = []
        for before in self._before(element, target):
            match before.tag:
                case "step":
                    steps.append((self._steps[id(before)],))
                case "selectionDivergence" | "selectionConvergence":
                    steps += self._source_steps(before, target)
                case "simultaneousConvergence":
                    groups = [
                        [(self._steps[id(one)],)]
                        if one.tag == "step"
                        else self._source_steps(one, target)
                        for one in self._before(before, target)
                    ]
                    steps += [
                        tuple(step for one in group for step in one) for group in product(*groups)
                    ]
                case "transition":
                    raise self._of.fault(
                        target, "two transitions follow each other", Code.BAD_CHART_FLOW
                    )
        return steps

    def _fired_by(self, element: Element, target: Element) -> list[Element]:
        """Return the transitions that lead to a step."""
        transitions: list[Element] = []
        for before in self._before(element, target):
            if before.tag == "transition":
                transitions.append(before)
            elif before.tag in (
                "selectionConvergence", "simultaneousDivergence", "selectionDivergence"
            ):  # fmt: skip
                transitions += self._fired_by(before, target)
            elif before.tag == "step":
                raise self._of.fault(
                    target,
                    f"expected a transition behind step {before.attributes.get('name', '')}",
                    Code.BAD_CHART_FLOW,
                )
        return transitions

    # conditions --------------------------------------------------------------------------------

    def _condition(self, element: Element) -> str:
        condition = element.find("condition")
        if condition is None:
            return ""
        reference = condition.find("reference")
        if reference is not None:
            return reference.attributes.get("name", "")
        statements = _statements(condition)
        if statements is not None:
            return statements.text.strip().rstrip("; ")
        if condition.find("inline") is not None:
            raise self._of.fault(element, "a condition that is drawn inline is not supported")
        expression = _expression(self._of, condition)
        if expression is not None:
            return expression
        return _condition_name(element) if any(True for _ in connections_of(condition)) else ""


def _expression(elements: DiagramElements, condition: Element) -> str | None:
    """Return the one expression that leads to a condition; None for a drawing."""
    sources = [elements.by_id.get(key) for key, _ in connections_of(condition)]
    if len(sources) != 1 or sources[0] is None or sources[0].tag != "inVariable":
        return None
    facts = sources[0].attributes
    if facts.get("negated") == "true" or facts.get("edge", "none") != "none":
        return None
    return sources[0].text_of("expression").strip()


def _condition_name(transition: Element) -> str:
    return f"__transition{transition.attributes.get('localId', '')}"


def drawn_conditions(text: str) -> Iterator[tuple[str, str]]:
    """Return the conditions of a chart that are drawn: names of transition objects for them, and
    their bodies; none if it cannot be read."""
    try:
        elements = DiagramElements(text)
    except Unexpected:
        return
    for transition in elements.root.children:
        condition = transition.find("condition") if transition.tag == "transition" else None
        if condition is None or condition.find("connectionPointIn") is None:
            continue
        if _expression(elements, condition) is None and any(
            True for _ in connections_of(condition)
        ):
            name = _condition_name(transition)
            number = transition.attributes.get("localId", "")
            yield name, f'<condition of="{number}" name="{name}">{elements.closed}'
