"""Declared names: scopes, constants, types, records of blocks, standard libraries."""
