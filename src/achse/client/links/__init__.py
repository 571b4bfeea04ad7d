"""Ways to a router: TCP, TLS (Secure ADS), MQTT, a serial line, or none at all in one process."""
