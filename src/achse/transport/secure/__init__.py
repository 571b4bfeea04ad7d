"""Secure ADS: TLS below, AMS/TCP above, a connect block between.

Read `channel` first, for both ends; it rests on `tls`, which has no socket. `listener` says which
clients are let in, `handshakes` how many at a time. `own_certificate` makes the station's key;
`password_checker` and `password_queue` check passwords in turns, also those of discovery over
UDP.
"""
