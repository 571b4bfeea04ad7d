"""A station on a network: where it listens, who it is, and the routes to other routers.

Read `network` first: the listeners, searches, brokers and serial lines of a running station.
`route_file` has the routes that it begins with and keeps; `identity` is its certificate for Secure
ADS; `addresses` derives its NetId and tells which computers reach an address.
"""
