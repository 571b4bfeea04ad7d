"""A session with a router, and what uses it.

`session` keeps a link alive, `requests` are under way on it. `raw` asks a device for bytes, `sums`
for many at once; `symbols` knows places and types, `hints` what was meant, `subscription` waits
for samples.
"""
