"""Robots, worlds, links and bus profiles: TOML files, and the loader that turns them into frozen dataclasses.

The files lie inside the package, so an installed wheel finds them as a checkout does.
"""

from configs.loader import ConfigError, build, described, find, full_name, laid_over, load, names, nearest, read

__all__ = ["ConfigError", "build", "described", "find", "full_name", "laid_over", "load", "names", "nearest", "read"]
