"""Which impairments there are: the built-in ones, and those that installed packages bring."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import import_module

from cosim.base.errors import InputError
from cosim.base.system.installed import registered
from cosim.scenario.impairments.impairment import Impairment

GROUP = "cohaptic.impairments"

BUILT_IN = ("trace", "jitter", "loss", "reorder", "duplication")
"""A file of this folder each, with the ``Impairment`` called like it in capitals."""

DELAY_FORMS = ("delay", "round_trip_delay", "each_way_delay")
"""The three ways to give a channel's delay; exactly one of them."""


@cache
def impairments() -> Mapping[str, Impairment]:
    """Every impairment by its key.

    Raises:
        InputError: a package brings one that cannot be used.
    """
    found = {name: _built_in(name) for name in BUILT_IN}
    for entry in registered(GROUP):
        package = entry.dist.name if entry.dist is not None else entry.value
        try:
            brought = entry.load()
        except Exception as error:
            message = (
                f"the impairment '{entry.name}' of {package} cannot be loaded: {error}. Mend or "
                "uninstall that package."
            )
            raise InputError(message) from error
        if not isinstance(brought, Impairment) or brought.name != entry.name:
            raise InputError(
                f"the entry point '{entry.name}' of {package} leads to {entry.value}, which is no "
                f"impairment of that name; it must be an Impairment with name='{entry.name}'."
            )
        if brought.name in found:
            raise InputError(
                f"{package} brings an impairment '{brought.name}', but channels have a key of that "
                "name already; uninstall that package or rename its impairment."
            )
        found[brought.name] = brought
    return found


def replaced_by(name: str) -> tuple[str, ...]:
    """The keys of a channel that an impairment stands in place of."""
    keys = impairments()[name].replaces
    return (*(DELAY_FORMS if "delay" in keys else ()), *(key for key in keys if key != "delay"))


def _built_in(name: str) -> Impairment:
    return getattr(import_module(f"cosim.scenario.impairments.{name}"), name.upper())
