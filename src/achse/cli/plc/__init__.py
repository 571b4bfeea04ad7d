"""Commands about the PLCs of a station: `achse plc` and `achse symbols`.

Read `plc` first: it debugs the programs of a running station. `symbols` carries the symbols of a
PLC between devices, sources and symbol files; `selection` chooses them by pattern.
"""
