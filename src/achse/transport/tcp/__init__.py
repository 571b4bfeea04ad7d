"""AMS/TCP, the side that listens.

Read `listener` first: admission and limits of connections. `acceptor` accepts at its sockets,
`idle` chooses the connection that ends for a newcomer, `refusal` answers those for which there is
no room.
"""
