"""Packages that a replay needs for some of its work, imported when it comes to that."""

import importlib
from typing import Any


class MissingPackageError(ImportError):
    """A package of the extra `replay` that is not installed; the text says how to get it."""


def require(module: str, what: str) -> Any:
    """Return the module; raises MissingPackageError, which says that `what` needs its package."""
    package = module.partition('.')[0]
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if (error.name or '').partition('.')[0] != package:
            raise
        raise MissingPackageError(
            f'{what} needs the package {package}: pip install {package}'
        ) from error
