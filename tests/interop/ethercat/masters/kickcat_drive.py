"""KickCAT brings one drive to Op and enables it; JSON on stdout."""

import json
import struct
import sys
from datetime import timedelta
from typing import Any

import kickcat

OUTPUTS = struct.Struct("<HbHiHI")  # 1600h
INPUTS = struct.Struct("<HHbiHiiI")  # 1A00h
PATIENCE = timedelta(seconds=3600)


def main() -> None:
    interface, timeout = sys.argv[1:]
    link = kickcat.create_link(interface, "")
    link.set_timeout(timedelta(milliseconds=int(timeout)))
    bus = kickcat.Bus(link)
    report: dict[str, Any] = {}
    bus.init(timedelta(seconds=1))  # the watchdog
    [drive] = bus.slaves()
    bus.request_state(kickcat.State.PREOP)
    bus.wait_for_state(kickcat.State.PREOP, PATIENCE)
    report["1018h"] = [
        int.from_bytes(
            bus.read_sdo(drive, 0x1018, subindex, kickcat.Access.PARTIAL, 4, PATIENCE), "little"
        )
        for subindex in (1, 2)
    ]
    bus.create_mapping()
    report["inputs"] = len(drive.input_data)
    bus.request_state(kickcat.State.SAFE_OP)
    bus.wait_for_state(kickcat.State.SAFE_OP, PATIENCE)

    def cycle(controlword: int) -> int:
        drive.set_output_bytes(OUTPUTS.pack(controlword, 8, 3000, position, 0, 0))
        bus.process_data()
        status: int = INPUTS.unpack(bytes(drive.input_data))[1]
        return status

    bus.process_data()
    position = INPUTS.unpack(bytes(drive.input_data))[3]
    cycle(0)
    bus.request_state(kickcat.State.OPERATIONAL)
    bus.wait_for_state(kickcat.State.OPERATIONAL, PATIENCE, bus.process_data_no_check)
    report["op"] = str(bus.get_state(drive))
    report["states"] = []
    for controlword, wanted in ((6, 0x21), (7, 0x23), (15, 0x27)):
        for _ in range(500):
            status = cycle(controlword) & 0x6F
            if status == wanted:
                break
        report["states"].append(status)
    print(json.dumps(report))


if __name__ == "__main__":
    main()
