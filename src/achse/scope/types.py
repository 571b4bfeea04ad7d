"""The types of values that a scope records: numbers of up to 8 bytes.

Each sample is one word of 8 bytes, whatever its type: the value is in the first bytes, the others
are 0. Names and sizes are those of the export of the vendor's tool.
"""

import math
import struct
from dataclasses import dataclass

WORD = 8
"""Bytes of a sample."""

_LEAST, _MOST = -(1 << 63), (1 << 63) - 1


class ScopeError(ValueError):
    """Error in a request to a scope: the key, the expected value and the value that came."""


@dataclass(frozen=True, slots=True)
class ScopeType:
    """One type: its name in exports, its number in symbol entries, its form for `struct`."""

    name: str
    number: int
    code: str
    words: tuple[str, ...]
    """Names of the same in IEC 61131-3."""

    @property
    def size(self) -> int:
        """Bytes of the value."""
        return struct.calcsize(self.code)

    @property
    def real(self) -> bool:
        return self.code in "fd"

    @property
    def signed(self) -> bool:
        return self.code in "bhiq"

    @property
    def mask(self) -> int:
        """The bits of a word that are the value, as a signed number."""
        if self.code == "?":
            return 1
        return -1 if self.size == WORD else (1 << 8 * self.size) - 1

    @property
    def array_code(self) -> str:
        """The type for NumPy."""
        return {"?": "?", "f": "<f4", "d": "<f8"}.get(
            self.code, f"<{'i' if self.signed else 'u'}{self.size}"
        )

    # what orders values: kernels compare whole numbers only --------------------------------------

    @property
    def sign(self) -> int:
        """The bit that makes a word of fewer bytes negative; 0 if there is none."""
        return 1 << 8 * self.size - 1 if (self.signed or self.real) and self.size < WORD else 0

    @property
    def flip(self) -> int:
        """The bits that a negative real number has the other way round."""
        return ((1 << 8 * self.size - 1) - 1) if self.real else 0

    @property
    def turn(self) -> int:
        """The bit that UINT64 has above all signed numbers."""
        return _LEAST if self.code == "Q" else 0

    def key(self, word: int) -> int:
        """Return a whole number for each value, in the same order; -0.0 comes just before 0.0."""
        key = (word ^ self.sign) - self.sign
        return (key ^ self.flip if key < 0 else key) ^ self.turn

    @property
    def keys(self) -> tuple[int, int]:
        """The least and the greatest key that is a value; NaN has others."""
        if self.real:
            return self.key(self.word(-math.inf)), self.key(self.word(math.inf))
        return _LEAST, _MOST

    def word(self, value: float) -> int:
        """Return the word of a value, as a signed number. Raises ScopeError for what the type has
        not."""
        try:
            data = struct.pack(f"<{self.code}", value)
        except (struct.error, OverflowError) as fault:
            raise ScopeError(f"{value!r} is not a {self.name} ({fault})") from None
        return int.from_bytes(data.ljust(WORD, b"\0"), "little", signed=True)

    def key_from(self, bound: float) -> int:
        """Return the least key of values that are `bound` or more, whether the type has it or not.

        One above all keys if there are none.
        """
        least, most = self.keys
        if not self.real:
            low, high = self.range
            if bound > high:
                return _MOST + 1
            # nothing is below the least value: all keys will do
            return self.key(self._whole(max(math.ceil(max(bound, low)), low)))
        nearest = self._nearest(bound)
        key = self.key(self.word(nearest))
        if nearest < bound:
            key += 1
        elif nearest == 0:
            key = -1  # -0.0 is as much as 0.0
        return min(max(key, least), most + 1)

    def key_up_to(self, bound: float) -> int:
        """Return the greatest key of values that are `bound` or less.

        One below all keys if there are none.
        """
        least, most = self.keys
        if not self.real:
            low, high = self.range
            if bound < low:
                return _LEAST - 1
            return self.key(self._whole(min(math.floor(min(bound, high)), high)))
        nearest = self._nearest(bound)
        key = self.key(self.word(nearest))
        if nearest > bound:
            key -= 1
        elif nearest == 0:
            key = 0
        return min(max(key, least - 1), most)

    @property
    def range(self) -> tuple[int, int]:
        """The least and the greatest whole number."""
        if self.code == "?":
            return 0, 1
        bits = 8 * self.size
        return (-(1 << bits - 1), (1 << bits - 1) - 1) if self.signed else (0, (1 << bits) - 1)

    def _whole(self, value: int) -> int:
        return self.word(bool(value) if self.code == "?" else value)

    def _nearest(self, bound: float) -> float:
        """Return the bound as the type has it, or its neighbour."""
        if self.code == "d":
            return bound
        try:
            nearest: float = struct.unpack("<f", struct.pack("<f", bound))[0]
        except OverflowError:
            return math.copysign(math.inf, bound)
        return nearest


SCOPE_TYPES: dict[str, ScopeType] = {
    row.name: row
    for row in (
        ScopeType("BIT", 33, "?", ("BOOL",)),
        ScopeType("INT8", 16, "b", ("SINT",)),
        ScopeType("UINT8", 17, "B", ("USINT", "BYTE")),
        ScopeType("INT16", 2, "h", ("INT",)),
        ScopeType("UINT16", 18, "H", ("UINT", "WORD")),
        ScopeType("INT32", 3, "i", ("DINT",)),
        ScopeType("UINT32", 19, "I", ("UDINT", "DWORD")),
        ScopeType("INT64", 20, "q", ("LINT",)),
        ScopeType("UINT64", 21, "Q", ("ULINT", "LWORD")),
        ScopeType("REAL32", 4, "f", ("REAL",)),
        ScopeType("REAL64", 5, "d", ("LREAL",)),
    )
}
"""By their names."""

_BY_NUMBER = {row.number: row for row in SCOPE_TYPES.values()}
_BY_WORD = {word: row for row in SCOPE_TYPES.values() for word in (row.name, *row.words)}


def type_of_number(number: int) -> ScopeType | None:
    """Return the type with the number that a symbol entry has (ADST id); None if it is not a
    number."""
    return _BY_NUMBER.get(number)


def type_of_words(text: str) -> ScopeType | None:
    """Return the type of a name: `REAL64` or `LREAL`, in any case."""
    return _BY_WORD.get(text.strip().upper())
