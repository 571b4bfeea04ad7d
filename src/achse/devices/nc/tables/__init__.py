"""Services of tables: cams, characteristics of valves and motion functions.

Read `services` first; `motion_functions` adds points with laws. `places` finds a table, its rows
and its columns.
"""
