"""A station on a network: its listeners, its identity, and the routes to other routers.

Read `network` first: the listeners, searches, brokers and serial lines of a running station.
`route_file` has the routes that it begins with and keeps; `identity` is its certificate for Secure
ADS; `addresses` derives its NetId and the computers that reach an address.
"""
