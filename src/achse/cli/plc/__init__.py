"""Commands about PLC programs: `achse check`, `achse test` and `achse plc`.

Read `check` first: it reads a project and runs nothing. `unit_tests` runs the suites of a project
in virtual time. `plc` debugs the programs of a running station.
"""
