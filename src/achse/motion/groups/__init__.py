"""Groups: axes that move together. A kind of group is a file with a class; `table` names it.

Source: 002 §6.4.3.
"""
