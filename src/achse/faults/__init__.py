"""Faults on demand: each kind is written once, what it takes and what it does in one place."""
