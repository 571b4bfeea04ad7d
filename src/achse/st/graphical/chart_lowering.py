"""Sequential function charts lowered to statements.

One call: exit actions of steps that are left, entry actions of steps that become active, times and
main actions of active steps, IEC actions in alphabetical order (those that lost control first),
then transitions. A step that a transition activates is executed in the next call.

Source: order of processing, SFC flags and qualifiers in public manual pages of TwinCAT 3 and
CODESYS; IEC 61131-3 (2013) 6.7.4 for the control of actions.
"""

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from achse.st.graphical.body import BodyScope, GraphicalBody, Refused
from achse.st.graphical.chart_flow import ChartFlow, Firing, StepFlow, steps_of
from achse.st.graphical.charts import ActionAssociation, ChartStep, read_chart, read_flags
from achse.st.graphical.writer import BodyStatements, call_of, implicit_block
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import (
    Assign,
    Binary,
    Branch,
    Expression,
    If,
    Literal,
    Member,
    MemberInitial,
    Name,
    Return,
    Statements,
    StringOf,
    StructInitial,
    TypeSpec,
    Unary,
    VarBlock,
)

_TEXT = StringOf("STRING", None)
_FLAGS: dict[str, TypeSpec | str] = {
    "init": "BOOL",
    "reset": "BOOL",
    "error": "BOOL",
    "enablelimit": "BOOL",
    "errorstep": _TEXT,
    "errorpou": _TEXT,
    "quiterror": "BOOL",
    "pause": "BOOL",
    "trans": "BOOL",
    "currentstep": _TEXT,
    "tip": "BOOL",
    "tipmode": "BOOL",
    "erroranalyzation": _TEXT,
}
"""Types of the SFC flags, by their names without `SFC`."""
_NAMES = {
    "init": "SFCInit",
    "reset": "SFCReset",
    "error": "SFCError",
    "enablelimit": "SFCEnableLimit",
    "errorstep": "SFCErrorStep",
    "errorpou": "SFCErrorPOU",
    "quiterror": "SFCQuitError",
    "pause": "SFCPause",
    "trans": "SFCTrans",
    "currentstep": "SFCCurrentStep",
    "tip": "SFCTip",
    "tipmode": "SFCTipMode",
    "erroranalyzation": "SFCErrorAnalyzation",
}
_TRUE, _FALSE = Literal("boolean", "TRUE"), Literal("boolean", "FALSE")
_IDENTIFIER = re.compile(r"[A-Za-z_]\w*", re.ASCII)


class ChartForm(NamedTuple):
    """Readers of a form in which files have charts. They raise `Unexpected`."""

    steps: Callable[[str], Sequence[ChartStep]]
    flow: Callable[[str], StepFlow]


ARCHIVED_CHARTS = ChartForm(
    lambda text: tuple(steps_of(read_chart(text).elements)),
    lambda text: ChartFlow(read_chart(text)),
)
"""Charts of `.TcPOU` files."""


def implicit_variables_of_chart(
    body: GraphicalBody, form: ChartForm = ARCHIVED_CHARTS
) -> tuple[VarBlock, ...]:
    """Return the variables that a chart brings: its steps, actions and flags."""
    try:
        drawn = form.steps(body.text)
    except Unexpected:
        return ()
    steps = implicit_block([(step.name, "SFCStepType") for step in drawn], has_symbols=True)
    active = StructInitial((MemberInitial("_x", _TRUE),))
    initial = {step.name for step in drawn if step.is_initial}
    steps = replace(
        steps,
        variables=tuple(
            replace(item, initial=active) if item.names[0].name in initial else item
            for item in steps.variables
        ),
    )
    controlled = _controlled(drawn)
    actions = [
        (f"_{body.owner.actions[one.key]}", "SFCActionType")
        for one in controlled
        if one.key in body.owner.actions
    ]
    flags = [
        (_NAMES[key], _FLAGS[key])
        for key, is_declared in read_flags(body.settings).items()
        if is_declared and key in _FLAGS
    ]
    hidden: list[tuple[str, str]] = []
    for number, action in enumerate(controlled):
        if action.key not in body.owner.actions:
            hidden.append((_state(body, number), "SFCActionType"))
        if not action.is_plain:
            hidden.append((_control(body, number), "SFCActionControl"))
    if "tip" in read_flags(body.settings):
        hidden.append((_tip(body), "BOOL"))
    blocks = [steps, implicit_block([*actions, *flags], has_symbols=True), implicit_block(hidden)]
    return tuple(block for block in blocks if block.variables)


def lowered_chart(
    body: GraphicalBody, scope: BodyScope, form: ChartForm = ARCHIVED_CHARTS
) -> Statements:
    """Return the statements of a chart. Raises `Refused` and `Unexpected`."""
    try:
        form.steps(body.text)
    except Unexpected as fault:
        raise Refused(body.name_place(fault.at, "the chart"), fault.message, fault.code) from None
    try:
        flow = form.flow(body.text)
    except Unexpected as fault:
        raise Unexpected(
            body.name_place(fault.at, "the chart"), fault.message, fault.code
        ) from None
    return _Lowering(body, scope, flow).statements()


_Chosen = tuple[Name, int, Firing, int]
"""Variable that says which transition fires, its number for this one, and the place."""


@dataclass(slots=True)
class _Controlled:
    """An action or variable with the associations that control it."""

    name: str
    key: str
    associations: list[tuple[ChartStep, ActionAssociation]] = field(default_factory=list)

    @property
    def is_plain(self) -> bool:
        """True if all of its qualifiers are N."""
        return all(one.qualifier == "N" for _, one in self.associations)


def _controlled(steps: Iterable[ChartStep]) -> list[_Controlled]:
    """Return the controlled actions in alphabetical order."""
    actions: dict[str, _Controlled] = {}
    for step in steps:
        for one in step.associations:
            key = one.name.lower()
            actions.setdefault(key, _Controlled(one.name, key)).associations.append((step, one))
    return [actions[key] for key in sorted(actions)]


def _state(body: GraphicalBody, number: int) -> str:
    return f"__{body.owner.unit}_{body.owner.part}_state{number}"


def _control(body: GraphicalBody, number: int) -> str:
    return f"__{body.owner.unit}_{body.owner.part}_control{number}"


def _tip(body: GraphicalBody) -> str:
    return f"__{body.owner.unit}_{body.owner.part}_tip"


def _or(values: Iterable[Expression], at: int) -> Expression:
    result: Expression | None = None
    for value in values:
        result = value if result is None else Binary("OR", result, value, at)
    return _FALSE if result is None else result


class _Lowering(BodyStatements):
    """Writes the statements of one chart."""

    def __init__(self, body: GraphicalBody, scope: BodyScope, flow: StepFlow) -> None:
        super().__init__(body, scope)
        self._flow = flow
        self._flags = set(read_flags(body.settings))
        self._actions = _controlled(flow.steps)
        self._start = self.at_step(flow.initial)

    def statements(self) -> Statements:
        self._start_over()
        self._stand_still()
        for step in self._flow.steps:
            self._leave(step)
        for step in self._flow.steps:
            self._enter(step)
        if "currentstep" in self._flags and self._flow.steps:
            self._flag("currentstep", Literal("string", "''"))
        for step in self._flow.steps:
            self._execute(step)
        self._run_actions(resets=False)
        self._fire_transitions()
        return tuple(self.out)

    # places and members ------------------------------------------------------------------------

    def at_step(self, step: ChartStep, detail: str = "") -> int:
        self.location = f"step {step.name}"
        return self.at(step.at, detail)

    def _member(self, step: ChartStep, name: str, at: int) -> Expression:
        return Member(Name(step.name, at), name, at)

    def _set(self, step: ChartStep, name: str, value: Expression, at: int) -> None:
        self.assign(self._member(step, name, at), value, at)

    def _time(self, at: int) -> Expression:
        return call_of(Name("TIME", at), (), at)

    def _flag(self, key: str, value: Expression) -> None:
        if key in self._flags:
            self.assign(Name(_NAMES[key], self._start), value, self._start)

    def _call(self, name: str, at: int) -> None:
        self.out.append(call_of(self.expression(name, at), (), at))

    def _when(self, condition: Expression, at: int, write: Callable[[], None]) -> None:
        self.when(condition, write, at)

    # flags -------------------------------------------------------------------------------------

    def _start_over(self) -> None:
        """Put the chart back to its initial step (SFCInit, SFCReset)."""
        at = self._start
        for key in ("init", "reset"):
            if key not in self._flags:
                continue

            def restart(key: str = key) -> None:
                self._run_actions(resets=True)
                for step in self._flow.steps:
                    if step is not self._flow.initial:
                        self._set(step, "x", _FALSE, at)
                        self._set(step, "_x", _FALSE, at)
                self._set(self._flow.initial, "_x", _TRUE, at)
                for flag in ("error", "trans"):
                    self._flag(flag, _FALSE)
                for flag in ("errorstep", "errorpou"):
                    self._flag(flag, Literal("string", "''"))
                if key == "init":
                    self._set(self._flow.initial, "x", _FALSE, at)
                    self._flag("currentstep", self._text(self._flow.initial.name))
                    self.out.append(Return(at))

            self.when(Name(_NAMES[key], at), restart, at)

    def _stand_still(self) -> None:
        """Stop the chart as long as SFCQuitError or SFCPause is TRUE."""
        at = self._start
        if "quiterror" in self._flags:

            def quit() -> None:
                for flag in ("error", "trans"):
                    self._flag(flag, _FALSE)
                for flag in ("errorstep", "errorpou"):
                    self._flag(flag, Literal("string", "''"))
                for step in self._flow.steps:
                    self._set(step, "_t", self._time(at), at)
                self.out.append(Return(at))

            self.when(Name(_NAMES["quiterror"], at), quit, at)
        if "pause" in self._flags:
            self.when(Name(_NAMES["pause"], at), lambda: self.out.append(Return(at)), at)
        self._flag("trans", _FALSE)

    def _text(self, text: str) -> Expression:
        return Literal("string", f"'{text}'", self._start)

    # steps -------------------------------------------------------------------------------------

    def _leave(self, step: ChartStep) -> None:
        at = self.at_step(step, "exit action" if step.exit else "")

        def write() -> None:
            if step.exit:
                self._call(step.exit, at)
            self._set(step, "x", _FALSE, at)

        self._when(self._changes(step, "x", "_x", at), at, write)

    def _enter(self, step: ChartStep) -> None:
        at = self.at_step(step, "entry action" if step.entry else "")

        def write() -> None:
            self._set(step, "x", _TRUE, at)
            self._set(step, "_t", self._time(at), at)
            if step.entry:
                self._call(step.entry, at)

        self._when(self._changes(step, "_x", "x", at), at, write)

    def _changes(self, step: ChartStep, yes: str, no: str, at: int) -> Expression:
        not_yet = Unary("NOT", self._member(step, no, at), at)
        return Binary("AND", self._member(step, yes, at), not_yet, at)

    def _execute(self, step: ChartStep) -> None:
        at = self.at_step(step)

        def write() -> None:
            elapsed = Binary("-", self._time(at), self._member(step, "_t", at), at)
            self._set(step, "t", elapsed, at)
            self._flag("currentstep", self._text(step.name))
            self._check_limit(step, at)
            if step.main:
                self._call(step.main, at)

        self._when(self._member(step, "x", at), at, write)

    def _check_limit(self, step: ChartStep, at: int) -> None:
        """Set SFCError if a step is active for longer than its maximum."""
        if not step.maximum or "error" not in self._flags:
            return
        limit = self.expression(step.maximum, at)
        late: Expression = Binary(">", self._member(step, "t", at), limit, at)
        late = Binary("AND", late, Unary("NOT", Name(_NAMES["error"], at), at), at)
        if "enablelimit" in self._flags:
            late = Binary("AND", Name(_NAMES["enablelimit"], at), late, at)

        def write() -> None:
            self._flag("error", _TRUE)
            self._flag("errorstep", self._text(step.name))
            self._flag("errorpou", self._text(self.body.owner.unit))

        self._when(late, at, write)

    # actions -----------------------------------------------------------------------------------

    def _run_actions(self, *, resets: bool) -> None:
        """Work out the control of all actions, then run those that lost it, then the others."""
        last: list[tuple[_Controlled, Expression, int]] = []
        running: list[tuple[_Controlled, Expression, int]] = []
        for number, action in enumerate(self._actions):
            step, association = action.associations[0]
            self.location = f"step {step.name}"
            at = self.at(association.at, f"action {action.name}")
            state: Expression = Name(_state(self.body, number), at)
            if action.key in self.body.owner.actions:
                state = Name(f"_{self.body.owner.actions[action.key]}", at)
            control = Name(_control(self.body, number), at)
            active = Member(state, "_x", at)
            executed = Member(state, "x", at)
            if action.is_plain:
                now = _FALSE if resets else self._is_active(action, "N", at)
                value = self.let(self.hidden("held"), now, at)
                executes: Expression = Binary("OR", value, active, at)
            else:
                self.out.append(call_of(control, self._inputs(action, at, resets=resets), at))
                value = self.let(self.hidden("held"), Member(control, "Q", at), at)
                executes = Member(control, "A", at)
            self.assign(executed, executes, at)
            self.assign(active, value, at)
            final = Binary("AND", executed, Unary("NOT", active, at), at)
            last.append((action, final, at))
            running.append((action, active, at))
        for action, condition, at in last:
            self._run(action, condition, at, value=False)
        for action, condition, at in () if resets else running:
            self._run(action, condition, at, value=True)

    def _is_active(self, action: _Controlled, qualifier: str, at: int) -> Expression:
        """Return an active step holds the action with that qualifier."""
        steps = [step for step, one in action.associations if one.qualifier == qualifier]
        return _or((self._member(step, "x", at) for step in steps), at)

    def _inputs(
        self, action: _Controlled, at: int, *, resets: bool
    ) -> list[tuple[str, Expression, bool]]:
        inputs: list[tuple[str, Expression, bool]] = []
        for qualifier in dict.fromkeys(one.qualifier for _, one in action.associations):
            if qualifier != "R":
                value = _FALSE if resets else self._is_active(action, qualifier, at)
                inputs.append((qualifier, value, False))
        inputs.append(("R", _TRUE if resets else self._is_active(action, "R", at), False))
        times: dict[str, Expression] = {}
        for step, one in action.associations:
            if not one.time or resets:
                continue
            name = f"T{one.qualifier}"
            value = self.expression(one.time, at)
            if name in times:  # the time of the step that is active, the first of several
                arguments = [("", self._member(step, "x", at), False), ("", times[name], False)]
                value = call_of(Name("SEL", at), [*arguments, ("", value, False)], at)
            times[name] = value
        return [*inputs, *((name, value, False) for name, value in times.items())]

    def _run(self, action: _Controlled, condition: Expression, at: int, *, value: bool) -> None:
        is_action = action.key in self.body.owner.actions or (
            _IDENTIFIER.fullmatch(action.name) and self.scope.is_callable(action.name)
        )

        def write() -> None:
            if is_action:
                self._call(action.name, at)
            else:
                target = self.expression(action.name, at)
                self.out.append(Assign(":=", target, _TRUE if value else _FALSE, at))

        self._when(condition, at, write)

    # transitions -------------------------------------------------------------------------------

    def _fire_transitions(self) -> None:
        """Leave the steps of all transitions that fire, then activate those that follow."""
        groups: dict[tuple[str, ...], list[Firing]] = {}
        for firing in self._flow.firings:
            groups.setdefault(tuple(step.name for step in firing.left), []).append(firing)
        tip = self._tip_edge()
        chosen: list[_Chosen] = []
        for group in groups.values():
            self._choose(group, tip, chosen)
        for name, number, firing, at in chosen:

            def activate(firing: Firing = firing, at: int = at) -> None:
                for step in firing.activated:
                    self._set(step, "_x", _TRUE, at)
                self._flag("trans", _TRUE)

            value = Literal("integer", str(number), at)
            self._when(Binary("=", name, value, at), at, activate)

    def _choose(
        self,
        group: list[Firing],
        tip: Expression | None,
        chosen: list[tuple[Name, int, Firing, int]],
    ) -> None:
        """Fire the first of the transitions behind the same steps whose condition holds."""
        left = group[0].left
        names = " and ".join(step.name for step in left)
        branches: list[Branch] = []
        self.location = f"transition behind {names}"
        start = self.at(group[0].transition.at)
        name = self.let(self.hidden("fires"), Literal("integer", "0", start), start)
        for number, firing in enumerate(group, 1):
            self.location = f"transition {number} behind {names}" if group[1:] else self.location
            at = self.at(firing.transition.at)
            value = Literal("integer", str(number), at)
            fires = Assign(":=", name, value, at)
            condition = self._condition(firing.transition.text, at)
            if tip is not None:
                if "tipmode" in self._flags:
                    free = Unary("NOT", Name(_NAMES["tipmode"], at), at)
                    condition = Binary("AND_THEN", free, condition, at)
                condition = Binary("OR_ELSE", tip, condition, at)
            branches.append(Branch(condition, (fires,), at))
            chosen.append((name, number, firing, at))

        def choose() -> None:
            self.out.append(If(tuple(branches), (), start))
            self._when(Binary("<>", name, Literal("integer", "0", start), start), start, leave)

        def leave() -> None:
            for step in left:
                self._set(step, "_x", _FALSE, start)

        self._when(self._enabled(left, start), start, choose)

    def _enabled(self, left: tuple[ChartStep, ...], at: int) -> Expression:
        """Return a condition: all steps before a transition are active for their minimum time."""
        condition: Expression | None = None
        for step in left:
            terms = [self._member(step, "x", at)]
            if step.minimum:
                time = self.expression(step.minimum, at)
                terms.append(Binary(">=", self._member(step, "t", at), time, at))
            for term in terms:
                condition = term if condition is None else Binary("AND", condition, term, at)
        assert condition is not None
        return condition

    def _condition(self, text: str, at: int) -> Expression:
        if not text:
            raise Unexpected(at, "the transition has no condition", Code.BAD_CHART_FLOW)
        if text.lower() in self.body.owner.transitions:
            return call_of(Name(text, at), (), at)
        return self.expression(text, at)

    def _tip_edge(self) -> Expression | None:
        """Return a rising edge of SFCTip."""
        if "tip" not in self._flags:
            return None
        return self.edge(_tip(self.body), Name("SFCTip", self._start), rises=True, at=self._start)
