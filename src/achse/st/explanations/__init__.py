"""Explanations of findings: title, meaning, remedy, and an example that gives the finding.

The tables beside this file have them, by family of codes.
"""
