"""Exact counters of instructions and allocations of this process (x86-64, CPython, Linux).

Callgrind counts instructions. A program under Valgrind talks to it by *client requests*: a
sequence of instructions that does nothing elsewhere (Valgrind manual, 3.1). They are called in a
page of machine code, so that no compiler is needed. Another page has a stub before each allocating
function of CPython that adds 1 to a number and jumps on. So each allocation counts, also one whose
memory is free again when the work ends; `sys.getallocatedblocks` sees only what stays.
"""

import ctypes
import mmap
import os
import struct
import sys
from enum import IntEnum

__all__ = ["AllocationCounter", "Callgrind", "is_supported"]

_CLIENT_REQUEST = bytes.fromhex(
    "4889f8"  # mov rax, rdi: address of the request and its arguments
    "31d2"  # xor edx, edx: the result outside Valgrind
    "48c1c703 48c1c70d 48c1c73d 48c1c733"  # rol rdi, 128 bits in all
    "4887db"  # xchg rbx, rbx: Valgrind acts here
    "4889d0 c3"  # mov rax, rdx; ret
)
_INCREMENT, _JUMP = b"\x48\xff\x05", b"\xff\x25"
"""inc qword [rip + distance]; jmp [rip + distance]"""


class _Request(IntEnum):
    """Numbers of client requests, from valgrind.h and callgrind.h."""

    RUNNING_ON_VALGRIND = 0x1001
    ZERO_STATS = 0x4354_0001
    DUMP_STATS_AT = 0x4354_0003
    START_INSTRUMENTATION = 0x4354_0004
    STOP_INSTRUMENTATION = 0x4354_0005


def is_supported() -> bool:
    """True if this processor, system and Python have the counters."""
    return (
        sys.platform == "linux"
        and os.uname().machine == "x86_64"
        and sys.implementation.name == "cpython"
    )


def _executable_page() -> int:
    """Return the address of a page for machine code, which stays until the process ends."""
    allocate = ctypes.CDLL(None).mmap
    allocate.restype = ctypes.c_void_p
    allocate.argtypes = [ctypes.c_void_p, ctypes.c_size_t, *[ctypes.c_int] * 3, ctypes.c_long]
    protection = mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC
    return int(
        allocate(None, mmap.PAGESIZE, protection, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS, -1, 0)
    )


class Callgrind:
    """Control of the Callgrind that runs this process; without Valgrind nothing happens."""

    def __init__(self) -> None:
        address = _executable_page()
        ctypes.memmove(address, _CLIENT_REQUEST, len(_CLIENT_REQUEST))
        self._call = ctypes.CFUNCTYPE(ctypes.c_uint64, ctypes.c_void_p)(address)

    @property
    def is_running(self) -> bool:
        """True if this process runs under Valgrind."""
        return bool(self._request(_Request.RUNNING_ON_VALGRIND))

    def start(self) -> None:
        """Count from now on."""
        self._request(_Request.START_INSTRUMENTATION)

    def stop(self) -> None:
        """Run without counting, some five times as fast."""
        self._request(_Request.STOP_INSTRUMENTATION)

    def zero(self) -> None:
        """Begin at 0 instructions."""
        self._request(_Request.ZERO_STATS)

    def dump(self, name: str) -> None:
        """Write the instructions since `zero` to the next file, under a name."""
        text = ctypes.create_string_buffer(name.encode())
        self._request(_Request.DUMP_STATS_AT, ctypes.addressof(text))

    def _request(self, request: _Request, argument: int = 0) -> int:
        block = (ctypes.c_uint64 * 6)(request, argument)
        return int(self._call(ctypes.addressof(block)))


class _Allocator(ctypes.Structure):
    """PyMemAllocatorEx (Python C API, Memory Management)."""

    _fields_ = tuple(
        (name, ctypes.c_void_p) for name in ("context", "malloc", "calloc", "realloc", "free")
    )


class AllocationCounter:
    """Count of calls of malloc, calloc and realloc in the domains "mem" and "object" of CPython.

    The stubs stay before the allocators until the process ends.
    """

    _DOMAINS = 1, 2
    """PYMEM_DOMAIN_MEM, PYMEM_DOMAIN_OBJ"""

    def __init__(self) -> None:
        self._address = _executable_page()
        self._count = ctypes.c_uint64.from_address(self._address)
        self._end = ctypes.sizeof(ctypes.c_uint64)
        for domain in self._DOMAINS:
            allocator = _Allocator()
            ctypes.pythonapi.PyMem_GetAllocator(domain, ctypes.byref(allocator))
            for name in ("malloc", "calloc", "realloc"):
                setattr(allocator, name, self._stub(getattr(allocator, name)))
            ctypes.pythonapi.PyMem_SetAllocator(domain, ctypes.byref(allocator))

    def __call__(self) -> int:
        """Return the number of allocations so far."""
        return int(self._count.value)

    def _stub(self, function: int) -> int:
        """Append a stub before a function; return its address."""
        target, begin = self._end, self._end + 8
        jump = begin + len(_INCREMENT) + 4
        self._end = jump + len(_JUMP) + 4
        code = struct.pack("<Q", function)
        code += _INCREMENT + struct.pack("<i", 0 - jump)
        code += _JUMP + struct.pack("<i", target - self._end)
        ctypes.memmove(self._address + target, code, len(code))
        return self._address + begin
