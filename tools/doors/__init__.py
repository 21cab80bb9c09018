"""Odd input at every door of the package."""
