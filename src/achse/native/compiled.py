"""A kernel in machine code, made once and kept in the user's cache; needs llvmlite.

Machine code belongs to the kernel's sources, the numbers they refer to, the layout of the records,
the processor and the version of LLVM: a hash of these names its file. A changed kernel is a new
file, a stale one is never used. ACHSE_CACHE_DIR moves the cache.
"""

import ctypes
import hashlib
import importlib.util
import os
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from enum import EnumMeta
from functools import cache, cached_property, partial
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

from achse.native import expressions, function, instructions, kinds, translate
from achse.native.declare import Layout

__all__ = ["Kernel", "cache_directory", "compiler_installed"]

_ARGUMENTS = {"ptr": ctypes.c_void_p, "i64": ctypes.c_int64, "double": ctypes.c_double}


_CHECK = hashlib.sha256().digest_size


def compiler_installed() -> bool:
    """Whether llvmlite can be imported, without importing it."""
    with suppress(ValueError):  # find_spec of a module that is None in sys.modules
        return importlib.util.find_spec("llvmlite") is not None
    return False


def cache_directory() -> Path:
    """Where machine code is kept."""
    named = os.environ.get("ACHSE_CACHE_DIR")
    if named:
        return Path(named)
    home = os.path.join(os.path.expanduser("~"), ".cache")
    return Path(os.environ.get("XDG_CACHE_HOME") or home) / "achse"


class Kernel:
    """A function on records, with all it calls: `plain` as it is, `function` as machine code.

    `layouts` are those of the record classes in its annotations. The machine code takes the
    function's parameters one by one; a sequence is two, its address and its length.
    """

    def __init__(
        self, name: str, entry: Callable[..., object], layouts: Mapping[type, Layout[Any]]
    ) -> None:
        assert isinstance(entry, FunctionType)
        self.name = name
        self.plain = entry
        self.layouts = layouts

    @cached_property
    def path(self) -> Path:
        """The file of the machine code in the cache, whether it is there or not."""
        return cache_directory() / f"{self.name}-{self._digest()}.o"

    @property
    def cached(self) -> bool:
        """Whether the machine code is there already, or must be compiled: about two seconds."""
        return self.path.exists()

    @cached_property
    def function(self) -> Callable[..., Any]:
        """The machine code, from the cache or compiled now."""
        code = self._kept()
        if code is None:
            code = self._compile()
            self._keep(code)
        parameters, result = translate.machine_signature(self.plain, self.layouts)
        prototype = ctypes.PYFUNCTYPE(
            _ARGUMENTS[result] if result else None, *(_ARGUMENTS[each] for each in parameters)
        )
        return prototype(_load(code))

    def bind(self, *arguments: float) -> Callable[..., Any]:
        """The machine code with its first arguments, which are converted once and for all."""
        function: Any = self.function
        kinds = function.argtypes[: len(arguments)]
        return partial(
            function, *(kind(given) for kind, given in zip(kinds, arguments, strict=True))
        )

    def _compile(self) -> bytes:
        import llvmlite.binding as llvm

        machine = _machine()
        module = llvm.parse_assembly(translate.translate(self.plain, self.layouts))
        module.triple = machine.triple
        module.data_layout = str(machine.target_data)
        module.verify()
        tuning = llvm.create_pipeline_tuning_options(speed_level=2)
        tuning.loop_unrolling = tuning.loop_vectorization = tuning.slp_vectorization = False
        builder = llvm.create_pass_builder(machine, tuning)
        builder.getModulePassManager().run(module, builder)
        code: bytes = machine.emit_object(module)
        return code

    def _kept(self) -> bytes | None:
        """The machine code from the cache; None if it is not there, or not as it was put there."""
        try:
            content = self.path.read_bytes()
        except OSError:
            return None
        check, code = content[:_CHECK], content[_CHECK:]
        return code if check == hashlib.sha256(code).digest() else None

    def _keep(self, code: bytes) -> None:
        """Put the machine code into the cache, after its hash."""
        with suppress(OSError):
            self.path.parent.mkdir(parents=True, exist_ok=True)
            handle, temporary = tempfile.mkstemp(dir=self.path.parent)
            try:
                with os.fdopen(handle, "wb") as file:
                    file.write(hashlib.sha256(code).digest() + code)
                os.replace(temporary, self.path)
            except OSError:
                os.unlink(temporary)

    def _digest(self) -> str:
        import llvmlite
        import llvmlite.binding as llvm

        digest = hashlib.sha256()
        processor = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
        digest.update(f"{llvmlite.__version__} {sys.platform} {processor}".encode())
        for layout in _layouts(self.layouts.values()):
            for name, slot in layout.fields.items():
                digest.update(f"{name} {slot.offset} {slot.length} {slot.is_real}".encode())
                if slot.refers is not None:
                    digest.update(slot.refers.name.encode())
        digest.update(self.plain.__qualname__.encode())
        files = {__file__, *(str(module.__file__) for module in _TRANSLATOR)}
        for name, thing in _reached(self.plain):
            if isinstance(thing, FunctionType):
                files.add(thing.__code__.co_filename)
            elif isinstance(thing, EnumMeta):
                digest.update(repr(list(thing)).encode())
            elif _is_number(thing):
                digest.update(f"{name} {thing!r}".encode())
        for file in sorted(files):
            digest.update(Path(file).read_bytes())
        return digest.hexdigest()[:20]


_TRANSLATOR = expressions, function, instructions, kinds, translate


def _layouts(layouts: Iterable[Layout[Any]]) -> Iterator[Layout[Any]]:
    """The layouts and those that their references lead to, each once."""
    known: set[Layout[Any]] = set()
    waiting = list(layouts)
    while waiting:
        layout = waiting.pop(0)
        if layout not in known:
            known.add(layout)
            yield layout
            waiting += [s.refers for s in layout.fields.values() if s.refers is not None]


def _reached(entry: FunctionType) -> Iterator[tuple[str, object]]:
    """The function and all that it and what it calls may refer to by name."""
    known = {entry}
    waiting = [entry]
    while waiting:
        caller = waiting.pop()
        yield caller.__name__, caller
        names = caller.__code__.co_names
        spaces = [caller.__globals__]
        spaces += (vars(spaces[0][name]) for name in names if _is_module(spaces[0].get(name)))
        for name in names:
            for thing in (space[name] for space in spaces if name in space):
                if not isinstance(thing, FunctionType):
                    yield name, thing
                elif thing not in known:
                    known.add(thing)
                    waiting.append(thing)


def _is_module(thing: object) -> bool:
    return isinstance(thing, ModuleType)


def _is_number(thing: object) -> bool:
    if isinstance(thing, tuple):
        return all(_is_number(part) for part in thing)
    return isinstance(thing, int | float)


@cache
def _machine() -> Any:
    """The processor we run on, as LLVM's target."""
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    for symbol, name in translate.externals():
        llvm.add_symbol(symbol, _address(name))
    return llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(),
        features=llvm.get_host_cpu_features().flatten(),
        opt=2,
        codemodel="jitdefault",
        jit=True,
    )


def _load(code: bytes) -> int:
    """Load machine code for good; the address of its entry."""
    import llvmlite.binding as llvm

    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _machine())
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    _LOADED.append(engine)
    address: int = engine.get_function_address(translate.ENTRY)
    return address


_LOADED: list[Any] = []
"""What keeps the machine code in memory."""


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
