"""h5py, imported when it is first needed, and typed as what it is: without stubs."""

from __future__ import annotations

import importlib
from typing import Any


def h5py() -> Any:
    """The h5py package (about 0.1 s and 15 MB on first use)."""
    return importlib.import_module("h5py")
