"""Move an axis of the station in steps, as a bluesky scan does."""

import sys

import pyads
from ads_axis import NC_PORT, AdsAxis

host = sys.argv[1] if len(sys.argv) > 1 else "127.0.0.1"
with pyads.Connection(f"{host}.1.1", NC_PORT, host) as nc:
    x = AdsAxis(nc, 1, velocity=200.0, name="x")
    x.enable()
    for target in (0, 10, 20, 30):
        x.set(target).wait(timeout=30)
        print(f"{x.name} {x.position:5.1f} {x.egu}")
