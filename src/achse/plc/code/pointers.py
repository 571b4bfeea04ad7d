"""Functions for emitted code that reach memory by an address, or replace a statement in an
expression."""

import struct
from collections.abc import Callable
from typing import Any

from achse.plc.code.faults import ExceptionCode, PlcFault
from achse.plc.code.views import FORMATS, OFFSET_MASK, Views
from achse.plc.memory import ADDRESS_BITS

Parts = tuple[tuple[int, int], ...]


def _violation(address: int) -> PlcFault:
    if not address:
        return PlcFault(ExceptionCode.ACCESS_VIOLATION, "address 0")
    return PlcFault(ExceptionCode.ACCESS_VIOLATION, f"no memory at address 16#{address:X}")


def _load(code: str, views: Views) -> Callable[[int], Any]:
    """Return a function that reads the number at an address."""
    size = struct.calcsize(f"<{code}")
    low = size - 1
    shift = size.bit_length() - 1
    of_area = views.by_area[code]
    bytes_of = views.by_area["B"]
    unpack = struct.Struct(f"<{code}").unpack_from

    def load(address: int) -> Any:
        try:
            if address & low:
                offset = address & OFFSET_MASK
                return unpack(bytes_of[address >> ADDRESS_BITS], offset)[0]
            return of_area[address >> ADDRESS_BITS][(address & OFFSET_MASK) >> shift]
        except (IndexError, struct.error):
            raise _violation(address) from None

    return load


def _store(code: str, views: Views) -> Callable[[int, Any], Any]:
    """Return a function that writes a number at an address, and gives it back."""
    size = struct.calcsize(f"<{code}")
    low = size - 1
    shift = size.bit_length() - 1
    of_area = views.by_area[code]
    bytes_of = views.by_area["B"]
    pack = struct.Struct(f"<{code}").pack_into

    def store(address: int, value: Any) -> Any:
        try:
            if address & low:
                pack(bytes_of[address >> ADDRESS_BITS], address & OFFSET_MASK, value)
            else:
                of_area[address >> ADDRESS_BITS][(address & OFFSET_MASK) >> shift] = value
        except (IndexError, struct.error):
            raise _violation(address) from None
        return value

    return store


def _put(view: Any, index: int, value: Any) -> Any:
    """Store into a view where an expression is needed; gives the value back."""
    view[index] = value
    return value


def pointer_operations(views: Views) -> dict[str, Callable[..., Any]]:
    """Return names in emitted code: `load_h(p)`, `store_H(p, x)`, and those for bytes and bits."""
    bytes_of = views.by_area["B"]

    def load_bytes(address: int, size: int) -> bytes:
        view = bytes_of[address >> ADDRESS_BITS] if address >> ADDRESS_BITS < len(bytes_of) else b""
        offset = address & OFFSET_MASK
        data = bytes(view[offset : offset + size])
        if len(data) < size or not address:
            raise _violation(address)
        return data

    def store_bytes(address: int, value: bytes) -> bytes:
        view: Any = (
            bytes_of[address >> ADDRESS_BITS] if address >> ADDRESS_BITS < len(bytes_of) else b""
        )
        offset = address & OFFSET_MASK
        if offset + len(value) > len(view):
            raise _violation(address)
        view[offset : offset + len(value)] = value
        return value

    def store_parts(address: int, value: bytes, parts: Parts) -> bytes:
        """Return a record without the headers of its function blocks, but for those that are empty:
        raw memory becomes a block by an assignment."""
        at = 0
        for start, end in (*parts, (len(value), len(value))):
            if start > at and not any(load_bytes(address + at, start - at)):
                store_bytes(address + at, value[at:start])
            store_bytes(address + start, value[start:end])
            at = end
        return value

    def load_text(address: int, length: int) -> bytes:
        """Return a STRING: up to its NUL."""
        return load_bytes(address, length).partition(b"\0")[0]

    def load_wide(address: int, length: int) -> bytes:
        """Return a WSTRING: up to its NUL."""
        data = load_bytes(address, length)
        end = data.find(b"\0\0")
        while end % 2 and end > 0:
            end = data.find(b"\0\0", end + 1)
        return data if end < 0 else data[:end]

    def store_text(address: int, value: bytes) -> bytes:
        store_bytes(address, value + b"\0")
        return value

    def store_wide(address: int, value: bytes) -> bytes:
        store_bytes(address, value + b"\0\0")
        return value

    load_byte, store_byte = _load("B", views), _store("B", views)

    def store_bit(address: int, mask: int, state: bool) -> bool:
        old = load_byte(address)
        store_byte(address, old | mask if state else old & ~mask)
        return state

    return {
        "load_bytes": load_bytes,
        "store_bytes": store_bytes,
        "store_parts": store_parts,
        "load_text": load_text,
        "load_wide": load_wide,
        "store_text": store_text,
        "store_wide": store_wide,
        "store_bit": store_bit,
        "put": _put,
        **{f"load_{code}": _load(code, views) for code in FORMATS},
        **{f"store_{code}": _store(code, views) for code in FORMATS},
    }
