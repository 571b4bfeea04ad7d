"""The machine we run on: assembly in, an object file out, and back in as functions of Python.

Needs llvmlite, which is imported when it is used: where `object_file` loads what is in the cache,
that is only to compile.
"""

import ctypes
import importlib.util
import logging
import platform
import sys
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from enum import Enum
from functools import cache, lru_cache
from itertools import takewhile
from typing import Any

from achse.native.backend import object_file
from achse.native.backend.faults import (
    BUDGET,
    DEPTH,
    FAULT,
    NOTES,
    TRAIL,
    TRAIL_LENGTH,
    MachineFault,
    OwnFault,
)
from achse.native.backend.module import C_FUNCTIONS, C_PREFIX, ModuleBuilder, ModuleInterface
from achse.native.backend.stack_checks import MEASURE, MEASURING_STACK, STACK
from achse.native.backend.thread_stack import StackLimit, start_with_stack
from achse.native.backend.types import CallTarget, FunctionSignature

log = logging.getLogger("achse.native")

_PROCESSOR_FACTS = "vendor_id", "cpu family", "model", "stepping", "flags"

DEEPEST = 1000
"""Calls in one another, of functions that `descend`, if the stack does not end before."""


class Effort(Enum):
    """Effort of the compiler: LLVM's level."""

    FAST = 0
    """No passes, the quick selection of instructions: 20 µs for a statement."""
    FULL = 2
    """LLVM's O2, without loops unrolled or made vectors: floats stay as they are."""


def compiler_installed() -> bool:
    """Return True if llvmlite can be imported, without importing it, and its code be executed."""
    with suppress(ValueError):  # find_spec of a module that is None in sys.modules
        return importlib.util.find_spec("llvmlite") is not None and _may_execute()
    return False


@cache
def _may_execute() -> bool:
    """Return True if machine code may be executed; if not, it is logged once."""
    executable = object_file.memory_may_be_executed()
    if not executable:
        log.warning("this system refuses memory for machine code: all runs as plain Python")
    return executable


def identity() -> str:
    """Compiler and processor: machine code of one is not for another."""
    import llvmlite

    return f"{llvmlite.__version__} {_processor()}"


@cache
def _processor() -> str:
    """Return all that LLVM goes by when it compiles for the processor we run on."""
    if object_file.is_supported():
        with suppress(OSError), open("/proc/cpuinfo", encoding="utf-8") as file:
            first = takewhile(str.strip, file)
            facts = dict(line.split("\t", 1) for line in first if "\t" in line)
            if "flags" in facts:
                return " ".join(facts.get(name, "").strip("\t:\n ") for name in _PROCESSOR_FACTS)
    import llvmlite.binding as llvm

    return f"{llvm.get_host_cpu_name()} {llvm.get_host_cpu_features().flatten()}"


def compile_module(module: ModuleBuilder | str, effort: Effort = Effort.FULL) -> bytes:
    """Return the object file of a module, or of its assembly; it can be saved and loaded later."""
    import llvmlite.binding as llvm

    machine = _machine(effort)
    text = module if isinstance(module, str) else module.assembly()
    code = llvm.parse_assembly(text)
    code.triple = machine.triple
    code.data_layout = str(machine.target_data)
    code.verify()
    if effort is Effort.FULL:
        tuning = llvm.create_pipeline_tuning_options(speed_level=2)
        tuning.loop_unrolling = tuning.loop_vectorization = tuning.slp_vectorization = False
        builder = llvm.create_pass_builder(machine, tuning)
        builder.getModulePassManager().run(code, builder)
    content: bytes = machine.emit_object(code)
    return content


def address_of(buffer: bytearray | memoryview, offset: int = 0) -> int:
    """Return the address of a byte of a writable buffer, which must not be moved by growing."""
    return ctypes.addressof(ctypes.c_char.from_buffer(buffer, offset))


class _LoadedModule:
    """An object file in executable memory, and the callbacks whose addresses it has.

    Every function and every view of words refers to it: it is unloaded after the last of them.
    """

    def __init__(self, content: bytes) -> None:
        self.callbacks: list[Any] = []
        self.address_of: Callable[[str], int]
        """Gives the address of a function or of data by its name, 0 if there is none."""
        if object_file.is_supported():
            with suppress(object_file.ObjectFileError):
                self.address_of = object_file.ObjectFile(content, _outside).address_of
                return
        self._load(content)

    def _load(self, content: bytes) -> None:
        """Let LLVM load the file. Raises ExecutableMemoryError."""
        if not object_file.memory_may_be_executed():
            raise object_file.ExecutableMemoryError(
                "expected memory for machine code, this system refuses it"
            )
        import llvmlite.binding as llvm

        engine = llvm.create_mcjit_compiler(
            llvm.parse_assembly(""),
            _target_machine(Effort.FULL),  # the engine frees it: one each
            use_lmm=_lies_close_together(content) or None,
        )
        engine.add_object_file(llvm.ObjectFileRef.from_data(content))
        engine.finalize_object()
        self.address_of = lambda name: (
            engine.get_function_address(name) or engine.get_global_value_address(name)
        )


def _outside(name: str) -> int:
    """Return the address of a function that a module calls; 0 if it is unknown."""
    try:
        return _address(name.removeprefix(C_PREFIX))
    except AttributeError:
        return 0


class MachineCode:
    """An object file in memory, as long as anything refers to its functions or words.

    `callbacks` are the functions that it expects, `deepest` is how many calls of functions that
    `descend` may be in one another. Raises TypeError if a callback is missing or unknown.
    """

    def __init__(
        self,
        content: bytes,
        interface: ModuleInterface,
        callbacks: Mapping[str, Callable[..., Any]] | None = None,
        *,
        deepest: int = DEEPEST,
    ) -> None:
        self._interface = interface
        self._loaded = _LoadedModule(content)
        self._address_of = self._loaded.address_of
        self._raised: list[BaseException] = []
        self._fault = self._words(FAULT, 3)
        self._budget = self._words(BUDGET, 1)
        self._trail = self._words(TRAIL, TRAIL_LENGTH + 1)
        self._deepest = deepest
        self._depth = self._words(DEPTH, 1)
        if self._depth:
            self._depth[0] = deepest
            self._limit = StackLimit(self._words(STACK, 3))
            self._measure_frames()
        functions = dict(callbacks or {})
        if functions.keys() != interface.callbacks.keys():
            raise TypeError(
                f"callbacks {list(interface.callbacks)} expected, got {list(functions)}"
            )
        for name, signature in interface.callbacks.items():
            self._connect(name, signature, functions[name])

    @property
    def is_running(self) -> bool:
        """True while a function that descends has been called and has not returned."""
        return bool(self._depth) and self._depth[0] != self._deepest

    def close(self) -> None:
        """Give the callbacks back: nothing may call the code any more.

        It is unloaded then after the last function and view of words, without a search for
        garbage: callbacks and code refer to each other.
        """
        self._loaded.callbacks.clear()

    @property
    def notes(self) -> bytes:
        """Notes of the front end in the module."""
        place = self._address_of(NOTES[1:])
        if not place:
            return b""
        return ctypes.string_at(place + 8, ctypes.c_int64.from_address(place).value)

    @property
    def budget(self) -> int:
        """Budget that `spend` has left; below 0 once it was not enough. 0 in a module without."""
        return int(self._budget[0]) if self._budget else 0

    @budget.setter
    def budget(self, amount: int) -> None:
        if self._budget:
            self._budget[0] = amount

    def function(self, name: str) -> Callable[..., Any]:
        """Return an exported function. It raises MachineFault, or what a callback raised.

        Numbers are cut to the types of its parameters without a word. KeyError if there is none.
        """
        function = self._interface.functions[name]
        plain: Callable[..., Any] = self._prototype(function)
        if not function.faults:
            return plain
        fault = self._fault

        def call(*arguments: Any) -> Any:
            result = plain(*arguments)
            if fault[0]:
                result = self.again(plain, *arguments)
                if fault[0]:
                    raise self.caught()[0]
            return result

        return call

    def again(self, plain: Callable[..., Any], *arguments: Any) -> Any:
        """Call an exported function again, on the stack of the running thread, if it left because
        the limits were those of another one; any other fault stays.
        """
        number, here, _ = self._fault
        if number != OwnFault.OTHER_STACK:
            return None
        self._fault[0] = 0
        if self._depth[0] == self._deepest:
            self._limit.adopt(here)
            result = plain(*arguments)
        else:
            with self._limit.borrowed(here):
                result = plain(*arguments)
        if self._fault[0] == OwnFault.OTHER_STACK:
            self._fault[0] = OwnFault.TOO_DEEP
        return result

    def _measure_frames(self) -> None:
        """Find the sizes of large frames, on a stack that has room for them.

        Without memory for another thread, their bounds stay what is checked.
        """
        address = self._address_of(MEASURE[1:])
        if not address:
            return
        thread = threading.Thread(target=ctypes.PYFUNCTYPE(None)(address), name="achse frames")
        with suppress(RuntimeError, ValueError):
            start_with_stack(thread, MEASURING_STACK)
            thread.join()

    @property
    def budget_words(self) -> Any:
        """The budget as a view of one word, shared with the machine code."""
        return self._budget

    @property
    def fault_words(self) -> Any:
        """A view of the fault that there is: the first word is 0 if there is none."""
        return self._fault

    def words(self, name: str) -> Any:
        """Words of the module, as a view of integers; KeyError if it has none of that name."""
        return self._words(f'@"words.{name}"', self._interface.words[name])

    def table(self, name: str, length: int) -> list[int]:
        """Return the addresses of the functions of a table."""
        return list(self._words(f'@"table.{name}"', length))

    def caught(self) -> tuple[BaseException, list[int]]:
        """For a callback at a handler, or the host after a call: the fault that there is, and the
        places it came through, the innermost first. There is none any more then."""
        number, first, second = self._fault
        self._fault[0] = 0
        length = self._trail[0]
        self._trail[0] = 0
        places = list(self._trail[1 : length + 1])
        if number == OwnFault.CALLBACK_RAISED and self._raised:
            return self._raised.pop(), places
        return MachineFault(number, first, second), places

    def plain_function(self, name: str) -> Any:
        """Return an exported function that cannot fault, as ctypes has it: with `argtypes`."""
        return self._prototype(self._interface.functions[name])

    def _prototype(self, function: CallTarget) -> Any:
        address = self._address_of(function.symbol[1:].strip('"'))
        pointer = _prototype_of(function.signature.c_types)(address)
        pointer.loaded = self._loaded
        return pointer

    def _words(self, symbol: str, count: int) -> Any:
        """Return the words of a variable of the module, None if it has none."""
        place = self._address_of(symbol[1:].strip('"'))
        if not place:
            return None
        words = _words_of(count).from_address(place)
        words.loaded = self._loaded
        return memoryview(words).cast("B").cast("q")

    def _connect(
        self, name: str, signature: FunctionSignature, callback: Callable[..., Any]
    ) -> None:
        fault, raised = self._fault, self._raised

        def call(*arguments: Any) -> Any:
            try:
                return callback(*arguments)
            except BaseException as error:
                raised[:] = [error]
                fault[0] = OwnFault.CALLBACK_RAISED
                return 0

        pointer = _prototype_of(signature.c_types)(call)
        self._loaded.callbacks.append(pointer)
        place = self._address_of(f"callback.{name}")
        # `ctypes.cast` would let the pointer refer to itself
        address = ctypes.c_void_p.from_address(ctypes.addressof(pointer)).value
        ctypes.c_void_p.from_address(place).value = address


@lru_cache(64)
def _prototype_of(types: tuple[Any, ...]) -> Any:
    """Return the class of function pointers with this result and these parameters."""
    return ctypes.PYFUNCTYPE(*types)


@lru_cache(64)
def _words_of(count: int) -> Any:
    """Return the class of so many words at an address."""
    return ctypes.c_int64 * count


@cache
def _machine(effort: Effort) -> Any:
    """Return the target machine of the compiler."""
    return _target_machine(effort)


@cache
def _target() -> Any:
    """Return the processor we run on, as LLVM's target."""
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    llvm.initialize_native_asmparser()  # for `FunctionBuilder.increment`
    for name in C_FUNCTIONS:
        llvm.add_symbol(C_PREFIX + name, _address(name))
    return llvm.Target.from_default_triple()


def _target_machine(effort: Effort) -> Any:
    """Return the processor we run on, with how code for it is made."""
    import llvmlite.binding as llvm

    return _target().create_target_machine(
        cpu=llvm.get_host_cpu_name(),
        features=llvm.get_host_cpu_features().flatten(),
        opt=effort.value,
        jit=True,
        **_addressing(),
    )


def _addressing() -> dict[str, str]:
    """Return the addressing of constants and functions; LLVM's own choice is by addresses of 64
    bits.

    On x86-64 these are three instructions for each constant and call, a tenth of a kernel, and the
    quick selection of instructions leaves such calls to the slow one. Offsets do where all of an
    object file is close together; calls outside go by a table.
    """
    if sys.platform == "linux" and platform.machine() == "x86_64":
        return {"codemodel": "small", "reloc": "pic"}
    return {"codemodel": "jitdefault"}


def _lies_close_together(content: bytes) -> bool:
    """Return True if an object file reaches its own content by offsets."""
    import llvmlite.binding as llvm

    sections = llvm.ObjectFileRef.from_data(content).sections()
    return any(each.name() == b".text" and each.size() for each in sections)


@cache
def _c_library() -> ctypes.CDLL:
    if sys.platform == "win32":
        return ctypes.CDLL("ucrtbase")
    whole = ctypes.CDLL(None)  # Python's own math functions are in it
    return whole if hasattr(whole, "fmod") else ctypes.CDLL("libm.so.6")


def _address(name: str) -> int:
    address = ctypes.cast(getattr(_c_library(), name), ctypes.c_void_p).value
    assert address is not None
    return address
