"""KickCAT brings loopback slaves to Op and exchanges data; JSON on stdout."""

import json
import sys
import time
from datetime import timedelta
from typing import Any

import kickcat

PATIENCE = timedelta(seconds=3600)


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
    serial = [
        bus.read_sdo(slave, 0x1018, 4, kickcat.Access.PARTIAL, 4, PATIENCE) for slave in slaves
    ]
    report["serial"] = [int.from_bytes(value, "little") for value in serial]
    bus.create_mapping()
    bus.request_state(kickcat.State.SAFE_OP)
    bus.wait_for_state(kickcat.State.SAFE_OP, PATIENCE)
    for slave in slaves:
        slave.set_output_bytes(b"good")
    bus.process_data()
    bus.request_state(kickcat.State.OPERATIONAL)
    bus.wait_for_state(kickcat.State.OPERATIONAL, PATIENCE, bus.process_data_no_check)
    report["op"] = [str(bus.get_state(slave)) for slave in slaves]
    echoes = 0
    for n in range(100):
        for slave in slaves:
            slave.set_output_bytes(n.to_bytes(4, "little"))
        bus.process_data()
        time.sleep(0.002)
        bus.process_data()
        echoes += all(bytes(slave.input_data)[:4] == n.to_bytes(4, "little") for slave in slaves)
    report["echoes"] = echoes
    print(json.dumps(report))


if __name__ == "__main__":
    main()
