"""Commands that test: `achse check`, `explain`, `test`, `mutate`, `fault` and `sweep`.

Read `check` first: it reads a station.toml or a PLC project and runs nothing; `stubs` writes
declarations that a project misses, `explain` shows the meaning of a finding. `unit_tests` runs the
suites of a project in virtual time, `mutate` plants faults that they are to notice. `fault` makes
things go wrong on a running station, `sweep` runs a scenario for many parameters.
"""
