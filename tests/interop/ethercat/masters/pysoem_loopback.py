"""pysoem brings loopback slaves to Op, exchanges data, is silent, recovers; JSON on stdout."""

import json
import sys
import time
from collections.abc import Callable
from typing import Any

import pysoem
from pysoem_bus import DEFAULT, PATIENT, set_watchdog


def main() -> None:
    interface, timeout = sys.argv[1:]
    pysoem.settings.timeouts.ret = 1000 * int(timeout)
    report: dict[str, Any] = {}
    master = pysoem.Master()
    master.open(interface)
    try:
        run(master, report)
    finally:
        master.close()
    print(json.dumps(report, default=bytes.decode))


def exchange(master: Any) -> int:
    master.send_processdata()
    return int(master.receive_processdata(500_000))


def watchdog(master: Any, milliseconds: float) -> None:
    for slave in master.slaves:
        set_watchdog(slave, milliseconds)


def run(master: Any, report: dict[str, Any]) -> None:
    report["count"] = master.config_init()
    slaves = master.slaves
    report["names"] = [slave.name for slave in slaves]
    report["identity"] = [[slave.man, slave.id, slave.rev] for slave in slaves]
    report["serial"] = [int.from_bytes(slave.sdo_read(0x1018, 4), "little") for slave in slaves]
    first = slaves[0]
    report["name object"] = first.sdo_read(0x1008, 0).decode()
    long = bytes(range(256)) * 4
    first.sdo_write(0x2000, 0, long)
    report["long"] = first.sdo_read(0x2000, 0, 4096) == long
    first.sdo_write(0x2000, 0, b"short")
    report["short"] = first.sdo_read(0x2000, 0).decode()
    report["complete"] = first.sdo_read(0x1C12, 0, 64, True).hex()
    report["aborts"] = {}
    calls: dict[str, Callable[[], object]] = {
        "no object": lambda: first.sdo_read(0x5000, 0),
        "no subindex": lambda: first.sdo_read(0x1018, 9),
        "read-only": lambda: first.sdo_write(0x1018, 1, bytes(4)),
    }
    for name, call in calls.items():
        try:
            call()
        except pysoem.SdoError as error:
            report["aborts"][name] = hex(error.abort_code)
    dictionary = first.od
    report["dictionary"] = [[each.index, each.name, len(each.entries)] for each in dictionary]
    report["map size"] = master.config_map()
    report["dc"] = master.config_dc()
    first.dc_sync(True, 1_000_000)
    report["safeop"] = master.state_check(pysoem.SAFEOP_STATE, 5_000_000)
    watchdog(master, PATIENT)
    exchange(master)
    master.state = pysoem.OP_STATE
    master.write_state()
    report["op"] = master.state_check(pysoem.OP_STATE, 5_000_000)
    report["expected"] = master.expected_wkc
    counters = set()
    echoes = 0
    for n in range(1000):
        for slave in slaves:
            slave.output = n.to_bytes(4, "little")
        counters.add(exchange(master))
        time.sleep(0.001)
        echoes += slaves[-1].input == n.to_bytes(4, "little") or slaves[-1].input == max(
            n - 1, 0
        ).to_bytes(4, "little")
    report["counters"] = sorted(counters)
    report["echoes"] = echoes
    watchdog(master, DEFAULT)
    time.sleep(0.15)
    master.read_state()
    report["silent"] = [[slave.state, slave.al_status] for slave in slaves]
    watchdog(master, PATIENT)
    exchange(master)
    master.state = pysoem.SAFEOP_STATE | pysoem.STATE_ACK
    master.write_state()
    report["acknowledged"] = master.state_check(pysoem.SAFEOP_STATE, 5_000_000)
    exchange(master)
    master.state = pysoem.OP_STATE
    master.write_state()
    report["recovered"] = master.state_check(pysoem.OP_STATE, 5_000_000)
    master.state = pysoem.INIT_STATE
    master.write_state()
    report["init"] = master.state_check(pysoem.INIT_STATE, 5_000_000)


if __name__ == "__main__":
    main()
