"""A distribution of somebody else, with systems of its own."""
