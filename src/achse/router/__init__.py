"""The message router: which endpoint a frame's target address means."""

from achse.router.router import FIRST_CLIENT_PORT, LOOPBACK_NET_ID, FrameFilter, Router, Watcher

__all__ = ["FIRST_CLIENT_PORT", "LOOPBACK_NET_ID", "FrameFilter", "Router", "Watcher"]
