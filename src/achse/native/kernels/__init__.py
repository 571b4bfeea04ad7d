"""The front end for Python: kernels, which are typed plain functions on records.

`translate` begins with one function and takes in all it calls; `expressions` and `statements` say
what the source means, `arithmetic` what Python's numbers do, in instructions of the back end.
"""
