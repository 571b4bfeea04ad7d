"""AMS frames over a serial line.

Read `carrier` first: what fits, and what is answered if it does not. `port` names, sets and opens
a serial port, `ports` are those that a station serves.
"""
