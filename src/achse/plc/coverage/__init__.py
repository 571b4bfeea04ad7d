"""Coverage: how often statements and branches of a PLC's code have run, and reports of it.

`counters` has the numbers while programs run, `results` what they mean by file, routine and place.
`report` chooses the form by a file's name; `text`, `html`, `lcov` and `cobertura` write it.
"""
