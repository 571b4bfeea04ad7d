"""A project as machine code in the memory of a PLC, with its entries and callbacks."""

import ctypes
import gc
import weakref
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from achse.iec.elementary import RealType
from achse.native.backend import MachineCode, address_of
from achse.plc.code.faults import CATCHABLE, ExceptionCode, PlcFault, code_of
from achse.plc.code.source import variable_name
from achse.plc.code.storages import encoded_from
from achse.plc.machine.module import ModuleNotes
from achse.plc.machine.outside import decoded, encoded, maker_of, nodes_outside, reader_of
from achse.plc.machine.signatures import PartKind, RoutineSignature, SignaturePart, signature_of
from achse.plc.machine.support import AREA_WORDS, COUNT_WORDS, ENTRIES, FRAME_WORDS, INTERFACE
from achse.plc.memory import Area, Memory
from achse.st.typed.project import TypedProject


class MachineHost:
    """Interface of the PLC to its machine code."""

    def __init__(
        self,
        project: TypedProject,
        memory: Memory,
        *,
        budget: int,
        deepest: int,
        clock_ns: Callable[[], int],
        task_index: Callable[[], int],
        plain_function: Callable[[str], Callable[..., Any]],
        dispatched: Callable[[int, str], Callable[..., Any]],
        caught: Callable[[BaseException], None],
    ) -> None:
        self.project = project
        self.memory = memory
        self.budget = budget
        self.deepest = deepest
        """Calls inside each other."""
        self.clock_ns = clock_ns
        self.task_index = task_index
        self.plain_function = plain_function
        """The plain function of a routine, by key."""
        self.dispatched = dispatched
        """The plain function that a block has under a name; raises what a call of it raises."""
        self.caught = caught
        """Takes from the budget for what is caught; raises it again if there is none left."""


class _LoadedPrograms:
    """Programs in memory.

    Behind the few objects of a program are megabytes that Python does not count: areas, machine
    code, tables of LLVM. A replaced program is closed at once. Of whole stations that are dropped,
    40 programs would stay in memory without a search of our own.
    """

    def __init__(self) -> None:
        self._there: weakref.WeakSet[Any] = weakref.WeakSet()
        self._most = _MOST_UNSEARCHED

    def count(self, program: object) -> None:
        """Note that another program is about to be loaded: search first if many more are there than
        are in use, the young objects first, a tenth of the work."""
        if len(self._there) >= self._most:
            gc.collect(1)
            if len(self._there) > self._most - _MOST_UNSEARCHED // 2:
                gc.collect()
                self._most = len(self._there) + _MOST_UNSEARCHED
        self._there.add(program)

    def closed(self, program: object) -> None:
        """Note that a program is unloaded without a search."""
        self._there.discard(program)


_MOST_UNSEARCHED = 16
_PROGRAMS = _LoadedPrograms()


class MachineProgram:
    """Machine code of a project, loaded: `function` returns a routine as plain code has it."""

    def __init__(self, content: bytes, host: MachineHost, counters: int = 0) -> None:
        self._host = host
        self._routines = list(host.project.routines.values())
        self._exceptions: list[BaseException] = []
        self._callbacks: dict[int, Callable[[int], None]] = {}
        self._makers: dict[int, Callable[[int, bytes], bytes]] = {}
        self._readers: dict[int, Callable[[bytes], int]] = {}
        _PROGRAMS.count(self)
        counts = {COUNT_WORDS: counters} if counters else {}
        code = MachineCode(
            content,
            replace(INTERFACE, words={**INTERFACE.words, **counts}),
            {
                "call_plain": self._call_plain,
                "clock": host.clock_ns,
                "task_index": host.task_index,
                "caught": self._caught,
                "push_exception": self._push_exception,
                "reraise": self._reraise,
                "missing": self._missing,
                "make_text": self._make_text,
                "text_read": self._text_read,
            },
            deepest=host.deepest,
        )
        self._code = code
        self.notes = ModuleNotes.unpacked(code.notes)
        self.budget = code.budget_words
        """A view of one word: what is left of the budget."""
        self.frames = code.words(FRAME_WORDS)
        """A view of one word: bytes of frames in use."""
        self.counts = code.words(COUNT_WORDS) if counters else None
        """A view of the counters of statements and branches."""
        self._areas = code.words(AREA_WORDS)
        self._entries = code.table(ENTRIES, len(self.notes.entries))
        self._call = code.plain_function("call")
        self._call_with = code.plain_function("call_with")
        self._fault = code.fault_words
        self._is_open = False

    # memory ----------------------------------------------------------------------------------

    def renew(self) -> None:
        """See the areas as they are now."""
        for number, area in enumerate(Area, 1):
            data = self._host.memory[area].data
            size = len(data) & ~7
            self._areas[2 * number] = address_of(data) if size else 0
            self._areas[2 * number + 1] = size
        self._is_open = True

    def release(self) -> None:
        """Release the areas, which may move: nothing can run until `renew`."""
        self._is_open = False
        for number in range(len(self._areas)):
            self._areas[number] = 0

    def close(self) -> None:
        """Unload the program when the last of its functions is dropped; none runs any more.

        One that runs at this moment is left to Python's search.
        """
        self.release()
        if self._code.is_running:
            return
        self._code.close()
        _PROGRAMS.closed(self)

    # Python calls machine code ---------------------------------------------------------------

    @property
    def keys(self) -> Mapping[str, int]:
        """Routines that are machine code."""
        return self.notes.entries

    def function(self, key: str) -> Callable[..., Any]:
        """Return a routine, called as the plain function of it."""
        routine = self._host.project.routines[key]
        entry = self._entries[self.notes.entries[key]]
        signature = signature_of(routine)
        if not signature.is_simple:
            return self._with_block(entry, signature)
        plain, fault, frames = self._call, self._fault, self.frames
        if signature.has_instance:
            with_instance = self._call_with

            def run_on(this: int) -> None:
                if not self._is_open:
                    raise _closed()
                top = frames[0]
                with_instance(entry, this)
                if fault[0]:
                    self._recover(top, with_instance, entry, this)

            return run_on

        def run() -> None:
            if not self._is_open:
                raise _closed()
            top = frames[0]
            plain(entry)
            if fault[0]:
                self._recover(top, plain, entry)

        return run

    def _recover(self, top: int, call: Callable[..., None], *arguments: int) -> None:
        """Call again if another thread called before, else raise the exception of the fault."""
        self._code.again(call, *arguments)
        if not self._fault[0]:
            return
        self.frames[0] = top
        raise self._failure()

    def _failure(self) -> BaseException:
        """Return the exception of the fault that there is.

        No variable has it here: the frames are in its traceback, and would refer to it.
        """
        return self.notes.sites.failure(*self._code.caught(), self._routines, self._host.budget)

    def _with_block(self, entry: int, signature: RoutineSignature) -> Callable[..., Any]:
        names = [variable_name(part.name) for part in signature.inputs]
        words = len(signature.parameters)
        call, fault, frames = self._call_with, self._fault, self.frames

        def run(*values: Any, **named: Any) -> Any:
            if not self._is_open:
                raise _closed()
            block = (ctypes.c_int64 * (words + 1))()
            place = 0
            if signature.has_instance:
                block[0], values = values[0], values[1:]
                place = 1
            buffers: list[Any] = []
            arguments = [*values, *(named[name] for name in names[len(values) :])]
            for part, value in zip(signature.inputs, arguments, strict=True):
                place = _put(block, place, part, value, buffers)
            rooms: list[Any] = []
            result = signature.result
            if result is not None and result.kind is not PartKind.NUMBER:
                place = _put_room(block, place, result.room, rooms)
            for part in signature.outputs:
                place = _put_room(block, place, part.room, rooms)
                if part.kind is PartKind.TEXT:
                    place = _put_room(block, place, _WORD, rooms)
            top = frames[0]
            call(entry, ctypes.addressof(block))
            if fault[0]:
                self._recover(top, call, entry, ctypes.addressof(block))
            returned = None
            if result is not None:
                returned = _result(result, block[words], rooms)
            if not signature.outputs:
                return returned
            return (returned, *(_output(part, rooms) for part in signature.outputs))

        return run

    # machine code calls Python ---------------------------------------------------------------

    def _call_plain(self, number: int, address: int) -> None:
        callback = self._callbacks.get(number)
        if callback is None:
            callback = self._callbacks[number] = self._callback(number)
        callback(address)

    def _callback(self, number: int) -> Callable[[int], None]:
        like, key = self.notes.callbacks[number]
        routine = self._host.project.routines[like]
        signature = signature_of(routine, dispatched=like != key)
        function = self._host.plain_function(key)
        words = len(signature.parameters) + 1

        def callback(address: int) -> None:
            block = (ctypes.c_int64 * words).from_address(address)
            place = 0
            values: list[Any] = []
            if signature.has_instance:
                values.append(block[0] & (1 << 64) - 1)
                place = 1
            for part in signature.inputs:
                match part.kind:
                    case PartKind.NUMBER:
                        values.append(decoded(block[place], part.type))
                    case PartKind.TEXT:
                        values.append(ctypes.string_at(block[place], block[place + 1]))
                        place += 1
                    case PartKind.PACKED:
                        values.append(ctypes.string_at(block[place], part.room))
                place += 1
            answer = function(*values)
            outputs = answer[1:] if signature.outputs else ()
            result = answer[0] if signature.outputs else answer
            if signature.result is not None:
                if signature.result.kind is PartKind.NUMBER:
                    block[words - 1] = encoded(result, signature.result.type)
                else:
                    room = bytes(result)[: signature.result.room]
                    ctypes.memmove(block[place], room, len(room))
                    block[words - 1] = len(room)
                    place += 1
            for part, value in zip(signature.outputs, outputs, strict=True):
                place = _give(block, place, part, value)

        return callback

    def _caught(self) -> int:
        """Return the code of the exception that `__TRY` caught; raise one that it may not catch."""
        failure = self._failure()
        try:
            if not isinstance(failure, CATCHABLE):
                raise failure
            self._host.caught(failure)
            return code_of(failure)
        finally:
            del failure

    def _push_exception(self) -> None:
        self._exceptions.append(self._failure())

    def _reraise(self) -> None:
        raise self._exceptions.pop()

    def _missing(self, address: int, number: int) -> None:
        self._host.dispatched(address, self.notes.texts[number])
        raise PlcFault(ExceptionCode.UNKNOWN, "the block at an address has no such method")

    def _node(self, number: int) -> Any:
        routine, place = self.notes.outside[number]
        for at, node in enumerate(nodes_outside(self._routines[routine])):
            if at == place:
                return node
        raise AssertionError(f"no node {place} in {self._routines[routine].name}")

    def _make_text(self, number: int, bits: int, text: int, size: int, room: int) -> int:
        maker = self._makers.get(number)
        if maker is None:
            maker = self._makers[number] = maker_of(self._node(number))
        content = maker(bits, ctypes.string_at(text, size) if text else b"")
        ctypes.memmove(room, content, len(content))
        return len(content)

    def _text_read(self, number: int, text: int, size: int) -> int:
        reader = self._readers.get(number)
        if reader is None:
            reader = self._readers[number] = reader_of(self._node(number))
        return reader(ctypes.string_at(text, size))


_WORD = 8


def _closed() -> RuntimeError:
    return RuntimeError("the memory of the PLC is being placed again: nothing runs now")


# values in words -------------------------------------------------------------------------------


def _put(block: Any, place: int, part: SignaturePart, value: Any, buffers: list[Any]) -> int:
    """Return an argument into a block; the next place."""
    if part.kind is PartKind.NUMBER:
        block[place] = encoded(value, part.type)
        return place + 1
    value = bytes(value)[: part.room]
    if part.kind is PartKind.PACKED:
        value = value.ljust(part.room, b"\0")
    buffer = ctypes.create_string_buffer(value, max(len(value), 1))
    buffers.append(buffer)
    block[place] = ctypes.addressof(buffer)
    if part.kind is PartKind.PACKED:
        return place + 1
    block[place + 1] = len(value)
    return place + 2


def _put_room(block: Any, place: int, size: int, rooms: list[Any]) -> int:
    """Room for what comes back into a block; the next place."""
    room = ctypes.create_string_buffer(max(size, _WORD))
    rooms.append(room)
    block[place] = ctypes.addressof(room)
    return place + 1


def _result(part: SignaturePart, word: int, rooms: list[Any]) -> Any:
    match part.kind:
        case PartKind.NUMBER:
            return decoded(word, part.type)
        case PartKind.TEXT:
            return rooms.pop(0).raw[:word]
    return rooms.pop(0).raw[: part.room]


def _output(part: SignaturePart, rooms: list[Any]) -> Any:
    room = rooms.pop(0).raw
    if part.kind is PartKind.TEXT:
        return room[: int.from_bytes(rooms.pop(0).raw[:8], "little")]
    if isinstance(part.type, RealType):
        return part.type.codec.unpack(room[: part.type.size])[0]
    if part.kind is PartKind.NUMBER:
        return decoded(int.from_bytes(room[: part.type.size], "little"), part.type)
    return room[: part.room]


def _give(block: Any, place: int, part: SignaturePart, value: Any) -> int:
    """Return an output where the caller wants it; the next place."""
    is_number = part.kind is PartKind.NUMBER
    data = encoded_from(value, part.type) if is_number else bytes(value)[: part.room]
    ctypes.memmove(block[place], data, len(data))
    if part.kind is not PartKind.TEXT:
        return place + 1
    ctypes.c_int64.from_address(block[place + 1]).value = len(data)
    return place + 2
