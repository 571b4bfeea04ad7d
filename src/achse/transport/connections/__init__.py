"""Connections without a socket: bytes in, frames out, and back.

Read `peer` first: it parts a stream into frames and passes them to the router. `writer` gathers
answers in its `write_buffer`. Requests of others that are known go by `known.requests` and come
back by `known.answers`, without decoding; `known.frames` decides, `port_service` serves programs
that want a port. `byte_transport` has the interfaces that a peer needs, `connection` those of
asyncio. `fair_queue` serves peers in turns, `send_budget` bounds their buffers in sum, `repeated`
answers reads that come again and again. `senders` and `sender_rights` note the senders of one
connection; `caller` is the asking end.
"""
