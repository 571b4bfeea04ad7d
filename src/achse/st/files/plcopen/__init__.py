"""Projects in PLCopen XML (TC6): read as sources, written from sources."""
