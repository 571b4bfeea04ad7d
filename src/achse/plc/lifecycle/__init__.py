"""Life of instances: start values, FB_init to FB_exit, what an online change begins and ends.

Read `starts` and `instance_paths` (values put over the initial ones), then `instances`; `lives`
says whose life an online change touches, `static_lives` treats VAR_STAT.
"""
