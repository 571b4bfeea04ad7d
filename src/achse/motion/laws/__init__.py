"""Laws of motion: how a slave goes from point to point of a motion function, over its master."""
