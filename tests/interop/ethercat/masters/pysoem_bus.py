"""What the pysoem masters of these tests share: cyclic exchange, states, a scenario by name."""

import json
import struct
import sys
import time
from collections.abc import Callable, Mapping
from typing import Any

import pysoem

Report = dict[str, Any]
Scenario = Callable[[Any, Report], None]

READY, SWITCHED_ON, ENABLED, DISABLED, FAULT = 0x21, 0x23, 0x27, 0x40, 0x08
STATE, FAULT_STATE = 0x6F, 0x4F

PATIENT, DEFAULT = 6500.0, 100.0
"""Process data watchdogs, ms: this master may have to wait for its processor, and as it is."""


TRIES = 100
"""How often a telegram goes that pysoem waits 2 ms for, whatever is set: others run here too."""

PATIENCE_US = 1_000_000
"""How long a telegram may take where pysoem asks, in µs."""


class Bus:
    """A master whose drives all get the same outputs; `outputs` and `inputs` are their layouts.

    A cycle lasts `cycle` seconds.
    """

    def __init__(
        self, master: Any, outputs: struct.Struct, inputs: struct.Struct, cycle: float = 0.004
    ) -> None:
        self.master = master
        self.cycle = cycle
        self.counters: set[int] = set()
        self._outputs = outputs
        self._inputs = inputs
        self._next = time.monotonic()

    @property
    def drives(self) -> list[Any]:
        return self.master.slaves  # type: ignore[no-any-return]

    def put(self, *outputs: int) -> None:
        data = self._outputs.pack(*outputs)
        for drive in self.drives:
            drive.output = data

    def send(self) -> None:
        """One frame there and back, at once."""
        self.master.send_processdata()
        self.counters.add(self.master.receive_processdata(500_000))

    def watchdog(self, milliseconds: float) -> None:
        for drive in self.drives:
            set_watchdog(drive, milliseconds)

    def inputs(self) -> list[tuple[int, ...]]:
        """Of each drive."""
        return [self._inputs.unpack(drive.input) for drive in self.drives]

    def exchange(self, *outputs: int) -> list[tuple[int, ...]]:
        """One cycle: the inputs of every drive."""
        self.put(*outputs)
        self.send()
        now = time.monotonic()
        self._next = max(self._next + self.cycle, now)
        time.sleep(self._next - now)
        return self.inputs()

    def go(self, state: int) -> int:
        """Ask for a state; the one reached. Outputs must have come before Op."""
        self.watchdog(PATIENT)
        self.send()
        self.master.state = state
        self.master.write_state()
        for _ in range(100):
            self.send()
            reached: int = self.master.state_check(state & 0xF, 5_000)
            if reached == state & 0xF:
                break
        return reached


def set_watchdog(drive: Any, milliseconds: float) -> None:
    """Ask until an answer comes in time."""
    for left in reversed(range(TRIES)):
        try:
            drive.set_watchdog("processdata", milliseconds)
        except pysoem.WkcError:
            if not left:
                raise
        else:
            return


def number(drive: Any, index: int, subindex: int = 0, *, signed: bool = False) -> int:
    return int.from_bytes(drive.sdo_read(index, subindex), "little", signed=signed)


def abort_of(call: Callable[[], object]) -> str:
    """The abort code a call is refused with."""
    try:
        call()
    except pysoem.SdoError as error:
        return hex(error.abort_code)
    return "done"


def run(scenarios: Mapping[str, Scenario]) -> None:
    """`SCRIPT INTERFACE MS WHAT`: play a scenario, write what it found as JSON to stdout.

    MS is how long a reply may take.
    """
    interface, timeout, what = sys.argv[1:4]
    pysoem.settings.timeouts.ret = 1000 * int(timeout)
    report: Report = {}
    master = pysoem.Master()
    master.open(interface)
    try:
        scenarios[what](master, report)
        master.state = pysoem.INIT_STATE
        master.write_state()
    finally:
        master.close()
    print(json.dumps(report, default=bytes.decode))
