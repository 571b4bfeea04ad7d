"""Mutation testing of PLC code: small faults are planted, and the tests that notice are listed.

`operators` makes the faults in the typed form, `edits` has them as text, `marks` leaves some out.
`reach` finds which suites run which statements, `trials` is a run of the tests, `forks` makes a
copy of the loaded station for each, and `campaign` puts them together. `results` is what came of
it, `report` writes it to files.
"""
