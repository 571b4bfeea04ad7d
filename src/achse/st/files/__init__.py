"""Files of a project: envelopes of sources, folders, tasks, references to libraries."""
