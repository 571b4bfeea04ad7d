"""What passes an interface, EtherCAT only, as a capture file: `recorder.py INTERFACE FILE`."""

import contextlib
import signal
import socket
import struct
import sys
import time

ETH_P_ALL, ETHERCAT = 0x0003, b"\x88\xa4"
SO_RCVBUFFORCE = 33
BUFFER = 64 << 20
HEAD = struct.pack("<IHHiIII", 0xA1B23C4D, 2, 4, 0, 0, 0x40000, 1)  # times in ns


def main() -> None:
    interface, path = sys.argv[1:]
    running = True

    def stop(*_: object) -> None:
        nonlocal running
        running = False

    signal.signal(signal.SIGTERM, stop)
    with (
        socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ETH_P_ALL)) as wire,
        open(path, "wb") as capture,
    ):
        with contextlib.suppress(PermissionError):
            wire.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, BUFFER)
        wire.bind((interface, ETH_P_ALL))
        wire.settimeout(0.05)
        capture.write(HEAD)
        print("ready", flush=True)
        while True:
            try:
                frame = wire.recv(2048)
            except TimeoutError:
                if running:
                    continue
                break
            if frame[12:14] == ETHERCAT:
                times = divmod(time.time_ns(), 10**9)
                capture.write(struct.pack("<IIII", *times, len(frame), len(frame)) + frame)


if __name__ == "__main__":
    main()
