"""Random motions of random systems, against a route of their own."""
