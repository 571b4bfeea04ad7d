"""Bodies of all graphical languages lowered to statements or drawn, each by its file's form."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from achse.st.graphical.body import BodyScope, GraphicalBody, Refused
from achse.st.graphical.chart_lowering import (
    ARCHIVED_CHARTS,
    ChartForm,
    implicit_variables_of_chart,
    lowered_chart,
)
from achse.st.graphical.exports.charts import read_exported_flow, read_exported_steps
from achse.st.graphical.exports.function_charts import read_exported_function_chart
from achse.st.graphical.exports.networks import read_exported_networks
from achse.st.graphical.function_chart_lowering import (
    ChartReader,
    implicit_variables_of_function_chart,
    lowered_function_chart,
)
from achse.st.graphical.function_charts import read_function_chart
from achse.st.graphical.instruction_text import read_instruction_text
from achse.st.graphical.ladder_model import read_ladder
from achse.st.graphical.network_lowering import lowered_networks, memories_of_networks
from achse.st.graphical.networks import NetworkList, read_networks
from achse.st.graphical.pictures import (
    OperandValue,
    chart_lines,
    function_chart_lines,
    network_lines,
)
from achse.st.graphical.plcopen.charts import read_drawn_flow, read_drawn_steps
from achse.st.graphical.plcopen.diagrams import read_diagram
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import Statements, VarBlock


class _Form(NamedTuple):
    """Readers of a body in one form: its statements, variables and picture."""

    statements: Callable[[GraphicalBody, BodyScope], Statements]
    variables: Callable[[GraphicalBody], tuple[VarBlock, ...]]
    picture: Callable[[GraphicalBody, OperandValue], list[str]]


def _none(body: GraphicalBody) -> tuple[VarBlock, ...]:
    return ()


def _networks(read: Callable[[str], NetworkList], *, has_edges: bool = False) -> _Form:
    variables = memories_of_networks if has_edges else _none
    return _Form(
        partial(lowered_networks, read=read),
        variables,
        lambda body, value: network_lines(read(body.text), value),
    )


def _function_chart(read: ChartReader) -> _Form:
    return _Form(
        partial(lowered_function_chart, read=read),
        partial(implicit_variables_of_function_chart, read=read),
        lambda body, value: function_chart_lines(read(body.text), value),
    )


def _chart(form: ChartForm) -> _Form:
    return _Form(
        partial(lowered_chart, form=form),
        partial(implicit_variables_of_chart, form=form),
        lambda body, value: chart_lines(form.flow(body.text), value),
    )


_FORMS = {
    "NWL": _networks(read_networks, has_edges=True),
    "LADDER": _networks(read_ladder),
    "SFC": _chart(ARCHIVED_CHARTS),
    "CFC": _function_chart(read_function_chart),
    "EXP_LD": _networks(read_exported_networks),
    "EXP_FBD": _networks(read_exported_networks),
    "EXP_IL": _networks(read_instruction_text),
    "EXP_SFC": _chart(ChartForm(read_exported_steps, read_exported_flow)),
    "EXP_CFC": _function_chart(read_exported_function_chart),
    "PLCOPEN_LD": _function_chart(read_diagram),
    "PLCOPEN_FBD": _function_chart(read_diagram),
    "PLCOPEN_CFC": _function_chart(read_diagram),
    "PLCOPEN_SFC": _chart(ChartForm(read_drawn_steps, read_drawn_flow)),
}
"""Forms of bodies, by their languages."""


def implicit_variables(body: GraphicalBody) -> tuple[VarBlock, ...]:
    """Return the variables that a unit keeps for a body. What cannot be read has none."""
    form = _FORMS.get(body.language)
    try:
        return () if form is None else form.variables(body)
    except RecursionError:
        return ()


def lowered(body: GraphicalBody, scope: BodyScope) -> Statements:
    """Return the statements of a body. Raises `Refused` and `Unexpected`."""
    form = _FORMS.get(body.language)
    if form is None:
        raise Refused(
            body.name_place(0, "the body"),
            "a UML state chart is not supported",
            Code.UNSUPPORTED_DRAWING,
        )
    try:
        return form.statements(body, scope)
    except RecursionError:
        raise Refused(
            body.name_place(0, "the body"), "elements nest too deep", Code.TOO_DEEP
        ) from None


def picture(body: GraphicalBody, value: OperandValue) -> list[str]:
    """Return a body as lines of text, with the values that `value` knows. Raises `Unexpected`."""
    form = _FORMS.get(body.language)
    if form is None:
        raise Unexpected(0, "a UML state chart is not supported", Code.UNSUPPORTED_DRAWING)
    try:
        return form.picture(body, value)
    except RecursionError:
        raise Unexpected(0, "elements nest too deep", Code.TOO_DEEP) from None
