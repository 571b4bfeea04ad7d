"""Interfaces in PLCopen XML as the text of declarations.

Each variable is on the line of its element: what is wrong with it has its place in the file.

Source: PLCopen TC6 XML schema 2.01 as public projects use it.
"""

from collections.abc import Iterable, Iterator

from achse.st.files.owners import address_for_station
from achse.st.lexis.source import Location
from achse.st.lexis.xml import Element

_SECTIONS = {
    "inputVars": "VAR_INPUT",
    "outputVars": "VAR_OUTPUT",
    "inOutVars": "VAR_IN_OUT",
    "localVars": "VAR",
    "tempVars": "VAR_TEMP",
    "externalVars": "VAR_EXTERNAL",
    "globalVars": "VAR_GLOBAL",
}
_QUALIFIERS = {"constant": "CONSTANT", "retain": "RETAIN", "persistent": "PERSISTENT"}
_HEADS = {"program": "PROGRAM", "functionBlock": "FUNCTION_BLOCK", "function": "FUNCTION"}
_MODIFIERS = ("Private", "Protected", "Internal", "Public", "Abstract", "Final")


def data_of(element: Element, tag: str) -> Iterator[Element]:
    """Elements of a tag in the `addData` of an element."""
    for added in element.all("addData"):
        for data in added.all("data"):
            yield from data.all(tag)


def plain_text(element: Element) -> Element | None:
    """Return the element with the whole declaration as text, as some vendors add it."""
    for text in (element.find("InterfaceAsPlainText"), *data_of(element, "InterfaceAsPlainText")):
        if text is not None:
            return text.find("xhtml") or text
    return None


def type_text(element: Element | None) -> str:
    """Return the type in a `type` or `baseType` element as Structured Text."""
    for child in element.children if element is not None else ():
        match child.tag:
            case "derived":
                return child.attributes.get("name", "")
            case "string" | "wstring":
                length = child.attributes.get("length")
                return child.tag.upper() + (f"({length})" if length else "")
            case "array":
                bounds = ", ".join(_bounds(one) for one in child.all("dimension"))
                return f"ARRAY[{bounds}] OF {type_text(child.find('baseType'))}"
            case "pointer":
                return f"POINTER TO {type_text(child.find('baseType'))}"
            case "reference":
                return f"REFERENCE TO {type_text(child.find('baseType'))}"
            case "subrangeSigned" | "subrangeUnsigned":
                return f"{type_text(child.find('baseType'))} ({_bounds(child.find('range'))})"
            case "enum":
                return f"({', '.join(_values(child))})"
            case "addData":
                continue
            case tag:
                return tag.upper()
    return ""


def _bounds(dimension: Element | None) -> str:
    attributes = {} if dimension is None else dimension.attributes
    return f"{attributes.get('lower', '')}..{attributes.get('upper', '')}"


def _values(element: Element) -> Iterator[str]:
    for one in (value for values in element.all("values") for value in values.all("value")):
        number = one.attributes.get("value")
        yield one.attributes.get("name", "") + (f" := {number}" if number else "")


def value_text(element: Element) -> str:
    """Return the value in an `initialValue` or `value` element as Structured Text."""
    for child in element.children:
        if child.tag == "simpleValue":
            return child.attributes.get("value", "")
        if child.tag == "arrayValue":
            return f"[{', '.join(map(_repeated, child.all('value')))}]"
        if child.tag == "structValue":
            items = (
                f"{one.attributes.get('member', '')} := {value_text(one)}"
                for one in child.all("value")
            )
            return f"({', '.join(items)})"
    return ""


def _repeated(value: Element) -> str:
    count = value.attributes.get("repetitionValue", "1")
    return value_text(value) if count in ("", "1") else f"{count}({value_text(value)})"


class DeclarationText:
    """Text that grows; `element` is it as the declaration of a unit at a place in the file."""

    def __init__(self, at: Location) -> None:
        self._at = at
        self._line = at.line
        self._pieces: list[str] = []

    def put(self, text: str, at: Location | None = None) -> None:
        """Add text, on the line of a place if that is further down."""
        if at is not None and at.line > self._line:
            self._pieces.append("\n" * (at.line - self._line))
            self._line = at.line
        self._pieces.append(text + " ")

    @property
    def element(self) -> Element:
        """The text as an element."""
        element = Element("Declaration", {}, self._at)
        element.text = "".join(self._pieces)
        return element

    # declarations ------------------------------------------------------------------------------

    def unit(self, element: Element, interface: Element | None) -> None:
        """Write the head and the variables of a program, function block or function."""
        head = _HEADS.get(element.attributes.get("pouType", ""), "FUNCTION_BLOCK")
        self._attributes((element, interface))
        self.put(" ".join([head, *_modifiers(interface), element.attributes.get("name", "")]))
        self._bases(interface)
        self.returns(interface)
        self.variables(interface)

    def method(self, element: Element, interface: Element | None) -> None:
        """Write the head and the variables of a method."""
        self._attributes((element, interface))
        words = ["METHOD", *_modifiers(interface), element.attributes.get("name", "")]
        self.put(" ".join(words), element.location)
        self.returns(interface)
        self.variables(interface)

    def property(self, element: Element, interface: Element | None) -> None:
        """Write the head of a property."""
        words = ["PROPERTY", *_modifiers(interface), element.attributes.get("name", "")]
        self.put(" ".join(words), element.location)
        self.returns(interface)

    def returns(self, interface: Element | None) -> None:
        """Write the type of a result."""
        type = None if interface is None else interface.find("returnType")
        if type is not None:
            self.put(f": {type_text(type)}", type.location)

    def variables(self, interface: Element | None) -> None:
        """Write the blocks of variables."""
        for block in interface.children if interface is not None else ():
            if block.tag in _SECTIONS:
                self.block(block)

    def block(self, block: Element) -> None:
        """Write one block of variables."""
        if block.tag == "globalVars":
            self._attributes((block,))
        words = [word for key, word in _QUALIFIERS.items() if block.attributes.get(key) == "true"]
        self.put(" ".join([_SECTIONS[block.tag], *words]), block.location)
        for variable in block.all("variable"):
            self._variable(variable)
        self.put("END_VAR")

    def _variable(self, element: Element) -> None:
        self._attributes((element,), element.location)
        address = element.attributes.get("address", "").strip()
        placed = f" AT {address_for_station(address)}" if address else ""
        initial = element.find("initialValue")
        value = "" if initial is None else value_text(initial)
        assigned = f" := {value}" if value else ""
        name, type = element.attributes.get("name", ""), type_text(element.find("type"))
        self.put(f"{name}{placed} : {type}{assigned};", element.location)

    def data_type(self, element: Element) -> None:
        """Write a whole TYPE."""
        self._attributes((element,))
        name = element.attributes.get("name", "")
        base = element.find("baseType")
        struct = None if base is None else base.find("struct")
        self.put(f"TYPE {name}")
        self._bases(element)
        self.put(":")
        if struct is not None:
            self.put("STRUCT")
            for variable in struct.all("variable"):
                self._variable(variable)
            self.put("END_STRUCT")
        else:
            initial = element.find("initialValue")
            value = "" if initial is None else value_text(initial)
            self.put(type_text(base) + (f" := {value}" if value else "") + ";")
        self.put("END_TYPE")

    def _bases(self, element: Element | None) -> None:
        for inheritance in data_of(element, "Inheritance") if element is not None else ():
            for tag in ("Extends", "Implements"):
                names = [one.text.strip() for one in inheritance.all(tag)]
                if names:
                    self.put(f"{tag.upper()} {', '.join(names)}")

    def _attributes(self, owners: Iterable[Element | None], at: Location | None = None) -> None:
        for owner in owners:
            for attributes in data_of(owner, "Attributes") if owner is not None else ():
                for one in attributes.all("Attribute"):
                    value = one.attributes.get("Value", "").replace("'", "$'")
                    assigned = f" := '{value}'" if value else ""
                    self.put(f"{{attribute '{one.attributes.get('Name', '')}'{assigned}}}", at)


def _modifiers(interface: Element | None) -> Iterator[str]:
    for modifiers in data_of(interface, "AccessModifiers") if interface is not None else ():
        for word in _MODIFIERS:
            if modifiers.attributes.get(word) == "true":
                yield word.upper()
