"""Commands about the installation: `achse docs`, `warmup`, `certificate`.

Each is independent: `docs` writes and serves the documentation, `warmup` compiles the kernels for
this machine, `certificate` is about our key for Secure ADS.
"""
