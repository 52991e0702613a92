"""Reading an FMU: unpacked and parsed when its content is first met, recalled from then on."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from functools import cache, lru_cache
from importlib.util import find_spec
from pathlib import Path

from cosim.base import component, meaning
from cosim.base.quantities import quantity, units
from cosim.base.system.store import keep, recall
from cosim.master.components import clocks
from cosim.master.fmu import description, meanings, plain_description, rules
from cosim.master.fmu.archive import sha256_of, unpack
from cosim.master.fmu.description import FmuDescription
from cosim.master.fmu.parsing import model_structure, parse, variables
from cosim.master.fmu.parsing.parse import parse_description
from cosim.master.fmu.plain_description import from_plain, to_plain


def read_description(path: Path, structure: Mapping[str, int] | None = None) -> FmuDescription:
    """Unpack and read a co-simulation FMU of FMI 2.0 or 3.0.

    ``structure`` gives structural parameters other values than their start; arrays follow.

    Raises:
        InputError: the archive or its description cannot be used.
    """
    digest = sha256_of(path)
    folder = unpack(path, digest)
    return _read(path, folder, digest, tuple(sorted((structure or {}).items())))


@lru_cache(maxsize=128)
def _read(
    path: Path, folder: Path, digest: str, structure: tuple[tuple[str, int], ...]
) -> FmuDescription:
    from fmus.cache import cache_directory

    name = hashlib.sha256(repr((digest, structure, _readers())).encode()).hexdigest()
    file = cache_directory() / "descriptions" / name
    content = recall(file)
    if content is not None:
        try:
            return from_plain(content, path, folder)
        except (KeyError, TypeError, ValueError):
            pass  # not what this version keeps: read anew
    found = parse_description(path, folder, digest, structure)
    keep(file, to_plain(found))
    return found


@cache
def _readers() -> tuple[object, ...]:
    """What a kept description depends on besides the FMU: the code that made it."""
    parsers = (parse, variables, model_structure, description, plain_description)
    modules = (*parsers, rules, meanings, clocks, component, meaning, quantity, units)
    own = [Path(str(module.__file__)) for module in modules]
    state = hashlib.sha256()
    for source in own:
        state.update(source.read_bytes())
    spec = find_spec("fmpy")
    found = Path(str(spec.origin)).parent / "model_description.py" if spec else None
    stat = found.stat() if found is not None and found.is_file() else None
    return state.hexdigest(), None if stat is None else (stat.st_size, stat.st_mtime_ns)
