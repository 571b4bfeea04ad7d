"""Channels: what owns groups. One with an interpreter runs part programs on its 3D group.

Source: 002 §6.4.2.
"""
