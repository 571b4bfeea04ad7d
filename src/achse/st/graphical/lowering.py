"""Bodies of all graphical languages lowered to statements, each by its language."""

from achse.st.graphical.body import BodyScope, GraphicalBody, Refused
from achse.st.graphical.chart_lowering import implicit_variables_of_chart, lowered_chart
from achse.st.graphical.function_chart_lowering import (
    implicit_variables_of_function_chart,
    lowered_function_chart,
)
from achse.st.graphical.ladder_model import read_ladder
from achse.st.graphical.network_lowering import lowered_networks, memories_of_networks
from achse.st.lexis.codes import Code
from achse.st.syntax.tree import Statements, VarBlock

__all__ = ["implicit_variables", "lowered"]


def implicit_variables(body: GraphicalBody) -> tuple[VarBlock, ...]:
    """Return the variables that a unit keeps for a body. What cannot be read has none."""
    try:
        match body.language:
            case "NWL":
                return memories_of_networks(body)
            case "SFC":
                return implicit_variables_of_chart(body)
            case "CFC":
                return implicit_variables_of_function_chart(body)
    except RecursionError:
        pass
    return ()


def lowered(body: GraphicalBody, scope: BodyScope) -> Statements:
    """Return the statements of a body. Raises `Refused` and `Unexpected`."""
    try:
        match body.language:
            case "NWL":
                return lowered_networks(body, scope)
            case "LADDER":
                return lowered_networks(body, scope, read_ladder)
            case "SFC":
                return lowered_chart(body, scope)
            case "CFC":
                return lowered_function_chart(body, scope)
    except RecursionError:
        raise Refused(
            body.name_place(0, "the body"), "elements nest too deep", Code.TOO_DEEP
        ) from None
    raise Refused(
        body.name_place(0, "the body"),
        "a UML state chart is not supported",
        Code.UNSUPPORTED_DRAWING,
    )
