"""The faces: one module or folder per ADS device, service rows bound to the state of a wing.

Read `system` first, the device that each client queries; then `nc` and `plc`, whose rows are bound
to `achse.motion` and `achse.plc`. `io` has the masters and slaves of buses, `drives` the service of
drives; `scope`, `camshaft` and `modbus` are devices of their own. `station` (with `debugging`) is
our own service at port 26000; `router`, `logger`, `licence` and `realtime` are small.
"""
