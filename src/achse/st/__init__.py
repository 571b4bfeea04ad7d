"""Structured Text: lexer, Pratt parser, syntax tree, and declarations as IEC types."""
