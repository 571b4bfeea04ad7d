"""Commands about EtherCAT: `achse bus` is the master's side, `achse drive` that of the slaves.

Read `bus` first: the slaves of a station, or at an interface; `bus_file` transfers their files.
`drive` serves virtual drives, `drive_control` talks to drives that are served, and `objects` shows
their object dictionary.
"""
