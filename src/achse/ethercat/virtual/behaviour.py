"""Behaviours: what a virtual slave does with its outputs and inputs in each local cycle.

Source: ETG.1000.6, the device behind its controller.
"""

import csv
from bisect import bisect_right
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

from achse.codes import AlState
from achse.ethercat.virtual.channels import Value

if TYPE_CHECKING:
    from achse.ethercat.virtual.device import VirtualDevice

_MOST_ROWS = 1_000_000


class SlaveBehaviour:
    """Base of behaviours: a class of one's own overrides what it needs."""

    cycle_ns = 1_000_000
    """Time between two steps without SYNC0, ns."""

    def start(self, device: "VirtualDevice") -> None:
        """Start; called once, when the device is made."""

    def step(self, device: "VirtualDevice", elapsed_ns: int) -> None:
        """Do one local cycle; called in every state; time passed since the last one."""

    def enter(self, device: "VirtualDevice", state: AlState) -> None:
        """Prepare for a state; called before the device enters it."""

    def write(self, device: "VirtualDevice", index: int, subindex: int, data: bytes) -> None:
        """Check an entry; called before an SDO writes it. Raise `SdoAbort` to refuse it."""

    def begin_file(self, device: "VirtualDevice", name: str, password: int) -> None:
        """Check a file; called before FoE writes it. Raise `FileRefusal` to refuse it."""

    def frame(self, device: "VirtualDevice", frame: bytes) -> None:
        """Process an Ethernet frame that came by EoE; `device.send_frame` sends one."""

    def vendor_message(self, device: "VirtualDevice", data: bytes) -> Iterable[bytes]:
        """Called for each message that comes by VoE, vendor id and type first; its answers."""
        return ()


class LoopBack(SlaveBehaviour):
    """Outputs come back as inputs: the first bit as the first, as many as there are."""

    def step(self, device: "VirtualDevice", elapsed_ns: int) -> None:
        """Copy the bits."""
        device.write_all_inputs(device.all_outputs())


class RecordedSignals(SlaveBehaviour):
    """Inputs as a recording has them: columns by channel, a row for each moment.

    Between rows the last one counts. With `repeat` the recording begins again after its last row.
    """

    def __init__(
        self,
        times_ns: Sequence[int],
        columns: Mapping[str, Sequence[Value]],
        *,
        repeat: bool = False,
    ) -> None:
        """ValueError for times that go back, and for columns of another length."""
        if not times_ns or any(one > other for one, other in pairwise(times_ns)):
            raise ValueError("a recording needs rows whose times do not go back")
        for name, values in columns.items():
            if len(values) != len(times_ns):
                raise ValueError(f"{name}: expected {len(times_ns)} values, got {len(values)}")
        self._times = times_ns
        self._columns = columns
        self._repeat = repeat
        self._now_ns = 0
        self._row = -1

    @classmethod
    def from_csv(cls, lines: Iterable[str], *, repeat: bool = False) -> "RecordedSignals":
        """Return a recording in CSV: `time` in s first, then a column for each channel;
        ValueError."""
        rows = csv.reader(lines)
        head = [each.strip() for each in next(rows, [])]
        if len(head) < 2 or head[0].lower() not in ("time", "t", "time_s"):
            raise ValueError("expected a first line with `time` and the names of channels")
        times: list[int] = []
        columns: dict[str, list[Value]] = {name: [] for name in head[1:]}
        for place, row in enumerate(rows, 2):
            if not any(row):
                continue
            if len(row) != len(head) or place > _MOST_ROWS:
                raise ValueError(f"line {place}: expected {len(head)} values, got {len(row)}")
            try:
                numbers = [float(each) for each in row]
                times.append(round(numbers[0] * 1e9))
            except (ValueError, OverflowError):
                raise ValueError(f"line {place}: expected numbers, got {','.join(row)!r}") from None
            for name, number in zip(head[1:], numbers[1:], strict=True):
                columns[name].append(int(number) if number.is_integer() else number)
        return cls(times, columns, repeat=repeat)

    def start(self, device: "VirtualDevice") -> None:
        """Check the names and set the first row; KeyError, ValueError."""
        for name, values in self._columns.items():
            channel = device.channel(name)
            if channel.output:
                raise ValueError(f"{name} is an output; a recording sets inputs")
            device.set_input(name, values[0])

    def step(self, device: "VirtualDevice", elapsed_ns: int) -> None:
        """Set the inputs of the row that counts now."""
        self._now_ns += elapsed_ns
        now = self._now_ns
        last = self._times[-1]
        if self._repeat and last > 0:
            now %= last
        row = bisect_right(self._times, now) - 1
        if row == self._row or row < 0:
            return
        self._row = row
        for name, values in self._columns.items():
            device.set_input(name, values[row])
