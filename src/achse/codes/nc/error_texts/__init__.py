"""Meanings of NC error codes by groups of errors, imported when a text is needed."""
