"""The version, known to all packages."""

__version__ = "0.1.0"
