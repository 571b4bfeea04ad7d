"""Commands that try a machine: `achse fault` and `achse sweep`.

`fault` makes things go wrong on a running station; `sweep` runs a scenario for many parameters.
"""
