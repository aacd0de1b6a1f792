"""The version, for those that must not know the whole package."""

__version__ = "0.1.0"
