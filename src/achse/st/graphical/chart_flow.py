"""Flow of a chart: its steps in order, and what each transition leaves and activates.

Source: IEC 61131-3 (2013) §6.7.5, rules of evolution.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product

from achse.st.graphical.charts import (
    Alternative,
    Chart,
    ChartElement,
    ChartJump,
    ChartStep,
    ChartTransition,
    Macro,
    Simultaneous,
)
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected


@dataclass(slots=True)
class Firing:
    """A transition in the flow."""

    transition: ChartTransition
    left: tuple[ChartStep, ...]
    """Steps that must all be active, and that it leaves."""
    activated: list[ChartStep] = field(default_factory=list)


_Exit = Firing | tuple[ChartStep, ...]
"""An open end: a transition that leads on, or steps that are left together."""


class StepFlow:
    """Steps of a chart in their order, and its transitions.

    Raises `Unexpected` for two steps of one name, and if there is not one initial step.
    """

    def __init__(self, steps: Iterable[ChartStep]) -> None:
        self.steps = tuple(steps)
        self.firings: list[Firing] = []
        self._by_name = {step.name.lower(): step for step in self.steps}
        if len(self._by_name) < len(self.steps):
            taken: set[str] = set()
            for step in self.steps:
                if step.name.lower() in taken:
                    raise Unexpected(
                        step.at, f"two steps are named {step.name}", Code.BAD_CHART_FLOW
                    )
                taken.add(step.name.lower())
        initial = [step for step in self.steps if step.is_initial]
        if len(initial) != 1:
            at = initial[1].at if initial else 0
            raise Unexpected(
                at, f"expected one initial step, got {len(initial)}", Code.BAD_CHART_FLOW
            )
        self.initial = initial[0]

    def step(self, name: str, at: int) -> ChartStep:
        """Return the step of a name. Raises `Unexpected`."""
        step = self._by_name.get(name.lower())
        if step is None:
            raise Unexpected(at, f"expected a step, got '{name[:80]}'", Code.BAD_CHART_FLOW)
        return step


class ChartFlow(StepFlow):
    """Flow of a chart that is drawn as a tree, from top to bottom and left to right.

    Raises `Unexpected` for a chart that does not connect.
    """

    def __init__(self, chart: Chart) -> None:
        super().__init__(steps_of(chart.elements))
        self._labels: dict[str, list[ChartStep]] = {}
        self._jumps: list[tuple[Firing, ChartJump]] = []
        exits = self._segment(chart.elements, [])
        for firing, jump in self._jumps:
            firing.activated += self._target(jump)
        for end in exits:
            if isinstance(end, Firing):
                raise Unexpected(
                    end.transition.at, "the transition has no target step", Code.BAD_CHART_FLOW
                )

    def _target(self, jump: ChartJump) -> Sequence[ChartStep]:
        key = jump.target.lower()
        if key in self._by_name:
            return (self._by_name[key],)
        if key in self._labels:
            return self._labels[key]
        raise Unexpected(
            jump.at,
            f"a jump to '{jump.target[:80]}': expected a step or a branch",
            Code.BAD_CHART_FLOW,
        )

    def _segment(self, elements: Sequence[ChartElement], exits: list[_Exit]) -> list[_Exit]:
        for element in elements:
            exits = self._element(element, exits)
        return exits

    def _element(self, element: ChartElement, exits: list[_Exit]) -> list[_Exit]:
        match element:
            case ChartStep():
                for firing in self._transitions(exits, element.at):
                    firing.activated.append(element)
                return [(element,)]
            case ChartTransition():
                return list(self._fire(element, exits))
            case ChartJump():
                for firing in self._transitions(exits, element.at):
                    self._jumps.append((firing, element))
                return []
            case Macro():
                return self._segment(element.elements, exits)
            case Alternative():
                return [end for one in element.segments for end in self._segment(one, exits)]
            case Simultaneous():
                return self._simultaneous(element, exits)

    def _transitions(self, exits: list[_Exit], at: int) -> Iterator[Firing]:
        for end in exits:
            if not isinstance(end, Firing):
                raise Unexpected(
                    at, f"expected a transition behind step {end[-1].name}", Code.BAD_CHART_FLOW
                )
            yield end

    def _fire(self, transition: ChartTransition, exits: list[_Exit]) -> Iterator[Firing]:
        for end in exits:
            if isinstance(end, Firing):
                raise Unexpected(
                    transition.at, "two transitions follow each other", Code.BAD_CHART_FLOW
                )
            firing = Firing(transition, end)
            self.firings.append(firing)
            yield firing

    def _simultaneous(self, branch: Simultaneous, exits: list[_Exit]) -> list[_Exit]:
        first = [steps_of(segment) for segment in branch.segments]
        self._labels[branch.label.lower()] = [step for one in first for step in list(one)[:1]]
        ends = [self._segment(segment, exits) for segment in branch.segments]
        groups: list[list[tuple[ChartStep, ...]]] = []
        for end in ends:
            steps = [one for one in end if not isinstance(one, Firing)]
            if len(steps) < len(end):
                raise Unexpected(
                    branch.at,
                    "a segment of a parallel branch ends with a step",
                    Code.BAD_CHART_FLOW,
                )
            if steps:
                groups.append(steps)
        return [tuple(step for one in group for step in one) for group in product(*groups) if group]


def steps_of(elements: Sequence[ChartElement]) -> Iterator[ChartStep]:
    """Return the steps of a part of a chart, from top to bottom and left to right."""
    for element in elements:
        match element:
            case ChartStep():
                yield element
            case Macro(elements=inner):
                yield from steps_of(inner)
            case Alternative(segments=segments) | Simultaneous(segments=segments):
                for segment in segments:
                    yield from steps_of(segment)
