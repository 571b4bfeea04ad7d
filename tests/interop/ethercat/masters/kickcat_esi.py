"""KickCAT brings slaves made from ESI files to Op; JSON on stdout."""

import json
import sys
import time
from datetime import timedelta
from typing import Any

import kickcat

PATIENCE = timedelta(seconds=20)


def main() -> None:
    interface, timeout = sys.argv[1:]
    link = kickcat.create_link(interface, "")
    link.set_timeout(timedelta(milliseconds=int(timeout)))
    bus = kickcat.Bus(link)
    report: dict[str, Any] = {}
    bus.init(timedelta(seconds=1))  # the watchdog
    slaves = bus.slaves()
    report["count"] = len(slaves)
    bus.request_state(kickcat.State.PREOP)
    bus.wait_for_state(kickcat.State.PREOP, PATIENCE)
    bus.create_mapping()
    bus.request_state(kickcat.State.SAFE_OP)
    bus.wait_for_state(kickcat.State.SAFE_OP, PATIENCE)
    bus.process_data()
    bus.request_state(kickcat.State.OPERATIONAL)
    bus.wait_for_state(kickcat.State.OPERATIONAL, PATIENCE, bus.process_data_no_check)
    report["op"] = [str(bus.get_state(slave)) for slave in slaves]
    for _ in range(3):
        bus.process_data()
        time.sleep(0.01)
    report["inputs"] = [bytes(slave.input_data).hex() for slave in slaves]
    print(json.dumps(report))


if __name__ == "__main__":
    main()
