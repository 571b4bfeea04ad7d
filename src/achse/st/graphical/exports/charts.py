"""Sequential function charts in `.EXP`: steps with their statements, transitions by names.

`STEP name: statements END_STEP`, behind it comments with its times, and
`TRANSITION FROM a TO (b, c) := condition END_TRANSITION`. The statements of a step run in each
call while it is active.

Source: an export in a public repository; entry and exit actions and IEC steps were not seen.
"""

import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from achse.st.graphical.chart_flow import Firing, StepFlow
from achse.st.graphical.charts import ChartStep, ChartTransition
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected

_STEP = re.compile(
    r"^[ \t]*(INITIAL_)?STEP\s+(\w+)\s*:(?P<body>.*?)^[ \t]*END_STEP\b",
    re.DOTALL | re.MULTILINE | re.IGNORECASE,
)
_TRANSITION = re.compile(
    r"^[ \t]*TRANSITION\s+FROM\s*(?P<left>\(.*?\)|\w+)\s+TO\s*(?P<right>\(.*?\)|\w+)\s*:="
    r"(?P<condition>.*?)^[ \t]*END_TRANSITION\b",
    re.DOTALL | re.MULTILINE | re.IGNORECASE,
)
_TIME = r"\s*\(\*\s*@SFC{}\s*:=\s*'([^']*)'\s*\*\)"
_TIMES = re.compile(_TIME.format("MAXTIME") + _TIME.format("MINTIME"), re.IGNORECASE)
_UNSEEN = re.compile(r"^[ \t]*(_\w+_BODY|ENTRY_ACTION|EXIT_ACTION)\b", re.MULTILINE)
_COMMENT = re.compile(r"\(\*.*?\*\)", re.DOTALL)


class StepBody(NamedTuple):
    """The statements of a step: name of their action, and their range in the text."""

    action: str
    start: int
    end: int


def step_bodies(text: str) -> Iterator[StepBody]:
    """Return the statements of steps that have any."""
    for match in _STEP.finditer(text):
        if match["body"].strip():
            yield StepBody(_action_of(match[2]), match.start("body"), match.end("body"))


def _action_of(step: str) -> str:
    return f"__{step}_main"


def read_exported_steps(text: str) -> Sequence[ChartStep]:
    """Return the steps of a chart. Raises `Unexpected`."""
    steps = []
    for match in _STEP.finditer(text):
        unseen = _UNSEEN.search(match["body"])
        if unseen is not None:
            raise Unexpected(
                match.start("body") + unseen.start(1),
                f"'{unseen[1]}' is not supported in a step",
                Code.UNSUPPORTED_DRAWING,
            )
        times = _TIMES.match(text, match.end())
        steps.append(
            ChartStep(
                match[2],
                match[1] is not None,
                "",
                _action_of(match[2]) if match["body"].strip() else "",
                "",
                "" if times is None else times[2].strip(),
                "" if times is None else times[1].strip(),
                (),
                match.start(2),
            )
        )
    return steps


def read_exported_flow(text: str) -> StepFlow:
    """Return the flow of a chart. Raises `Unexpected`."""
    flow = StepFlow(read_exported_steps(text))
    for match in _TRANSITION.finditer(text):
        at = match.start("condition")
        condition = _COMMENT.sub(" ", match["condition"]).strip().rstrip("; ")
        left = tuple(flow.step(name, at) for name in re.findall(r"\w+", match["left"]))
        right = [flow.step(name, at) for name in re.findall(r"\w+", match["right"])]
        flow.firings.append(Firing(ChartTransition(condition, at), left, right))
    return flow
