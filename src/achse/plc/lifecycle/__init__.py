"""Lifecycle of instances: start values, FB_init to FB_exit, online changes.

Read `start_values` and `instance_paths` (values put over the initial ones), then `instances`;
`instance_moves` lists the instances that an online change ends and creates, `static_instances`
creates those of VAR_STAT.
"""
