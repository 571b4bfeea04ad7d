"""Traffic between clients and targets: decoded with names, captured, recorded, replayed.

A recording is an ordinary packet capture (pcapng), so that tshark reads ours and we read others.
"""
