"""AXFNC under random inputs and late answers, against a model of its rules (004 §3.1.1)."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from achse.ams import AmsAddress, Frame
from achse.codes import ReturnCode
from achse.station import Station
from achse.station.configuration.station_file import parse
from tests.libraries.tcnc.test_edges import ORDER

INPUTS = ("RESET", "CALIBR", "SETPOS", "SETDRIVE", "SETTARG", "MANFW", "MANBW")
PROGRAM = "PROGRAM MAIN VAR f : AXFNC := (AXID := 1, TMOUT := T#30MS); END_VAR f(); END_PROGRAM"
TIMEOUT_CALLS = 3


@dataclass
class Model:
    """What is sent, and what the outputs are, call by call."""

    levels: dict[str, bool] = field(default_factory=lambda: dict.fromkeys(INPUTS, False))
    busy_for: int = 0
    outputs: tuple[bool, bool, int] = (False, False, 0)

    def call(self, now: dict[str, bool], answers: bool, code: int) -> int | None:
        """The offset of the request that this call sends, None without one."""
        before, self.levels = self.levels, now
        if self.busy_for:
            self.busy_for -= 1
            if not self.busy_for:
                self.outputs = (False, self.coming != 0, self.coming)
            return None
        for name, rises, offset in ORDER:
            if now[name] is rises and before[name] is not rises:
                self.busy_for = 1 if answers else TIMEOUT_CALLS
                self.coming = code if answers else ReturnCode.CLIENT_TIMEOUT.number
                self.outputs = (True, False, 0)
                return offset
        return None

    coming: int = 0


STEP = st.tuples(
    st.fixed_dictionaries({name: st.booleans() for name in INPUTS}),
    st.booleans(),
    st.sampled_from([0, 0x4220, 0x4012]),
)


@settings(max_examples=10, deadline=None)
@given(st.lists(STEP, min_size=1, max_size=40))
def test_axfnc_against_its_model(tmp_path_factory: Any, steps: list[Any]) -> None:
    folder: Path = tmp_path_factory.mktemp("edges")
    (folder / "a.st").write_text(PROGRAM, encoding="utf-8")
    document = {"plc": [{"sources": "a.st", "code": "plain"}]}
    station = Station(parse(document, "a.toml"), base=folder)
    block: Any = station.plcs[851].instance("MAIN")["f"]
    model, sent = Model(), list[int]()
    answers, code = True, 0
    hand_on = station.router.deliver

    def deliver(frame: Frame) -> bool:
        """The NC of this test: it answers with the code of the step, or not at all."""
        if AmsAddress(frame.source).port != 851:
            return hand_on(frame)
        sent.append(int.from_bytes(frame.data[4:8], "little"))
        if not answers:
            return True
        result = code.to_bytes(4, "little")
        response = Frame(
            frame.source, frame.target, frame.command,
            flags=frame.flags | 1, invoke_id=frame.invoke_id, data=result,
        )  # fmt: skip
        return hand_on(response)

    station.router.deliver = deliver  # type: ignore[method-assign]
    for levels, answers, code in steps:
        for name, level in levels.items():
            block[name] = level
        expected = model.call(levels, answers, code)
        station.advance(0.01)
        assert station.plcs[851].failure == ""
        assert sent == ([] if expected is None else [expected])
        assert (block["BUSY"], block["ERR"], block["ERRID"]) == model.outputs
        sent.clear()
