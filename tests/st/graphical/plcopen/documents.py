"""PLCopen documents for tests: elements of diagrams, and a PLC that runs a document."""

from itertools import count
from xml.sax.saxutils import escape, quoteattr

from achse.st.files.plcopen.documents import parse_plcopen
from tests.st.graphical.drawings import Drawn

NAMESPACE = "http://www.plcopen.org/xml/tc6_0201"
_rows = count(1)


def facts(**attributes: object) -> str:
    return "".join(f" {name}={quoteattr(str(value))}" for name, value in attributes.items())


def leads(*sources: str | int, tag: str = "connectionPointIn") -> str:
    """Connections from elements `5` or from an output `5.Q`."""
    inside = ""
    for source in sources:
        number, _, name = str(source).partition(".")
        named = f' formalParameter="{name}"' if name else ""
        inside += f'<connection refLocalId="{number}"{named}/>'
    return f"<{tag}>{inside}</{tag}>"


def element(
    tag: str, id: int, inside: str = "", *, y: int | None = None, **attributes: object
) -> str:
    place = f'<position x="10" y="{next(_rows) if y is None else y}"/>'
    return f'<{tag} localId="{id}"{facts(**attributes)}>{place}{inside}</{tag}>\n'


def value(id: int, text: str, **attributes: object) -> str:
    return element("inVariable", id, f"<expression>{escape(text)}</expression>", **attributes)  # type: ignore[arg-type]


def written(id: int, text: str, *sources: str | int, **attributes: object) -> str:
    inside = leads(*sources) + f"<expression>{escape(text)}</expression>"
    return element("outVariable", id, inside, **attributes)  # type: ignore[arg-type]


def rail(id: int = 0) -> str:
    return element("leftPowerRail", id, '<connectionPointOut formalParameter=""/>', y=0)


def contact(id: int, text: str, *sources: str | int, **attributes: object) -> str:
    inside = leads(*sources) + f"<variable>{escape(text)}</variable>"
    return element("contact", id, inside, **attributes)  # type: ignore[arg-type]


def coil(id: int, text: str, *sources: str | int, **attributes: object) -> str:
    inside = leads(*sources) + f"<variable>{escape(text)}</variable>"
    return element("coil", id, inside, **attributes)  # type: ignore[arg-type]


def pin(name: str, *sources: str | int, **attributes: object) -> str:
    return f"<variable{facts(formalParameter=name, **attributes)}>{leads(*sources)}</variable>"


def block(id: int, type: str, *pins: str, outputs: str = "OUT", **attributes: object) -> str:
    out = "".join(f'<variable formalParameter="{name}"/>' for name in outputs.split())
    inside = f"<inputVariables>{''.join(pins)}</inputVariables><inOutVariables/>"
    inside += f"<outputVariables>{out}</outputVariables>"
    return element("block", id, inside, typeName=type, **attributes)  # type: ignore[arg-type]


def variables(**types: str) -> str:
    """Local variables by their types; one of a block or type of the user begins with `.`."""
    text = ""
    for name, type in types.items():
        inner = f"<derived name={quoteattr(type[1:])}/>" if type[0] == "." else f"<{type}/>"
        text += f"<variable name={quoteattr(name)}><type>{inner}</type></variable>\n"
    return f"<interface><localVars>\n{text}</localVars></interface>"


def pou(name: str, interface: str, body: str, kind: str = "program", parts: str = "") -> str:
    head = f'<pou name="{name}" pouType="{kind}">'
    return f"{head}{interface}{parts}<body>{body}</body></pou>\n"


def text(words: str, language: str = "ST") -> str:
    return f"<{language}><xhtml:p><![CDATA[{words}]]></xhtml:p></{language}>"


def document(*pous: str, types: str = "", instances: str = "") -> str:
    return (
        f'<?xml version="1.0"?>\n<project xmlns="{NAMESPACE}" xmlns:xhtml="x">\n<types>\n'
        f"<dataTypes>{types}</dataTypes>\n<pous>\n{''.join(pous)}</pous></types>\n"
        f"<instances>{instances}</instances></project>"
    )


def program(body: str, *more: str, parts: str = "", **types: str) -> Drawn:
    """A program MAIN with variables and a body, that runs."""
    whole = document(pou("MAIN", variables(**types), body, parts=parts), *more)
    return Drawn(parse_plcopen(whole.encode(), "plc.xml", "plc"))


def diagram(language: str, *elements: str) -> str:
    return f"<{language}>\n{''.join(elements)}</{language}>"
