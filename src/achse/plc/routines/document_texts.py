"""Documents of PLC programs, and the texts that they are read from and written to."""

from abc import ABC, abstractmethod
from typing import Generic, Protocol, TypeVar

from achse.plc.code.faults import PlcFault
from achse.plc.routines.builtins import BuiltinContext

LONGEST_TEXT = 1 << 22
"""Bytes of the longest text that is read."""


def decoded(data: bytes) -> str:
    """Return UTF-8 as text, else what Windows-1252 makes of the bytes."""
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("cp1252", "replace")


def text_at(plc: BuiltinContext, address: int) -> str:
    """Return the text that begins there, up to its NUL."""
    content = b""
    size = 4096
    while address and len(content) < LONGEST_TEXT:
        try:
            piece = plc.load_bytes(address + len(content), size)
        except PlcFault:
            if size == 1:
                raise
            size = max(1, size // 8)  # memory may end soon behind the text
            continue
        text, end, _ = piece.partition(b"\0")
        content += text
        if end:
            break
    return decoded(content)


def copy_text(plc: BuiltinContext, text: str, address: int, size: int) -> int:
    """Store a text with its NUL; the bytes stored, 0 if it does not fit."""
    data = text.encode("utf-8") + b"\0"
    if not address or len(data) > size:
        return 0
    plc.store_bytes(address, data)
    return len(data)


def copy_part(plc: BuiltinContext, text: str, offset: int, address: int, size: int) -> int:
    """Store a part of a text, without a NUL; the bytes stored."""
    data = text.encode("utf-8")[offset : offset + size]
    plc.store_bytes(address, data)
    return len(data)


class PendingFile:
    """Bytes of files that documents are read from, by the number of the document."""

    def __init__(self) -> None:
        self._bytes: dict[int, bytearray] = {}

    def add(self, document: int, data: bytes, is_last: bool) -> str | None:
        """Add the next bytes; the whole text with the last of them, None before."""
        pending = self._bytes.setdefault(document, bytearray())
        pending += data[: LONGEST_TEXT - len(pending)]
        return decoded(bytes(self._bytes.pop(document))) if is_last else None


class KeptNode(Protocol):
    """A node of a document, known by its number."""

    number: int


Node = TypeVar("Node", bound=KeptNode)
"""Type of the nodes of a kind of document."""


class KeptDocuments(ABC, Generic[Node]):
    """The documents of one PLC: each is a tree of nodes, which programs know by numbers."""

    def __init__(self) -> None:
        self._roots: dict[int, Node] = {}
        self._last = 0
        self._pending = PendingFile()

    def start(self, document: int) -> int:
        """Return the number of an empty document: number 0 gets a new one."""
        if document not in self._roots:
            document = self._next()
        else:
            self._drop(self._roots[document])
        self._roots[document] = self._keep(self._empty(), None)
        return document

    def end(self, document: int) -> bool:
        """Forget a document, and return True if there was one."""
        root = self._roots.pop(document, None)
        if root is not None:
            self._drop(root)
        return root is not None

    def root(self, document: int) -> int:
        """Return the number of the node that holds the whole document."""
        root = self._roots.get(document)
        return 0 if root is None else root.number

    @abstractmethod
    def read(self, document: int, text: str) -> bool:
        """Put a text into a document; False if it is not of its form."""
        ...

    def feed(self, document: int, data: bytes, is_last: bool) -> bool:
        """Put the next bytes of a file into a document, which is read with the last of them."""
        text = self._pending.add(document, data, is_last)
        return text is None or self.read(document, text)

    def _next(self) -> int:
        self._last += 1
        return self._last

    @abstractmethod
    def _empty(self) -> Node: ...

    @abstractmethod
    def _keep(self, node: Node, parent: Node | None) -> Node: ...

    @abstractmethod
    def _drop(self, node: Node) -> None: ...
