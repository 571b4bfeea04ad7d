"""Signatures of blocks and interfaces, read from the `<DataType>` elements of a `.tmc`.

A property is a method named `__getNAME` or `__setNAME`. FB_init and its kin are left out: few
files have them, and with the arguments of none.

Source: `.tmc` files of public projects: `<Implements>`, `<ExtendsType>`, `<Method>`.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace

from achse.st.declared.signatures import (
    BlockSignature,
    MethodSignature,
    ParameterSection,
    ParameterSignature,
    PropertySignature,
    is_open_array,
    open_array,
)
from achse.st.lexis.xml import Element

_LIFECYCLE = ("fb_init", "fb_exit", "fb_reinit")
_ROOTS = ("pvoid", "")
"""Bases in a file that a declaration does not write."""


def read_signature(
    element: Element,
    text_of: Callable[[Element, Element], str],
    is_known: Callable[[str], bool],
    properties_of: Callable[[Element], dict[str, str]],
) -> BlockSignature:
    """Return the signature of a `<DataType>`, without methods of unknown types.

    `text_of` returns the type that an element names within its owner as text, `properties_of` the
    properties of a parameter.
    """
    signature = BlockSignature(
        _base(element, text_of),
        tuple(text_of(item, item) for item in element.all("Implements")),
    )
    for item in element.all("Method"):
        method = _method(item, text_of, properties_of)
        key = method.name.lower()
        types = [method.returns, *(one.type for one in method.parameters)]
        if key in _LIFECYCLE or not all(is_known(one.replace("*", "0..0")) for one in types if one):
            continue
        if key.startswith(("__get", "__set")):
            _add_accessor(signature.properties, method)
        elif not key.startswith("__"):
            signature.methods.setdefault(key, method)
    return signature


def _base(element: Element, text_of: Callable[[Element, Element], str]) -> str:
    extended = element.find("ExtendsType")
    if extended is None and element.find("Method") is not None:
        extended = element.find("BaseType")  # of an interface of TcCOM
    text = "" if extended is None else text_of(extended, extended)
    return "" if text.lower() in _ROOTS else text


def _method(
    element: Element,
    text_of: Callable[[Element, Element], str],
    properties_of: Callable[[Element], dict[str, str]],
) -> MethodSignature:
    result = element.find("ReturnType")
    return MethodSignature(
        element.text_of("Name").strip(),
        "" if result is None else text_of(result, element),
        tuple(_parameters(element, text_of, properties_of)),
    )


def _parameters(
    element: Element,
    text_of: Callable[[Element, Element], str],
    properties_of: Callable[[Element], dict[str, str]],
) -> Iterator[ParameterSignature]:
    sections: dict[str, ParameterSection] = {"Output": "VAR_OUTPUT", "InOut": "VAR_IN_OUT"}
    for item in element.all("Parameter"):
        properties = properties_of(item)
        section = sections.get(properties.get("ItemType", ""), "VAR_INPUT")
        type = text_of(item.child("Type"), item)
        if is_open_array(properties):
            section, type = "VAR_IN_OUT", open_array(type, properties)
        elif section == "VAR_IN_OUT":
            type = type.removeprefix("REFERENCE TO ")
        yield ParameterSignature(item.text_of("Name").strip(), type, section)


def _add_accessor(properties: dict[str, PropertySignature], method: MethodSignature) -> None:
    name = method.name[len("__get") :]
    type = method.returns or next((one.type for one in method.parameters), "")
    if not name or not type:
        return
    signature = properties.get(name.lower(), PropertySignature(name, type))
    if method.name.lower().startswith("__get"):
        signature = replace(signature, readable=True)
    else:
        signature = replace(signature, writable=True)
    properties[name.lower()] = signature
