"""Texts of sources as tokens: literals, words, comments, pragmas; and XML around them."""
