"""Building a station from its configuration: each restart makes the parts again.

Read `building` first: what a part gets and what it adds. `assembly` lists the parts in order. Each
part is a module: `nc`, `plcs`, `terminals`, `signals`, `camshaft`, `scope` and `modbus`. Buses of
drives and buses of terminals share `bus_parts`. The values of simulated signals are in `waveforms`
and `expressions`.
"""
