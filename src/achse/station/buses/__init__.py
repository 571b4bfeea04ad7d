"""EtherCAT buses of a station: master, slaves in this process or at an interface, and axes.

Read `plan` first: which device is at each place of a bus. `ethercat_bus` is a bus within this
process, whose drives come from `virtual_drives`; `interface_bus` is one on a network interface, and
uses `frame_link`, `redundant_link`, `interface_pair` and `reference_pace`. `axis_bus` joins axes
with drives; `kernel_cycles` and `whole_cycle` do many of its cycles without frames.
"""
