"""A folder of systems, registered as a whole."""
