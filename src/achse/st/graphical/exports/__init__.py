"""Drawn bodies in exports of TwinCAT 2 and CoDeSys 2.3."""
