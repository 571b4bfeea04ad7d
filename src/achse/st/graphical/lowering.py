"""Bodies of all graphical languages lowered to statements, each by its language."""

from achse.st.graphical.body import BodyScope, GraphicalBody, Refused
from achse.st.graphical.chart_lowering import implicit_variables_of_chart, lowered_chart
from achse.st.graphical.function_chart_lowering import (
    implicit_variables_of_function_chart,
    lowered_function_chart,
)
from achse.st.graphical.network_lowering import lowered_networks, memories_of_networks
from achse.st.tree import Statements, VarBlock

__all__ = ["implicit_variables", "lowered"]


def implicit_variables(body: GraphicalBody) -> tuple[VarBlock, ...]:
    """Return the variables that a unit keeps for a body."""
    if body.language == "NWL":
        return memories_of_networks(body)
    if body.language == "SFC":
        return implicit_variables_of_chart(body)
    if body.language == "CFC":
        return implicit_variables_of_function_chart(body)
    return ()


def lowered(body: GraphicalBody, scope: BodyScope) -> Statements:
    """Return the statements of a body. Raises `Refused` and `Unexpected`."""
    if body.language == "NWL":
        return lowered_networks(body, scope)
    if body.language == "SFC":
        return lowered_chart(body, scope)
    if body.language == "CFC":
        return lowered_function_chart(body, scope)
    name = _NAMES.get(body.language, body.language)
    raise Refused(body.name_place(0, "the body"), f"{name} is not supported")


_NAMES = {"LADDER": "the new ladder editor's form", "StateChart": "a UML state chart"}
