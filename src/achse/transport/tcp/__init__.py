"""AMS/TCP, the side that listens.

Read `listener` first: who is let in, and how many. `acceptor` accepts at its sockets, `idle`
chooses the connection that ends for a newcomer, `refusal` answers those for which there is no
room.
"""
