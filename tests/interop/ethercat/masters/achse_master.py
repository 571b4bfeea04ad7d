"""Our own master finds the slaves of a bus, brings them to Op and moves drives; JSON on stdout.

`achse_master.py INTERFACE MS CYCLES [SIGNED STEP]`: it scans, makes a configuration of what it
found and exchanges so many cycles of 2 ms. Drives are enabled and get a target that is STEP
increments further in each cycle, in csp.
"""

import json
import sys
import time
from typing import Any

from achse.codes import AlState
from achse.ethercat.master import BusConfiguration, BusSlave, Master
from achse.ethercat.master.scanning import scan_bus
from achse.station.buses.frame_link import BusLink, do_steps
from achse.station.clocks.priority import answer_promptly
from achse.transport.ethernet import EthernetLink

CYCLE_NS = 2_000_000
CSP = 8
CONTROL, MODE, TARGET, STATUS, ACTUAL = 0x6040, 0x6060, 0x607A, 0x6041, 0x6064
ENABLED = 0x27
MAX_TORQUE, FULL_TORQUE = 0x6072, 3000
NEXT = {0x40: 0x06, 0x60: 0x06, 0x21: 0x07, 0x23: 0x0F, ENABLED: 0x0F}


def move(slave: BusSlave, step: int) -> bool:
    """One cycle of a drive in csp; whether it is enabled."""
    status = slave.read_input(STATUS) & 0x6F
    if (MODE, 0) in slave.output_entries:
        slave.write_output(MODE, 0, CSP)
    if (MAX_TORQUE, 0) in slave.output_entries:
        slave.write_output(MAX_TORQUE, 0, FULL_TORQUE)
    slave.write_output(CONTROL, 0, NEXT.get(status, 0))
    actual = slave.read_input(ACTUAL, signed=True)
    target = slave.read_output(TARGET, signed=True) + step if status == ENABLED else actual
    slave.write_output(TARGET, 0, target)
    return status == ENABLED


def main() -> None:
    interface, _, cycles, *rest = sys.argv[1:]
    step = int(rest[0]) if rest else 0
    link = EthernetLink(interface)
    answer_promptly()
    slaves = do_steps(link, scan_bus())
    report: dict[str, Any] = {
        "count": len(slaves),
        "identity": [list(each.facts.identity[:2]) for each in slaves],
        "trouble": [each.trouble for each in slaves],
        "delays": [],
    }
    configured = tuple(each.configuration for each in slaves)
    master = Master(BusConfiguration(configured, cycle_ns=CYCLE_NS))
    bus = BusLink(master, link)
    master.request(AlState.OP)
    begin = time.monotonic_ns()
    number = operational = 0
    enabled: set[int] = set()
    first: dict[int, int] = {}
    while operational < int(cycles):
        number += 1
        wait = begin + number * CYCLE_NS - time.monotonic_ns()
        if wait > 0:
            time.sleep(wait / 1e9)
        else:
            begin -= wait
        bus.exchange(number * CYCLE_NS)
        operational += master.operational
        for slave in master.slaves:
            if slave.operational and (TARGET, 0) in slave.output_entries and move(slave, step):
                enabled.add(slave.position)
                first.setdefault(slave.position, slave.read_input(ACTUAL, signed=True))
    report["operational"] = operational
    report["states"] = [slave.state for slave in master.slaves]
    report["enabled"] = sorted(enabled)
    report["moved"] = [
        slave.read_input(ACTUAL, signed=True) - first[slave.position]
        for slave in master.slaves
        if slave.position in first
    ]
    report["delays"] = [slave.facts.delay_ns for slave in master.slaves]
    report["abnormal"] = [slave.abnormal_changes for slave in master.slaves]
    counters = master.cyclic.counters
    report["frames"] = [counters.sent, counters.lost, counters.late]
    report["round_trip_us"] = bus.round_trips.mean_ns / 1000
    report["events"] = [each.text for each in master.take_events()]
    master.request(AlState.INIT)
    for _ in range(100):
        number += 1
        time.sleep(0.002)
        bus.exchange(number * CYCLE_NS)
    link.close()
    print(json.dumps(report))


if __name__ == "__main__":
    main()
