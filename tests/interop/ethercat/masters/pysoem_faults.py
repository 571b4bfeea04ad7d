"""pysoem keeps drives in Op while `achse fault add --served` lets things go wrong; JSON on stdout.

`pysoem_faults.py INTERFACE MS watch`: exchanges until stdin ends, and notes what changes.
"""

import sys
import threading
from typing import Any

import pysoem
from pysoem_bus import Bus, Report, run
from pysoem_drives import CSP, INPUTS, OUTPUTS


def ended() -> threading.Event:
    """Set once stdin is closed."""
    event = threading.Event()

    def wait() -> None:
        sys.stdin.read()
        event.set()

    threading.Thread(target=wait, daemon=True).start()
    return event


def watch(master: Any, report: Report) -> None:
    master.config_init()
    bus = Bus(master, OUTPUTS, INPUTS, cycle=0.002)
    master.config_map()
    master.state_check(pysoem.SAFEOP_STATE, 500_000)
    bus.put(0, CSP, 3000, 0, 0, 0)
    report["op"] = bus.go(pysoem.OP_STATE)
    bus.watchdog(0)  # the commands take their time
    print("in Op", file=sys.stderr, flush=True)
    counters: list[int] = []
    alarms: set[int] = set()
    end = ended()
    while not end.is_set():
        bus.counters.clear()
        inputs = bus.exchange(0, CSP, 3000, 0, 0, 0)
        counters += [counter for counter in bus.counters if counter not in counters]
        alarms.add(inputs[0][0])
    report["counters"] = counters
    report["alarms"] = sorted(alarms)
    master.read_state()
    report["state"] = [drive.state for drive in bus.drives]


if __name__ == "__main__":
    run({"watch": watch})
