"""Online changes, restarts and resets in any order keep what is documented, and harm no client."""

import struct
from copy import deepcopy
from random import Random
from typing import Any, cast

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import DeviceError
from achse.codes import ReturnCode
from achse.devices.plc import PlcDevice
from achse.iec import ArrayType, plain, resolved
from achse.iec.structs import StructType
from achse.native.backend import compiler_installed
from achse.plc.bodies import Bodies
from achse.plc.code.execution import CodeForm
from achse.plc.retention.retained_state import inherit_variables, retained_variables
from achse.plc.runtime import PlcRuntime, PlcState
from achse.plc.task import Task
from achse.st.check import check
from achse.st.declare import Declarations, declare
from achse.st.lexis.source import Source
from achse.st.syntax.parser import parse
from tests.rules.random_declarations import Path, Record, Scalar, State, edits, scalars

CODES = {"INT": "<h", "UINT": "<H", "DINT": "<i", "LINT": "<q", "LREAL": "<d", "BOOL": "<?"}


class Bench:
    """A model beside the PLC that it is of."""

    def __init__(self, rng: Random) -> None:
        self.rng = rng
        self.state = State()
        self.story: list[str] = []
        machine = compiler_installed() and rng.random() < 0.1
        self.form = CodeForm.MACHINE if machine else CodeForm.PLAIN
        self.edit(8)
        self.state.start()
        self.begin()

    def explain(self, what: str) -> str:
        return "\n".join([what, *self.story, self.state.text()])

    # the PLC -----------------------------------------------------------------------------

    def _read(self) -> tuple[Declarations, Bodies]:
        sources = self.state.sources().items()
        declared = declare([parse(Source(text, f"{n}.st"), name=n) for n, text in sources])
        typed = check(declared)
        assert not typed.faults, self.explain(f"{typed.faults}")
        return declared, Bodies(typed, form=self.form)

    def begin(self) -> None:
        """A new PLC."""
        declared, bodies = self._read()
        self.task = Task("PlcTask", 10_000_000, [declared.programs["main"]])
        self.plc = PlcRuntime([self.task], declared.units, bodies=bodies)
        self.device = PlcDevice(self.plc, clock=lambda: 0)

    def edit(self, most: int) -> None:
        """Other declarations, which nothing runs yet."""
        for _ in range(self.rng.randint(1, most)):
            work = self.rng.choice(edits(self.rng, self.state))
            self.story.append(f"(* {work.__name__} *)")
            work()

    def address(self, name: str, path: Path = ()) -> int:
        """Where a variable is now, or a part of it."""
        (placed,) = (one for one in self.plc.variables if one.name == name)
        type, offset = resolved(placed.variable.type), placed.offset
        for step in path:
            if isinstance(type, ArrayType):
                assert isinstance(step, int)
                offset += (step - type.dimensions[0].first) * type.strides[0]
                type = resolved(type.element)
            else:
                assert isinstance(type, StructType)
                member = type.member(str(step))
                type, offset = resolved(member.type), offset + member.offset
        return self.plc.memory.address(placed.area, offset)

    # what happens ------------------------------------------------------------------------

    def cycle(self) -> None:
        self.plc.run_due(self.task.due_ns)
        self.state.cycle()

    def write(self) -> None:
        """A client writes an elementary variable by a handle."""
        part = self._part(lambda name: name in CODES)
        if part is None:
            return
        name, _, path, type = part
        value: Any = self.rng.randint(0, 99)
        value = {"LREAL": value / 2, "BOOL": value > 50}.get(type, value)
        handle = self._handle(name, path)
        self.device.write(0xF005, handle, struct.pack(CODES[type], value))
        self._put(name, path, value)

    def _handle(self, name: str, path: Path) -> int:
        shown = name + "".join(f"[{s}]" if isinstance(s, int) else f".{s}" for s in path)
        answer = self.device.read_write(0xF003, 0, 4, shown.encode() + b"\0")
        handle: int = struct.unpack("<I", answer)[0]
        return handle

    def _part(self, wanted: Any) -> tuple[str, Any, Path, str] | None:
        parts = [
            (name, one, path, type)
            for name, one in self.state.variables()
            for path, type, _ in scalars(one.type, self.state.values[name])
            if wanted(type)
        ]
        return self.rng.choice(parts) if parts else None

    def _put(self, name: str, path: Path, value: Any) -> None:
        if not path:
            self.state.values[name] = value
            return
        types = dict(self.state.variables())
        at, type = self.state.values[name], cast("Any", types[name].type)
        for step in path[:-1]:
            at = at[step - type.first] if isinstance(step, int) else at[step]
            type = _inner(type, step)
        last = path[-1]
        at[last - type.first if isinstance(last, int) else last] = value

    def aim(self) -> None:
        """A pointer leads to a variable."""
        pointers = [
            (name, one.type.name) for name, one in self.state.variables()
            if isinstance(one.type, Scalar) and one.type.name.startswith("POINTER")
        ]  # fmt: skip
        if not pointers:
            return
        pointer, wanted = self.rng.choice(pointers)
        part = self._part(lambda type: wanted == f"POINTER TO {type}")
        if part is not None:
            name, _, path, _ = part
            unit, _, short = pointer.partition(".")
            self.plc.instance(unit)[short] = self.address(name, path)
            self.state.leads[pointer] = (name, path)

    def change(self) -> None:
        """An online change; handles of before are refused, and no others."""
        before = deepcopy(self.state)
        part = self._part(lambda type: True)
        handle = None if part is None else self._handle(part[0], part[2])
        self.edit(4)
        self.plc.instance("GVL_LOG")["sLog"] = ""
        declared, bodies = self._read()
        main = declared.programs["main"]
        units = [unit for unit in declared.units if unit is not main]
        self.plc.online_change(units, {"PlcTask": [main]}, bodies=bodies)
        life = self.state.change(before)
        self.story.append("(* online change *)")
        log = str(self.plc.instance("GVL_LOG")["sLog"]).split()
        assert log == life, self.explain(f"{log} expected {life}\n{before.text()}\nnow")
        if handle is not None:
            with pytest.raises(DeviceError) as refusal:
                self.device.read(0xF005, handle, 1)
            assert refusal.value.return_code is ReturnCode.SYMBOL_VERSION_INVALID

    def restart(self) -> None:
        """Another PLC, whose declarations may be others, with what was kept."""
        before = deepcopy(self.state)
        if self.rng.random() < 0.5:
            self.edit(3)
        retained = retained_variables(self.plc)
        self.begin()
        inherit_variables(self.plc, retained)
        self.state.inherit(before)
        self.story.append("(* restart *)")

    def reset(self) -> None:
        origin = self.rng.random() < 0.3
        before = deepcopy(self.state)
        self.plc.reset(origin=origin)
        self.plc.run()
        if origin:
            self.state.start()
        else:
            self.state.inherit(before)
        self.story.append(f"(* reset, origin {origin} *)")

    def agree(self) -> None:
        """All variables are what the model says."""
        assert self.plc.state is PlcState.RUN, self.explain(self.plc.failure)
        for name, one in self.state.variables():
            unit, _, short = name.partition(".")
            value = plain(self.plc.instance(unit)[short])
            if isinstance(one.type, Scalar) and one.type.name.startswith("POINTER"):
                lead = self.state.leads.get(name)
                wanted: Any = 0 if lead is None else self.address(*lead)
                assert value == wanted, self.explain(f"{name} is {value:X}, expected {lead}")
            else:
                wanted = self.state.values[name]
                assert value == wanted, self.explain(f"{name} is {value}, expected {wanted}")


def _inner(type: Any, step: object) -> Any:
    if isinstance(type, Record):
        return next(one.type for one in type.fields() if one.name == step)
    return type.element


@given(st.integers(0, (1 << 64) - 1), st.integers(1, 12))
@settings(max_examples=20)
def test_anything_in_any_order(seed: int, count: int) -> None:
    rng = Random(seed)
    bench = Bench(rng)
    bench.agree()
    for _ in range(count):
        work = rng.choice([bench.cycle, bench.cycle, bench.write, bench.write, bench.aim, bench.aim,
                           bench.change, bench.change, bench.change, bench.restart,
                           bench.reset])  # fmt: skip
        work()
        bench.agree()
