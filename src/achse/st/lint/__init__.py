"""Lint: warnings about code that compiles and is probably not what its author meant.

Read `linting` first. `uses` collects what reads and writes each variable; `variables`,
`statements` and `comparisons` have the rules. `options` reads the table `[lint]` of achse.toml.
"""
