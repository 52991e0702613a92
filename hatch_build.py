"""The build hook: compiles the FMUs and the kernel for every platform, before a wheel is packed.

Also runs for ``uv sync`` and ``pip install -e``. Nothing is compiled when nothing changed.
"""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class NativeBuildHook(BuildHookInterface[Any]):
    """Adds what was compiled to the wheel, which stays free of any platform (py3-none-any)."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build before packing; ``version`` is ``standard`` or ``editable``."""
        if self.target_name != "wheel":
            return
        root = Path(self.root)
        sys.path.insert(0, str(root))
        try:
            from fmus.builder import build_all
            from fmus.compiler import PLATFORMS

            for name in build_all():
                self.app.display_info(f"Built the FMUs of {name}")
            kernel = _load(root / "cosim" / "master" / "kernel" / "build.py")
            for platform in PLATFORMS:
                kernel.build_kernel(platform)
        finally:
            sys.path.remove(str(root))
        if version == "standard":  # an editable installation finds them in the checkout
            build_data["force_include"][str(root / "scenarios")] = "cohaptic/_scenarios"
            # FMUs that are built with the wheel have it in them, too.
            build_data["force_include"][str(root / "LICENSE")] = "fmus/LICENSE"
        build_data["artifacts"] += [
            "/fmus/_built/*.fmu",
            "/fmus/_built/*.json",
            "/cosim/master/kernel/_built/*",
        ]


def _load(path: Path) -> Any:
    """One module by its file: its package needs more than a build environment has."""
    spec = importlib.util.spec_from_file_location("kernel_build", path)
    if spec is None or spec.loader is None:
        raise FileNotFoundError(path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
