"""Components in Python: classes given as ``module:Class``, and devices found by their URL."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

from cosim.base.component import Causality, Component, Variable
from cosim.base.errors import CohapticError, InputError, RunError
from cosim.base.suggest import did_you_mean
from cosim.base.system.installed import registered
from cosim.master.components.blame import told
from cosim.master.components.interface import Interface
from cosim.master.components.variables import checked_variables
from cosim.scenario.build.component import COMPONENTS

DEVICES = "cohaptic.devices"
HARDWARE = "cohaptic.hardware"
"""Who makes a component of a device's URL, whichever its driver is."""
METHODS = ("read", "evaluate", "write", "step")


def load_class(source: str, folder: Path) -> Component:
    """A component from ``module:Class``, ``file.py:Class``, or a name with an entry point.

    The scenario's folder is searched as well.

    Raises:
        InputError: there is no such module or class, or it is no component.
    """
    module_name, colon, class_name = source.rpartition(":")
    made = _find_class(module_name, class_name, folder) if colon else _registered_class(source)
    if not (isinstance(made, type) and issubclass(made, Component)):
        raise InputError(f"{source} is not a subclass of cosim.base.component.Component")
    try:
        return made()
    except Exception as error:
        raise InputError(f"{source}() cannot be made: {told(error)}") from None


def _registered_class(name: str) -> Any:
    """What a package that is installed has registered under a short name."""
    found = {entry.name: entry for entry in registered(COMPONENTS)}
    if name not in found:
        hint = did_you_mean(name, found)
        raise InputError(
            f"'{name}' is not written as module:Class, and no package has registered it.{hint}"
        )
    try:
        return found[name].load()
    except (Exception, SystemExit) as error:
        value = found[name].value
        raise InputError(f"{name} ({value}) cannot be imported: {told(error)}") from None


def open_device(url: str, options: Mapping[str, Any], safety: Mapping[str, Any]) -> Component:
    """The device component that a URL stands for, from the entry points ``cohaptic.devices``.

    The part of the URL's scheme before ``+`` names the driver; the entry point's object offers
    ``component(url, options, safety)``; ``safety`` are the scenario's limits for every device.

    Raises:
        InputError: there is no driver of that name, or it cannot be loaded.
    """
    name = url.partition("://")[0].partition("+")[0]
    found = {entry.name: entry for entry in registered(DEVICES)}
    if name not in found:
        raise InputError(
            f"there is no device driver '{name}' for {url}.{did_you_mean(name, found)}"
        )
    for entry in registered(HARDWARE):
        return entry.load()(url, dict(options), dict(safety))
    raise InputError(f"no package that is installed makes components of devices such as {url}")


def interface_of(name: str, component: Component, *, feedthrough: bool | None) -> Interface:
    """A Python component as the connections see it.

    Raises:
        InputError: what it says of its variables cannot be, or saying it fails.
    """
    try:
        variables = checked_variables(component)
        dependencies, terminals = component.dependencies, component.terminals
        _check_names(variables, dependencies, terminals)
        _check_bound(component, variables)
        return Interface(
            component=name,
            variables=variables,
            feedthrough=component.feedthrough if feedthrough is None else feedthrough,
            dependencies=dependencies,
            terminals=terminals,
        )
    except CohapticError:
        raise
    except Exception as error:
        raise InputError(f"{name} cannot tell its variables: {told(error)}") from None


def _check_bound(component: Component, variables: Mapping[str, Variable]) -> None:
    """Somebody takes the texts that the component says it has."""
    shown = {Causality.INPUT, Causality.OUTPUT}
    texts = [v for v in variables.values() if v.type.is_text and v.causality in shown]
    if texts and type(component).bind_texts is Component.bind_texts:
        raise InputError(
            f"the {texts[0].type} '{texts[0].name}' is handed over by bind_texts(inputs, outputs), "
            f"which {type(component).__name__} does not have"
        )


def _check_names(
    variables: Mapping[str, Variable],
    dependencies: Mapping[str, Sequence[str]],
    terminals: Mapping[str, Mapping[str, str]],
) -> None:
    """What dependencies and terminals name is there, and is what they take it for."""
    for output, inputs in dependencies.items():
        for name, wanted in ((output, Causality.OUTPUT), *((i, Causality.INPUT) for i in inputs)):
            known = [v.name for v in variables.values() if v.causality is wanted]
            if name not in known:
                hint = did_you_mean(name, known)
                raise InputError(f"'dependencies' names '{name}', which is no {wanted}.{hint}")
    for terminal, members in terminals.items():
        for name in members.values():
            if name not in variables:
                hint = did_you_mean(name, variables)
                raise InputError(f"the terminal {terminal} names '{name}'; there is none.{hint}")


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


def file_source(source: str, folder: Path) -> str:
    """``module:Class`` as ``/folder/module.py:Class`` where the module lies beside the scenario.

    So a resolved scenario finds it from any other folder.
    """
    module_name, _, class_name = source.rpartition(":")
    file = (folder / f"{module_name}.py").absolute()
    return f"{file}:{class_name}" if class_name and file.is_file() else source


def _find_class(module_name: str, class_name: str, folder: Path) -> Any:
    given = Path(module_name)
    own = given if given.suffix == ".py" else folder / f"{module_name.replace('.', '/')}.py"
    sys.path.insert(0, str(own.parent if own is given else folder))
    try:
        module = _import(own.stem if own is given else module_name, own)
    except (Exception, SystemExit) as error:
        raise InputError(f"the module {module_name} cannot be imported: {told(error)}") from None
    finally:
        del sys.path[0]
    if not hasattr(module, class_name):
        names = [name for name, value in vars(module).items() if isinstance(value, type)]
        hint = did_you_mean(class_name, names)
        raise InputError(f"the module {module_name} has no class '{class_name}'.{hint}")
    return getattr(module, class_name)


def _import(name: str, own: Path) -> ModuleType:
    """The module; the file ``own`` where it exists, even if another one has its name already."""
    before = sys.modules.get(name)
    known = getattr(before, "__file__", None)
    if before is None or known is None or not own.is_file() or own.samefile(known):
        return importlib.import_module(name)
    # Somebody else's scenario had a module of this name in its own folder.
    del sys.modules[name]
    try:
        importlib.invalidate_caches()
        return importlib.import_module(name)
    finally:
        sys.modules[name] = before
