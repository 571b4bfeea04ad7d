"""A PLC with axes, blocks of Tc2_MC2 by names, and what they show call by call."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from achse.ams import AmsAddress, Frame
from achse.motion import Axis
from achse.native.backend import compiler_installed
from achse.station import Station
from achse.station.configuration.station_file import parse
from tests.libraries.front_end import FrontEnd

__all__ = ["FORMS", "Bench"]

FORMS = ("plain", "machine") if compiler_installed() else ("plain",)

PROGRAM = """PROGRAM MAIN
VAR
    X, Y, Z, unlinked : AXIS_REF;
    bOn : BOOL := TRUE;
    power, powerY, powerZ : MC_Power;
    profile : MC_CAM_REF;
    points : ARRAY [0..4, 0..1] OF LREAL := [0, 0, 90, 30, 180, 50, 270, 30, 360, 0];
    trigger : TRIGGER_REF;
    parameters : ST_AxisParameterSet;
    components : ST_AxisComponents;
    homing : MC_HomingParameter;
    saw : MC_FlyingSawCharacValues;
    bCalls : BOOL := TRUE;
    {declared}
END_VAR
power(Axis := X, Enable := bOn, Enable_Positive := bOn, Enable_Negative := bOn);
powerY(Axis := Y, Enable := TRUE, Enable_Positive := TRUE, Enable_Negative := TRUE);
powerZ(Axis := Z, Enable := TRUE, Enable_Positive := TRUE, Enable_Negative := TRUE);
profile.pArray := ADR(points);
profile.ArraySize := SIZEOF(points);
profile.TableType := MC_TABLETYPE_NONEQUIDISTANT;
profile.NoOfRows := 5;
profile.NoOfColumns := 2;
IF bCalls THEN
{calls}
END_IF
END_PROGRAM
"""

SHORT = {
    "Done": "D", "InVelocity": "D", "InGear": "D", "InEndVelocity": "D", "InTorque": "D",
    "InSync": "D", "Busy": "B", "Active": "A", "CommandAborted": "C", "Error": "E",
}  # fmt: skip
"""Outputs as letters; Valid and Enabled of blocks with Enable are not among them."""

MASTER_AND_SLAVE = (
    *("MC_GearIn", "MC_GearInDyn", "MC_PhasingAbsolute", "MC_PhasingRelative", "MC_HaltPhasing"),
    *("MC_CamIn", "MC_CamIn_V2", "MC_CamAdd", "MC_CamExchange", "MC_GearInVelo", "MC_GearInPos"),
)
OF_THE_SLAVE = (
    *("MC_GearOut", "MC_CamOut", "MC_CamScaling", "MC_CamRemove"),
    "MC_ReadFlyingSawCharacteristics",
)
MORE = {
    "MC_TouchProbe": "TriggerInput := trigger",
    "MC_AbortTrigger": "TriggerInput := trigger",
    "MC_TouchProbe_V2": "TriggerInput := trigger",
    "MC_AbortTrigger_V2": "TriggerInput := trigger",
    "MC_StepAbsoluteSwitch": "Parameter := homing",
    "MC_FinishHoming": "Parameter := homing",
    "MC_ReadParameterSet": "Parameter := parameters",
    "MC_ReadAxisComponents": "AxisComponents := components",
    "MC_ReadFlyingSawCharacteristics": "CamTableCharac := saw",
}
NO_AXIS = ("MC_ReadCamTableSlaveDynamics", "MC_OverrideFilter", "MC_CalcDynamicsByRampTime")


def _call(name: str, type: str, axis: str) -> str:
    if "@" in type:
        return type.partition("@")[2].format(name=name)
    if type in NO_AXIS or type[:3] != "MC_":
        return f"{name}();"
    if type in MASTER_AND_SLAVE:
        return f"{name}(Master := X, Slave := {'unlinked' if axis == 'unlinked' else 'Y'});"
    if type == "MC_CamTableSelect":
        return f"{name}(Master := X, Slave := {axis}, CamTable := profile);"
    if type == "MC_GearInMultiMaster":
        slave = "unlinked" if axis == "unlinked" else "Y"
        return f"{name}(Master1 := X, Master2 := Z, Slave := {slave});"
    more = f", {MORE[type]}" if type in MORE else ""
    if type in OF_THE_SLAVE:
        return f"{name}(Slave := {'unlinked' if axis == 'unlinked' else 'Y'}{more});"
    return f"{name}(Axis := {axis}{more});"


class Bench:
    """A PLC with cycles of 10 ms over axes X (1), Y (7) and Z (9), all enabled.

    `blocks` are names and types, or `type @ call`; `at` says which axis those are called with that
    do not take X.
    """

    def __init__(
        self,
        folder: Path,
        form: str,
        axis: Mapping[str, Any],
        at: str = "X",
        **blocks: str,
    ) -> None:
        declared = " ".join(f"{name} : {type.partition('@')[0]};" for name, type in blocks.items())
        calls = "\n".join(_call(name, type, at) for name, type in blocks.items())
        text = PROGRAM.format(declared=declared, calls=calls)
        file = folder / "a.st"
        file.write_text(text, encoding="utf-8")
        document = {
            "plc": [{"sources": "a.st", "code": form}],
            "axis": [
                {"id": 1, "name": "X", **axis},
                {"id": 7, "name": "Y", **axis},
                {"id": 9, "name": "Z"},
            ],
        }
        with FrontEnd.of(text, file).shared():
            self.station = Station(parse(document, "a.toml"), base=folder)
        self.plc = self.station.plcs[851]
        self.main: Any = self.plc.instance("MAIN")
        self._outputs: dict[str, Mapping[str, str]] = {}
        """The outputs that blocks have, by the names of the blocks."""
        self.requests: list[Frame] = []
        """What went to ports 500 and 501."""
        self.call(5)
        assert self.main["power"]["Status"]
        self.station.router.put_watcher(self._watch)

    def _watch(self, frame: Frame) -> None:
        if not frame.flags & 1 and AmsAddress(frame.target).port in (500, 501):
            self.requests.append(frame)

    def call(self, count: int = 1) -> None:
        self.station.advance(count * 0.01)
        assert self.plc.failure == ""

    def set(self, name: str, **inputs: Any) -> None:
        for key, value in inputs.items():
            target = self.main[name]
            *parts, last = key.split("__")
            for part in parts:
                target = target[part]
            target[last] = value

    def input(self, name: str, key: str) -> Any:
        """Return an input as `set` names it."""
        value = self.main[name]
        for part in key.split("__"):
            value = value[part]
        return value

    def shown(self, name: str) -> str:
        block = self.main[name]
        outputs = self._outputs.get(name)
        if outputs is None:
            names = dir(block)
            outputs = {key: letter for key, letter in SHORT.items() if key in names}
            self._outputs[name] = outputs
        return "".join(letter for key, letter in outputs.items() if block[key])

    def outputs(self, name: str, count: int) -> list[str]:
        """The outputs in each of the next calls; what repeats itself is one."""
        seen: list[str] = []
        for _ in range(count):
            self.call()
            now = self.shown(name)
            if not seen or seen[-1] != now:
                seen.append(now)
        return seen

    def edge(self, name: str, count: int = 1, key: str = "Execute", **inputs: Any) -> list[str]:
        self.set(name, **inputs, **{key: True})
        return self.outputs(name, count)

    @property
    def axis(self) -> Axis:
        return self.axis_of(1)

    def axis_of(self, number: int) -> Axis:
        assert self.station.nc is not None
        return self.station.nc.axis(number)
