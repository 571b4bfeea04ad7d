"""Tools for agents over the Model Context Protocol: check and mend PLC sources, run stations.

Needs the extra `mcp`.
"""
