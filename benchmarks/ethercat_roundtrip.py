"""Round trip of a cyclic frame over a veth pair: slaves beside a bare reflector of frames.

A master on one end sends one LRW for all slaves and waits for it; on the other end is a process
with the slaves, or one that sends each frame back as it came. Runs in a network namespace of its
own (root or user namespaces, Linux). Usage: python benchmarks/ethercat_roundtrip.py [SECONDS]
"""

import os
import socket
import statistics
import subprocess
import sys
import time
from collections.abc import Callable

import ethercat_segment

from achse.ethercat import Loopback
from achse.station.fieldbus import serve_segment
from achse.transport.ethernet import EthernetLink

ENDS = ("cable0", "cable1")
CABLE = (
    f"ip link add {ENDS[0]} type veth peer name {ENDS[1]}"
    f" && ip link set {ENDS[0]} up && ip link set {ENDS[1]} up"
)
COUNTS = (1, 8, 32)
LATE_S = 0.001


def forever() -> bool:
    return True


def reflect() -> None:
    link = EthernetLink(ENDS[1])
    while True:
        link.exchange(lambda frame: frame, 1.0)


def slaves(count: int) -> Callable[[], None]:
    def serve() -> None:
        segment = ethercat_segment.in_op([Loopback(16) for _ in range(count)], dc=False)
        serve_segment(segment, EthernetLink(ENDS[1]), forever)

    return serve


def round_trips(frame: bytes, seconds: float) -> list[float]:
    """Microseconds of each round trip, one a millisecond."""
    found = []
    with socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(0x88A4)) as master:
        master.bind((ENDS[0], 0x88A4))
        master.settimeout(1.0)
        end = time.perf_counter() + seconds
        while time.perf_counter() < end:
            begin = time.perf_counter_ns()
            master.send(frame)
            while len(master.recv(2048)) != len(frame):
                pass
            found.append((time.perf_counter_ns() - begin) / 1000.0)
            time.sleep(0.001)
    return sorted(found)


def against(other_end: Callable[[], None], frame: bytes, seconds: float) -> list[float]:
    """Round trips with `other_end` in a process of its own."""
    child = os.fork()
    if child == 0:
        other_end()
    try:
        time.sleep(0.5)
        return round_trips(frame, seconds)
    finally:
        os.kill(child, 9)
        os.waitpid(child, 0)


def measure(seconds: float) -> None:
    print(f"{'slaves':>6} {'reflector p50 µs':>17} {'slaves p50 µs':>14} {'99.9 %':>8}", end="")
    print(f" {'ratio':>6} {'late':>7}")
    for count in COUNTS:
        segment = ethercat_segment.in_op([Loopback(16) for _ in range(count)], dc=False)
        (frame,) = ethercat_segment.cyclic_frames(segment, dc=False)
        bare = statistics.median(against(reflect, frame, seconds))
        trips = against(slaves(count), frame, seconds)
        median = statistics.median(trips)
        late = sum(trip > 1e6 * LATE_S for trip in trips) / len(trips)
        print(
            f"{count:>6} {bare:>17.1f} {median:>14.1f} {trips[int(0.999 * len(trips))]:>8.1f}",
            end="",
        )
        print(f" {median / bare:>6.2f} {100 * late:>6.2f}%")


def main() -> None:
    seconds = sys.argv[1] if len(sys.argv) > 1 else "5"
    if os.environ.get("ACHSE_IN_NAMESPACE"):
        measure(float(seconds))
        return
    user = [] if os.geteuid() == 0 else ["--map-root-user"]
    inner = ["sh", "-c", f'{CABLE} && exec "$@"', "sh", sys.executable, __file__, seconds]
    environment = {**os.environ, "ACHSE_IN_NAMESPACE": "1"}
    sys.exit(subprocess.call(["unshare", *user, "--net", *inner], env=environment))


if __name__ == "__main__":
    main()
