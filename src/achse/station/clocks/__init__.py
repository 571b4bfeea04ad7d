"""Time of a station: its cycle, its time stamps, and its pace by the wall clock.

Read `cycle` first: phases in a fixed order, each with its next due moment; `phases` has those of
PLC, NC and notifications, `timer_queue` calls functions at station times. `clock` maps station time
to Unix time. A running station follows the wall clock by `pacing`, which `wake_timer` wakes;
`priority` runs it before other programs.
"""
