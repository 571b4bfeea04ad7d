"""Generators: each way of making set points is a module of its own and a row of `table`."""
