"""Commands that talk to any ADS device: `achse ads`.

Read `ads` first: state, values by name, subscriptions. `raw` goes by index group and offset,
`route` and `scan` are about routers, `stats` about stations of achse.
"""
