"""The systems that come with the engine: one module each, found by listing this folder."""
