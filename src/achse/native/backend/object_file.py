"""Object files in executable memory without LLVM: ELF for x86-64 on Linux.

Kept machine code needs no compiler: LLVM takes 70 MB of memory and longer to load than all else of
a kernel. Files of other kinds are for LLVM (`ObjectFileError`).

Source: System V ABI, chapter 4 (object files); its supplement for x86-64, 4.4 (relocation).
"""

import ctypes
import mmap
import platform
import struct
import sys
from collections.abc import Callable, Iterator
from enum import IntEnum, IntFlag
from functools import cache
from typing import NamedTuple

_MAGIC = b"\x7fELF\x02\x01"
"""64 bits, the lowest byte first."""
_RELOCATABLE, _X86_64 = 1, 62

_HEADER = struct.Struct("<16sHHIQQQIHHHHHH")
_SECTION = struct.Struct("<IIQQQQIIQQ")
_SYMBOL = struct.Struct("<IBBHQQ")
_RELOCATION = struct.Struct("<QQq")

_FRAMES = ".eh_frame"
"""Section for unwinding the stack, which machine code does not do here."""

_UNDEFINED, _RESERVED, _COMMON = 0, 0xFF00, 0xFFF2
"""Section numbers of symbols."""

_SLOT = 8
_JUMP = b"\xff\x25"
"""jmp [rip + distance]"""
_JUMP_SIZE = 6


class ObjectFileError(ValueError):
    """An object file is not of the kind that is loaded here."""


class ExecutableMemoryError(RuntimeError):
    """The system refuses memory for machine code."""


class _Type(IntEnum):
    """Type of a section."""

    SYMBOLS = 2
    RELOCATIONS = 4
    ZEROS = 8


class _Flags(IntFlag):
    """Use of a section in memory."""

    WRITABLE = 1
    LOADED = 2
    CODE = 4


class _Relocation(IntEnum):
    """Kinds of relocations: S is the symbol, A the addend, P the place, G an entry with S."""

    ABSOLUTE = 1
    """S + A, 64 bits."""
    RELATIVE = 2
    """S + A - P, 32 bits."""
    CALL = 4
    """The same; to S by a jump if it is far away."""
    ENTRY_CALL = 41
    """G + A - P, 32 bits."""
    ENTRY = 42
    """The same."""


class _Section(NamedTuple):
    name: int
    type: int
    flags: int
    address: int
    offset: int
    size: int
    link: int
    info: int
    alignment: int
    entry_size: int


class _Symbol(NamedTuple):
    name: int
    kind: int
    other: int
    section: int
    value: int
    size: int


def is_supported() -> bool:
    """True if object files of this machine are loaded here."""
    return sys.platform == "linux" and platform.machine() == "x86_64"


class ObjectFile:
    """An object file in memory of its own, as long as anything refers to this.

    `outside` gives the addresses of functions that are not in the file, 0 for unknown ones. Raises
    ObjectFileError.
    """

    def __init__(self, content: bytes, outside: Callable[[str], int]) -> None:
        self._content = content
        self._outside = outside
        self._entries: dict[int, int] = {}
        """Places of addresses in memory, by the address."""
        self._jumps: dict[int, int] = {}
        """Places of jumps in memory, by the address to which they lead."""
        try:
            self._load()
        except ObjectFileError:
            raise
        except (struct.error, LookupError, ValueError, OverflowError, OSError) as failure:
            raise ObjectFileError(f"expected a whole object file: {failure}") from None
        finally:
            self._content = b""

    def _load(self) -> None:
        self._sections = self._read_header()
        symbols = next((s for s in self._sections if s.type == _Type.SYMBOLS), None)
        if symbols is None:
            raise ObjectFileError("expected an object file with a table of symbols")
        self._names = self._sections[symbols.link].offset
        table = self._content[symbols.offset : symbols.offset + symbols.size]
        self._symbols = [_Symbol._make(each) for each in _SYMBOL.iter_unpack(table)]
        self._place_sections()
        self._values = [self._value_of(each) for each in self._symbols]
        self._addresses = {
            self._text(self._names + symbol.name): value
            for symbol, value in zip(self._symbols, self._values, strict=True)
            if symbol.name and symbol.section != _UNDEFINED
        }
        for section in self._sections:
            if section.type == _Type.RELOCATIONS and section.info in self._places:
                self._relocate(section)
        self._protect()
        self._symbols, self._values = [], []

    def address_of(self, name: str) -> int:
        """Return the address of a function or of data; 0 if the file has none of this name."""
        return self._addresses.get(name, 0)

    def _read_header(self) -> list[_Section]:
        content = self._content
        if len(content) < _HEADER.size or not content.startswith(_MAGIC):
            raise ObjectFileError("expected an ELF file of 64 bits")
        _, kind, machine, *_, offset, _, _, _, _, size, count, names = _HEADER.unpack_from(content)
        if (kind, machine, size) != (_RELOCATABLE, _X86_64, _SECTION.size):
            raise ObjectFileError("expected a relocatable file for x86-64")
        sections = [
            _Section._make(_SECTION.unpack_from(content, offset + n * size)) for n in range(count)
        ]
        self._section_names = sections[names].offset
        return sections

    def _text(self, offset: int) -> str:
        end = self._content.find(b"\0", offset)
        if end < offset:
            raise ObjectFileError(f"expected a name at byte {offset}")
        return self._content[offset:end].decode()

    def _place_sections(self) -> None:
        """Copy the sections into memory: code and constants first, then what is written."""
        loaded = [
            (n, section)
            for n, section in enumerate(self._sections)
            if section.flags & _Flags.LOADED
            and self._text(self._section_names + section.name) != _FRAMES
        ]
        loaded.sort(key=lambda each: each[1].flags & _Flags.WRITABLE)
        self._places: dict[int, int] = {}
        """Places of sections in memory, by their numbers."""
        end, self._protected = 0, 0
        outside = sum(1 for each in self._symbols if each.section == _UNDEFINED)
        entries = _SLOT * (len(self._symbols) + outside) + _SLOT * outside
        for n, section in loaded:
            if section.flags & _Flags.WRITABLE and not self._protected:
                self._spare = -(-end // _SLOT) * _SLOT
                end = self._protected = _whole_pages(self._spare + entries)
            alignment = max(section.alignment, 1)
            if alignment > mmap.PAGESIZE:
                raise ObjectFileError(f"expected an alignment of a page at most, got {alignment}")
            self._places[n] = end = -(-end // alignment) * alignment
            end += section.size
        if not self._protected:
            self._spare = -(-end // _SLOT) * _SLOT
            end = self._protected = _whole_pages(self._spare + entries)
        flags = mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS  # forked processes have words of their own
        self._memory = mmap.mmap(-1, _whole_pages(end) or mmap.PAGESIZE, flags)
        self._base = ctypes.addressof(ctypes.c_char.from_buffer(self._memory))
        for n, section in loaded:
            if section.type != _Type.ZEROS:
                begin = self._places[n]
                self._memory[begin : begin + section.size] = self._content[
                    section.offset : section.offset + section.size
                ]

    def _value_of(self, symbol: _Symbol) -> int:
        """Return the address that a symbol stands for; 0 for one of a section that is left out."""
        if symbol.section == _UNDEFINED:
            if not symbol.name:
                return 0
            name = self._text(self._names + symbol.name)
            address = self._outside(name)
            if not address:
                raise ObjectFileError(f"expected a function outside, {name!r} is unknown")
            return address
        if symbol.section >= _RESERVED:
            if symbol.section == _COMMON:
                raise ObjectFileError("expected data in sections")
            return symbol.value
        place = self._places.get(symbol.section)
        return 0 if place is None else self._base + place + symbol.value

    def _relocate(self, relocations: _Section) -> None:
        """Write addresses and distances into a section."""
        memory, values, symbols = self._memory, self._values, self._symbols
        begin, base = self._places[relocations.info], self._base
        words, distances = struct.Struct("<Q"), struct.Struct("<i")
        for offset, info, addend in self._relocations(relocations):
            kind, number = info & 0xFFFF_FFFF, info >> 32
            at, value = begin + offset, values[number]
            if kind == _Relocation.ABSOLUTE:
                words.pack_into(memory, at, value + addend & 0xFFFF_FFFF_FFFF_FFFF)
                continue
            if kind in (_Relocation.ENTRY, _Relocation.ENTRY_CALL):
                value = base + self._entry(value)
            elif kind not in (_Relocation.RELATIVE, _Relocation.CALL):
                raise ObjectFileError(f"expected a known kind of relocation, got {kind}")
            elif symbols[number].section == _UNDEFINED:
                value = base + self._jump(value)
            try:
                distances.pack_into(memory, at, value + addend - base - at)
            except struct.error:
                raise ObjectFileError("expected code of less than 2 GB") from None

    def _relocations(self, section: _Section) -> Iterator[tuple[int, int, int]]:
        table = self._content[section.offset : section.offset + section.size]
        return _RELOCATION.iter_unpack(table)

    def _entry(self, address: int) -> int:
        """Return the place of an address in memory."""
        place = self._entries.get(address)
        if place is None:
            place = self._entries[address] = self._spare
            self._spare += _SLOT
            struct.pack_into("<Q", self._memory, place, address)
        return place

    def _jump(self, address: int) -> int:
        """Return the place of a jump to an address far away."""
        place = self._jumps.get(address)
        if place is None:
            entry = self._entry(address)
            place = self._jumps[address] = self._spare
            self._spare += _SLOT
            code = _JUMP + struct.pack("<i", entry - place - _JUMP_SIZE)
            self._memory[place : place + _JUMP_SIZE] = code
        return place

    def _protect(self) -> None:
        """Let code and constants be executed and read, no longer written."""
        error = _let_execute(self._base, self._protected)
        if error:
            raise ObjectFileError(f"expected memory for code, error {error}")


def _let_execute(address: int, size: int) -> int:
    """Let pages be executed and read, no longer written; return the error, 0 for none."""
    library = ctypes.CDLL(None, use_errno=True)
    protection = mmap.PROT_READ | mmap.PROT_EXEC
    if library.mprotect(ctypes.c_void_p(address), ctypes.c_size_t(size), protection):
        return ctypes.get_errno()
    return 0


@cache
def memory_may_be_executed() -> bool:
    """True if memory that was written may be executed.

    Hardened services may not (systemd's MemoryDenyWriteExecute, SELinux without execmem). LLVM does
    not see that it was refused: its code would end the process.
    """
    if sys.platform != "linux":
        return True
    page = mmap.mmap(-1, mmap.PAGESIZE, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    return not _let_execute(ctypes.addressof(ctypes.c_char.from_buffer(page)), mmap.PAGESIZE)


def _whole_pages(size: int) -> int:
    return -(-size // mmap.PAGESIZE) * mmap.PAGESIZE
