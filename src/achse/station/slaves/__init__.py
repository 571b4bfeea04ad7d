"""Slaves in a process of their own: drives and terminals that `achse drive` serves at interfaces.

Read `serving` first: a segment answers the frames of a link. `ring_ends` is the link of a redundant
line. `machine_file` reads the machines of the drives, `parameter_file` keeps what they store by
1010h, and `drive_control` is their ADS service.
"""
