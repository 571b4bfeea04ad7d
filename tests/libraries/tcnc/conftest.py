"""A PLC with blocks of TcNC over three axes, and what its blocks ask the NC for."""

from pathlib import Path
from typing import Any

import pytest

from achse.ams import AmsAddress, Command, Frame
from achse.native.backend import compiler_installed
from achse.plc import PlcRuntime
from achse.station import Station
from achse.station.configuration.station_file import parse
from tests.libraries.front_end import FrontEnd

FORMS = ("plain", "machine") if compiler_installed() else ("plain",)

CYCLE_S = 0.01

_AXES = (1, 2, 3)

_PROGRAM = """PROGRAM MAIN
VAR
    {axes}
    {declared}
END_VAR
{enables}
{calls}
END_PROGRAM
"""

_STRUCTURES = """
    fromNc{n} AT %I* : NCTOPLC_AXLESTRUCT;
    toNc{n} AT %Q* : PLCTONC_AXLESTRUCT := (nDeCtrlDWord := 7, nOverride := 1000000);
"""


class Bench:
    """Blocks by their names, called each 10 ms; `set` gives inputs, `call` runs cycles.

    `last` is the variable of the last axis, if that is to be another one.
    """

    def __init__(
        self,
        folder: Path,
        form: str,
        blocks: dict[str, str],
        *,
        variables: str = "",
        calls: str = "",
        axis: dict[str, Any],
        last: str = "",
        **document: Any,
    ) -> None:
        text = _PROGRAM.format(
            axes="".join(_STRUCTURES.format(n=n) for n in _AXES),
            declared=variables + " ".join(f"{name} : {type};" for name, type in blocks.items()),
            enables="",
            calls=calls + "\n".join(f"{name}();" for name in blocks),
        )
        (folder / "a.st").write_text(text, encoding="utf-8")
        axes = [
            {"id": n, "name": f"A{n}", "plc": [f"MAIN.fromNc{n}", f"MAIN.toNc{n}"]} | axis
            for n in _AXES
        ]
        if last:
            axes[-1]["plc"] = last
        table = {"plc": [{"sources": "a.st", "code": form}], "axis": axes, **document}
        with FrontEnd.of(text, folder / "a.st").shared():
            self.station = Station(parse(table, "a.toml"), base=folder)
        self.plc: PlcRuntime = self.station.plcs[851]
        self.main: Any = self.plc.instance("MAIN")
        self.requested_frames: list[Frame] = []
        """Requests of the PLC since they were last looked at."""
        deliver = self.station.router.deliver

        def watched(frame: Frame) -> bool:
            if AmsAddress(frame.source).port == 851 and not frame.flags & 1:
                self.requested_frames.append(frame)
            return deliver(frame)

        self.station.router.deliver = watched  # type: ignore[method-assign]
        self.call(5)

    def call(self, count: int = 1) -> None:
        self.station.advance(count * CYCLE_S)
        assert self.plc.failure == ""

    def set(self, name: str, **inputs: Any) -> None:
        for key, value in inputs.items():
            self.main[name][key] = value

    def shown(self, name: str) -> tuple[bool, bool, int]:
        """BUSY, ERR, ERRID of an edge block."""
        block = self.main[name]
        return block["BUSY"], block["ERR"], block["ERRID"]

    def requests(self) -> list[tuple[int, int, int, bytes]]:
        """Port, group, offset and data of the writes since the last look."""
        requests = []
        for frame in self.requested_frames:
            assert frame.command == Command.WRITE
            group, offset, size = (
                int.from_bytes(frame.data[n : n + 4], "little") for n in (0, 4, 8)
            )
            assert size == len(frame.data) - 12
            requests.append((AmsAddress(frame.target).port, group, offset, bytes(frame.data[12:])))
        self.requested_frames.clear()
        return requests

    def axis(self, number: int = 1) -> Any:
        assert self.station.nc is not None
        return self.station.nc.axis(number)


@pytest.fixture(params=FORMS)
def bench(request: pytest.FixtureRequest, tmp_path: Path) -> Any:
    """`bench(block="AXACT", axis={…})`."""

    def make(axis: dict[str, Any] | None = None, **blocks: Any) -> Bench:
        options = {
            key: blocks.pop(key) for key in ("variables", "calls", "table", "last") if key in blocks
        }
        return Bench(tmp_path, request.param, blocks, axis=axis or {}, **options)

    return make
