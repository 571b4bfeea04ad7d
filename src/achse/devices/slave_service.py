"""The ADS service of slaves on a bus, AMS port 26000: their states, objects, channels, faults.

It is for people and scripts beside the EtherCAT master, which knows nothing of it. Texts are JSON,
so that any ADS client can use it by Read and ReadWrite.
"""

import json
from typing import Any

from achse.codes import SdoAbort
from achse.devices.channels import channels_group
from achse.devices.station import FaultList, faults_group
from achse.drive import Alarm, Drive, Mode
from achse.drive.objects import find
from achse.ethercat import Segment
from achse.ethercat.virtual import VirtualDevice
from achse.server import Device, RawGroup

STATES, OBJECTS = 0xFA05, 0xFA06
"""Index groups."""

_KNOWN_FIELDS = {"slave", "index", "subindex", "value"}


class SlaveService(Device):
    """States, objects, channels and faults of the slaves of a segment.

    An object is read and written as an SDO would, whatever the state of communication; what the
    master maps into its outputs is the master's.
    """

    def __init__(self, segment: Segment, faults: FaultList) -> None:
        self.segment = segment
        super().__init__(
            "achse slaves",
            (0, 1, 0),
            (
                faults_group(lambda offset: faults),
                RawGroup(
                    STATES,
                    "slaves",
                    read=lambda offset, length, client: _json(self.states()),
                    response="JSON: a table for each slave",
                    description="States; of drives values, alarm and warnings, too.",
                    source="achse",
                ),
                RawGroup(
                    OBJECTS,
                    "objects",
                    read_write=lambda offset, length, data, client: self._access(data),
                    request="JSON: slave (1 …), index, subindex (0), value to write it",
                    response="JSON: the value it has now, or the error",
                    description="Reads or writes an entry of a drive's dictionary.",
                    source="achse",
                ),
                channels_group(lambda: segment),
            ),
            clock=lambda: segment.time.now_ns,
        )

    def states(self) -> list[dict[str, Any]]:
        """Return the present state of each slave along the cable."""
        rows = []
        for number, slave in enumerate(self.segment.slaves, 1):
            row = {
                "slave": number,
                "name": _name(slave.application),
                "reachable": slave in self.segment.reachable,
                "state": slave.state.name,
                "al_status": slave.error.number,
            }
            if isinstance(slave.application, Drive):
                row |= _drive_state(slave.application)
            rows.append(row)
        return rows

    def _access(self, data: bytes) -> bytes:
        try:
            request = json.loads(data.rstrip(b"\0"))
            if not isinstance(request, dict) or request.keys() - _KNOWN_FIELDS:
                raise ValueError(f"expected {', '.join(sorted(_KNOWN_FIELDS))}; got {request!r}")
            slaves = self.segment.slaves
            number = int(request.get("slave", 1))
            if not 1 <= number <= len(slaves):
                raise ValueError(f"there are {len(slaves)} slaves, got {number}")
            drive = slaves[number - 1].application
            if not isinstance(drive, Drive):
                raise ValueError(f"expected the place of a drive, got slave {number}")
            index, subindex = int(request["index"]), int(request.get("subindex", 0))
            if "value" in request:
                row = find(index, subindex)
                value = request["value"]
                drive.set(index, float(value) if row.type.form == "<f" else int(value), subindex)
            return _json({"value": drive.get(index, subindex)})
        except SdoAbort as refusal:
            return _json({"error": f"0x{refusal.code.number:08X} {refusal.code.text}"})
        except (KeyError, TypeError, ValueError, OverflowError, RecursionError) as fault:
            return _json({"error": str(fault)})


def _name(application: object) -> str:
    """Return the type of a virtual device, or the kind of another slave."""
    return (
        application.name if isinstance(application, VirtualDevice) else type(application).__name__
    )


def _drive_state(drive: Drive) -> dict[str, Any]:
    """Return state, values, alarm and warnings of a drive."""
    record = drive.record
    alarm = Alarm.of(record.error_code)
    return {
        "power": drive.power_state.name,
        "mode": _mode(record.mode_display),
        "controlword": record.controlword,
        "statusword": record.statusword,
        "position": record.position_actual,
        "velocity": record.velocity_actual,
        "torque": record.torque_actual,
        "following_error": record.following_error,
        "error_code": record.error_code,
        "alarm": alarm.panel if alarm else "",
        "warnings": record.warnings_1 | record.warnings_2 << 32,
    }


def _mode(number: int) -> str:
    return Mode(number).name if number in list(Mode) else str(number)


def _json(document: Any) -> bytes:
    return json.dumps(document).encode()
