"""What a table names as `package.module:function`, imported when it is asked for."""

from importlib import import_module
from typing import Any


def named(where: str) -> Any:
    """The object that `where` names."""
    module, _, name = where.partition(":")
    return getattr(import_module(module), name)
