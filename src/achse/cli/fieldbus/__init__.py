"""Commands about EtherCAT: `achse bus` and `achse drive`.

Read `bus` first: the slaves of a station, or served ones (`served`); `bus_file` transfers files of
slaves, `interface` looks at the slaves of a network interface. `bus_serve` and `drive` serve
virtual slaves by `serving`, and `objects` shows the object dictionary of a drive.
"""
