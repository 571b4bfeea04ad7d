"""pysoem brings slaves made from ESI files to Op; JSON on stdout: states, sizes, an exchange."""

import json
import sys
import time
from typing import Any

import pysoem
from pysoem_bus import set_watchdog

PATIENT_MS = 6500.0


def main() -> None:
    interface, timeout = sys.argv[1:]
    pysoem.settings.timeouts.ret = 1000 * int(timeout)
    master = pysoem.Master()
    master.open(interface)
    report: dict[str, Any] = {"count": master.config_init()}
    try:
        report["names"] = [slave.name for slave in master.slaves]
        report["identity"] = [[slave.man, slave.id, slave.rev] for slave in master.slaves]
        report["map size"] = master.config_map()
        report["dc"] = master.config_dc()
        report["safeop"] = master.state_check(pysoem.SAFEOP_STATE, 5_000_000)
        for slave in master.slaves:
            set_watchdog(slave, PATIENT_MS)
        sent = [bytes((17 * n + 5) & 0xFF for n in range(len(s.output))) for s in master.slaves]
        master.state = pysoem.OP_STATE
        for cycle in range(400):
            for slave, data in zip(master.slaves, sent, strict=True):
                slave.output = data
            master.send_processdata()
            counter = master.receive_processdata(500_000)
            if cycle == 0:
                master.write_state()
            if cycle > 3 and master.state_check(pysoem.OP_STATE, 5_000) == pysoem.OP_STATE:
                break
            time.sleep(0.002)
        time.sleep(0.05)
        for _ in range(3):
            master.send_processdata()
            counter = master.receive_processdata(500_000)
            time.sleep(0.02)
        master.read_state()
        report["states"] = [slave.state for slave in master.slaves]
        report["codes"] = [slave.al_status for slave in master.slaves]
        report["sizes"] = [[len(slave.output), len(slave.input)] for slave in master.slaves]
        report["counter"] = [counter, master.expected_wkc]
        report["sent"] = [data.hex() for data in sent]
        report["inputs"] = [bytes(slave.input).hex() for slave in master.slaves]
        master.state = pysoem.INIT_STATE
        master.write_state()
    finally:
        master.close()
    print(json.dumps(report))


if __name__ == "__main__":
    main()
