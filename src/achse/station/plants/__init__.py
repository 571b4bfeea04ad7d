"""Plants: co-simulation units (FMUs) that the station steps, each in a process of its own.

Read `archive` (what is in the file, without running any of it), `description` (its variables),
`process` (the station's end of the process), `worker` (the other end, where FMPy loads the native
code) and `axis_port` (a unit behind the hardware port of axes).
"""
