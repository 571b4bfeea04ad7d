"""Persistence of a station: data that survive a restart, the end of the program, and a kill.

Read `persistent_data` first: which data of axes and PLCs are kept, and when. `persistent_image` is
their content at one boundary of the cycle; `snapshots` writes images of a running station into the
two slots of a `snapshot_file`. `state_file` is a text that is replaced whole. `file_port` is the
part of a file system that both use.
"""
