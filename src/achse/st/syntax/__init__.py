"""Syntax: the tree of Structured Text, the parser that makes it, the printer that writes it."""
