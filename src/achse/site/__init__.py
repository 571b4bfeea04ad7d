"""The documentation as a site: settings and generated pages of MkDocs."""
