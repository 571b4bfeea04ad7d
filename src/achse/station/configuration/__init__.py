"""Configuration of a station: the keys of a station.toml, read and checked.

Read `station_file` first: the tables of the file and how it is loaded. `network` has the tables
that a router without devices has too, `validation` how errors name their key.
`types` has what tables are made of: durations, addresses and their base class. Each larger table is
a module: `bus` (with drives), `terminal`, `group` (with channels), `camshaft`, `signal`, `scope`,
`mqtt`, `modbus`, `secure`, `http` and `limits`. `documents` parses TOML and JSON of any content;
`schema` describes the file to editors.
"""
