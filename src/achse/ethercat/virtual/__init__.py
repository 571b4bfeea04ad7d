"""Virtual slaves made from ESI files: EEPROM, objects, process data, mailbox, behaviour."""
