"""Object archives: the form in which a `.TcPOU` has its graphical bodies.

`XmlArchive` has `Data` with one root object. Tags: `o` object, `v` scalar, `n` null, `l2` and `l`
list, `a` array, `d2` dictionary whose children are keys and values in turn. The type of a child is
its own `t`, else the `cet` of its list.

Source: public TwinCAT 3 projects, 915 bodies.
"""

import re
from collections.abc import Iterator

from achse.st.lexis.codes import Code
from achse.st.lexis.literals import whole_number
from achse.st.syntax.cursor import Unexpected

_ENTITY = re.compile(r"&(?:#(\d+)|#x([0-9a-fA-F]+)|(\w+));")
_ENTITIES = {"lt": "<", "gt": ">", "amp": "&", "quot": '"', "apos": "'"}
_ATTRIBUTE = re.compile(r'(\w+)="([^"]*)"')
_CDATA = re.compile(r"<!\[CDATA\[(.*?)\]\]>", re.DOTALL)
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_UNUSED = "Comment|SymbolComment|Address|Fixed|Extensible|LValue|Boolean|IsInstance|Description"
"""Scalars that say nothing about what a body does; a network has thousands."""
_TOKEN = re.compile(
    r"<(?:"
    rf'v(?P<scalar>(?:\s(?!n="(?:{_UNUSED})")[^>]*)?)(?<!/)>(?P<text>[^<]*)</v>'
    r"|(?P<end>/)(?:o|l2|l|a|d2)\s*>"
    r"|(?P<open>o|l2|l|a|d2|n|v(?=[^>]*/>))\b(?P<facts>[^>]*)>"
    r")"
)


class ArchiveObject:
    """An object, list or dictionary of an archive."""

    __slots__ = ("at", "items", "members", "type")

    def __init__(self, type: str, at: int) -> None:
        self.type = type
        self.at = at
        """Index of its tag in the text."""
        self.members: dict[str, ArchiveObject | str | None] = {}
        self.items: list[ArchiveObject | str | None] = []
        """Elements of a list; keys and values of a dictionary."""

    def text(self, name: str, default: str = "") -> str:
        """Return a string member without its quotes; the default for null."""
        value = self.members.get(name)
        return unquoted(value) if isinstance(value, str) else default

    def flag(self, name: str) -> bool:
        """Return a Boolean member; False for null."""
        return self.members.get(name) == "true"

    def number(self, name: str, default: int = 0) -> int:
        """Return a whole number, with or without the suffix of a long one."""
        value = self.members.get(name)
        digits = value.strip().removesuffix("L") if isinstance(value, str) else ""
        return whole_number(digits, default)

    def part(self, name: str) -> "ArchiveObject | None":
        """Return an object or list member; None for null."""
        value = self.members.get(name)
        return value if isinstance(value, ArchiveObject) else None

    def objects(self, name: str) -> "list[ArchiveObject]":
        """Return the objects in a list member."""
        members = self.part(name)
        return [] if members is None else list(members)

    def __iter__(self) -> Iterator["ArchiveObject"]:
        return (item for item in self.items if isinstance(item, ArchiveObject))

    @property
    def pairs(self) -> "Iterator[tuple[str, ArchiveObject | str | None]]":
        """Keys, without quotes, and values of a dictionary."""
        for key, value in zip(self.items[::2], self.items[1::2], strict=False):
            if isinstance(key, str):
                yield unquoted(key), value


def unquoted(text: str) -> str:
    """Return a string as the archive has it, without its quotes."""
    return text[1:-1] if len(text) > 1 and text[0] == text[-1] == '"' else text


def read_archive(text: str) -> ArchiveObject:
    """Return the root object. Raises `Unexpected` for anything else.

    The document around it has been parsed before, so it is well-formed.
    """
    text = _blanked(text)
    root = ArchiveObject("", 0)
    stack: list[tuple[ArchiveObject, str]] = [(root, "")]
    start = max(text.find("<Data"), 0)
    end = text.find("</Data>", start)
    for token in _TOKEN.finditer(text, start, end if end >= 0 else len(text)):
        holder, type = stack[-1]
        content: str | None = token["text"]
        if content is not None:
            _add(holder, token["scalar"], _plain(content))
        elif token["end"]:
            if len(stack) == 1:
                raise Unexpected(token.start(), "expected an object archive", Code.BAD_DRAWING)
            stack.pop()
        else:
            facts = token["facts"]
            tag = token["open"]
            if tag in "nv":
                _add(holder, facts, None if tag == "n" else "")
                continue
            attributes: dict[str, str] = dict(_ATTRIBUTE.findall(facts))
            nested = ArchiveObject(attributes.get("t") or type, token.start())
            name = attributes.get("n")
            if name is None:
                holder.items.append(nested)
            else:
                holder.members[name] = nested
            if not facts.endswith("/"):
                inner = "" if tag == "o" else attributes.get("cet", attributes.get("cvt", ""))
                stack.append((nested, inner))
    roots = list(root)
    if len(stack) != 1 or len(roots) != 1:
        raise Unexpected(
            0, "expected an object archive with one object in <Data>", Code.BAD_DRAWING
        )
    return roots[0]


def _add(holder: ArchiveObject, facts: str, value: str | None) -> None:
    place = facts.find('n="')
    # `cn="` and the like do not occur: `n` is the first attribute wherever there is one.
    if place < 0 or (place and facts[place - 1].isalnum()):
        holder.items.append(value)
        return
    name = facts[place + 3 : facts.index('"', place + 3)]
    holder.members[name] = value


def _plain(text: str) -> str:
    return _ENTITY.sub(_entity, text) if "&" in text else text


def _entity(match: "re.Match[str]") -> str:
    decimal, hexadecimal, name = match.groups()
    if name is not None:
        return _ENTITIES.get(name, match[0])
    number = int(decimal) if decimal is not None else int(hexadecimal, 16)
    return chr(number) if number < 0x110000 else match[0]


def _blanked(text: str) -> str:
    """`text` without CDATA parts and comments, which the vendor's tools do not write."""
    if "<![CDATA[" in text:
        text = _CDATA.sub(lambda match: match[1].replace("&", "&amp;").replace("<", "&lt;"), text)
    if "<!--" in text:
        text = _COMMENT.sub(lambda match: " " * len(match[0]), text)
    return text
