"""Whom a station talks to, as it was told: the address and the key file of every peer."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.link.wire.address import Address


def addresses_of(own: str, names: list[str], given: Mapping[str, Address]) -> list[Address]:
    """The address of every peer; one peer needs no name.

    Raises:
        InputError: a name is no peer's, or an address is missing.
    """
    if set(given) == {""} and len(names) == 1:
        return [given[""]]
    _check_names(own, names, given, "--peer")
    missing = [name for name in names if name not in given]
    if missing:
        raise InputError(
            f"{own} exchanges values with {', '.join(names)}; give the address of "
            f"{missing[0]} with --peer {missing[0]}=host:port"
        )
    return [given[name] for name in names]


def key_files_of(own: str, names: list[str], given: Mapping[str, Path]) -> list[Path | None]:
    """The key file of every peer; one peer needs no name.

    Raises:
        InputError: a name is no peer's, or two pairs would have one key.
    """
    if "" in given and len(names) > 1:
        raise InputError(
            f"{own} talks to {', '.join(names)}: with one key for all, each of them could speak in "
            f"another's name. Make a key for each pair, and give it with --key {names[0]}=FILE"
        )
    if set(given) == {""}:
        return [given[""]]
    _check_names(own, names, given, "--key")
    paths = list(given.values())
    if len({path.resolve() for path in paths}) < len(paths):
        raise InputError("two peers have one key file: make a key for each pair with 'keygen'")
    return [given.get(name) for name in names]


def _check_names(own: str, names: list[str], given: Mapping[str, object], option: str) -> None:
    for name in given:
        if name not in names:
            what = f"'{name}' is no peer of {own}" if name else f"{option} needs a station's name"
            raise InputError(f"{what}.{did_you_mean(name, names)}")
