"""Drawn bodies in PLCopen XML (TC6)."""
