"""Components in Python: classes given as ``module:Class``, and devices found by their URL."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from cosim.base.component import Component
from cosim.base.errors import CohapticError, InputError, RunError
from cosim.base.suggest import did_you_mean
from cosim.master.assembly.blame import told
from cosim.master.assembly.interface import Interface
from cosim.master.assembly.variables import checked_variables

DEVICES = "cohaptic.devices"
COMPONENTS = "cohaptic.components"
METHODS = ("read", "evaluate", "write", "step")


def load_class(source: str, folder: Path) -> Component:
    """A component from ``module:Class``, or from a name registered as an entry point.

    The scenario's folder is searched as well.

    Raises:
        InputError: there is no such module or class, or it is no component.
    """
    registered = {entry.name: entry for entry in entry_points(group=COMPONENTS)}
    module_name, colon, class_name = source.partition(":")
    if source in registered:
        made: Any = registered[source].load()
    elif not colon:
        hint = did_you_mean(source, registered)
        raise InputError(f"'{source}' is not written as module:Class.{hint}")
    else:
        made = _find_class(module_name, class_name, folder)
    if not (isinstance(made, type) and issubclass(made, Component)):
        raise InputError(f"{source} is not a subclass of cosim.base.component.Component")
    try:
        return made()
    except Exception as error:
        raise InputError(f"{source}() cannot be made: {told(error)}") from None


def open_device(url: str, options: Mapping[str, Any], safety: Mapping[str, Any]) -> Component:
    """The device component that a URL stands for, from the entry points ``cohaptic.devices``.

    The part of the URL's scheme before ``+`` names the driver; the entry point's object offers
    ``component(url, options, safety)``; ``safety`` are the scenario's limits for every device.

    Raises:
        InputError: there is no driver of that name, or it cannot be loaded.
    """
    name = url.partition("://")[0].partition("+")[0]
    found = {entry.name: entry for entry in entry_points(group=DEVICES)}
    if name not in found:
        raise InputError(
            f"there is no device driver '{name}' for {url}.{did_you_mean(name, found)}"
        )
    try:
        driver: Any = found[name].load()
    except ImportError as error:
        raise InputError(f"the device driver '{name}' cannot be loaded: {error}") from None
    return driver.component(url, dict(options), dict(safety))


def interface_of(name: str, component: Component, *, feedthrough: bool | None) -> Interface:
    """A Python component as the connections see it.

    Raises:
        InputError: what it says of its variables cannot be, or saying it fails.
    """
    try:
        variables = checked_variables(component)
        return Interface(
            component=name,
            variables=variables,
            feedthrough=component.feedthrough if feedthrough is None else feedthrough,
            dependencies=component.dependencies,
            terminals=component.terminals,
        )
    except CohapticError:
        raise
    except Exception as error:
        raise InputError(f"{name} cannot tell its variables: {told(error)}") from None


def methods_of(component: Component) -> frozenset[str]:
    """Which of read, evaluate, write and step the component has of its own."""
    return frozenset(
        name for name in METHODS if getattr(type(component), name) is not getattr(Component, name)
    )


@contextmanager
def sentences(name: str, when: str) -> Generator[None]:
    """Turn what a Python component raises into a sentence that names it."""
    try:
        yield
    except CohapticError:
        raise
    except Exception as error:
        raise RunError(f"{name} failed {when}: {told(error)}") from error


def _find_class(module_name: str, class_name: str, folder: Path) -> Any:
    sys.path.insert(0, str(folder))
    try:
        module = importlib.import_module(module_name)
    except (Exception, SystemExit) as error:
        raise InputError(f"the module {module_name} cannot be imported: {told(error)}") from None
    finally:
        sys.path.remove(str(folder))
    if not hasattr(module, class_name):
        names = [name for name, value in vars(module).items() if isinstance(value, type)]
        hint = did_you_mean(class_name, names)
        raise InputError(f"the module {module_name} has no class '{class_name}'.{hint}")
    return getattr(module, class_name)
