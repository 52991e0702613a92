"""What tests of SSP files share."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.ssp import adder_folder


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Where FMUs that add lie, for systems to be written beside them."""
    return adder_folder(tmp_path)
