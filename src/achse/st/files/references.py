"""Libraries that a project references in its `.plcproj`.

A reference names a library by title, wants a version of it, gives it a name space in the project,
and may set its parameters: constants of lists that the library marks for that.

Source: project files of TwinCAT 3, seen in public projects.
"""

from collections.abc import Mapping
from typing import NamedTuple

from achse.st.lexis.xml import Element

_NEWEST = ("", "*", "newest")


class LibraryReference(NamedTuple):
    """A library that a project names."""

    title: str
    version: str
    """Pinned version, `3.3.59.0`; empty for any."""
    namespace: str
    parameters: Mapping[tuple[str, str], str]
    """Structured Text by list and constant in lower case; the list is empty in older files."""
    placeholder: str = ""
    """Name of the placeholder in the project, if the library is not fixed; else empty."""

    @property
    def titles(self) -> list[str]:
        """Titles to search for, in the form of `plain_title`."""
        return [plain_title(name) for name in (self.title, self.placeholder) if name]

    def __str__(self) -> str:
        return f"{self.title} {self.version}".rstrip()


def plain_title(title: str) -> str:
    """Return a title for comparing: projects write one library's as `[My Library]` and
    `My_Library`."""
    return "".join(sign for sign in title.lower() if sign.isalnum())


def references_of(root: Element) -> list[LibraryReference]:
    """Return the references of a project in order. A placeholder is
    replaced by its resolution."""
    resolved: dict[str, str] = {}
    elements: list[Element] = []
    for element in root.walk():
        name = element.attributes.get("Include", "").strip()
        if element.tag == "PlaceholderResolution":
            resolved[name.lower()] = element.text_of("Resolution")
        elif element.tag in ("PlaceholderReference", "LibraryReference") and name:
            elements.append(element)
    return [_reference(element, resolved) for element in elements]


def _reference(element: Element, resolved: Mapping[str, str]) -> LibraryReference:
    name = element.attributes["Include"].strip()
    if element.tag == "LibraryReference":
        title, version = _split(name)
    else:
        title, version = _split(resolved.get(name.lower()) or element.text_of("DefaultResolution"))
        title = title or name
    namespace = element.text_of("Namespace").strip() or title.replace(" ", "_").replace("-", "_")
    parameters = {
        (
            item.attributes.get("ListName", "").strip().lower(),
            item.text_of("Key").strip().lower(),
        ): item.text_of("Value").strip()
        for item in element.walk()
        if item.tag == "Parameter" and item.text_of("Value").strip()
    }
    placeholder = name if element.tag == "PlaceholderReference" else ""
    return LibraryReference(title, version, namespace, parameters, placeholder)


def _split(text: str) -> tuple[str, str]:
    """Title and version of `Tc2_MC2, 3.3.59.0 (Vendor)` or `Tc2_MC2,3.3.59.0,Vendor`."""
    title, _, rest = text.partition(",")
    version = rest.split("(")[0].split(",")[0].strip()
    return title.strip(), "" if version in _NEWEST else version
