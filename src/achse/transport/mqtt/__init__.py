"""AMS frames through an MQTT broker.

Read `network` first: the connection to a broker as a virtual AMS network. `routes` makes a route
of each partner in it, `partner_requests` ends requests to partners that vanish.
"""
