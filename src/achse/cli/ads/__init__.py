"""Commands that talk to any ADS device: `achse ads` and `achse symbols`.

Read `ads` first: state, values by name, subscriptions. `raw` goes by index group and offset,
`route` and `scan` are about routers, `stats` about stations of achse. `symbols` carries the symbols
of a PLC between devices, sources and symbol files; `selection` chooses them by pattern.
"""
