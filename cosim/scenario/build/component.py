"""A written component resolved: its source found, its rate in ticks."""

from __future__ import annotations

import re
from fractions import Fraction
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from cosim.base.suggest import did_you_mean
from cosim.base.system.installed import registered
from cosim.scenario.build.context import Context
from cosim.scenario.form.document import ComponentForm, DeviceForm
from cosim.scenario.model import Kind, ScenarioComponent
from cosim.scenario.source.merge import KINDS

COMPONENTS = "cohaptic.components"
"""The entry points with which packages register components under short names."""


def build_component(context: Context, name: str, form: ComponentForm) -> ScenarioComponent | None:
    """The component, or ``None`` after reporting why there is none."""
    kind = Kind(next(key for key in KINDS if getattr(form, key) is not None))
    source = _source(context, name, kind, form)
    rate = context.rate(form.rate, ("components", name))
    if source is None or rate is None or rate in context.refused:
        return None
    bundled = kind is Kind.FMU and not Path(source).is_absolute()
    if form.flavour is not None and not bundled:
        message = f"components.{name}: 'flavour' is for bundled models; {form.fmu} is a file."
        context.problems.add(("components", name, "flavour"), message)
    feedthrough = form.feedthrough
    if kind is Kind.FMU and feedthrough is None:
        feedthrough = bundled
    return ScenarioComponent(
        name=name,
        kind=kind,
        source=source,
        station=form.station,
        rate_name=context.rate_name(form.rate),
        rate=rate,
        period=context.timebase.period(rate),
        flavour=form.flavour or "fmi3",
        substeps=form.substeps or 1,
        feedthrough=feedthrough,
        is_strict=form.validate_ == "strict",
        is_isolated=form.isolate == "process",
        event_mode=form.event_mode,
        parameters=form.parameters,
        start=form.start,
        options=_options(context, form, name),
    )


def _options(context: Context, form: ComponentForm, name: str) -> dict[str, Any]:
    if isinstance(form.device, DeviceForm):
        settings = dict(form.device.model_extra or {})
        if isinstance(settings.get("file"), str):
            folder = context.folder(("components", name, "device", "file"))
            settings["file"] = str((folder / Path(settings["file"]).expanduser()).absolute())
        return settings
    if form.playback is not None:
        return {"component": form.of or name}
    if form.table is not None:
        return {
            "columns": tuple(form.columns or ()),
            "interpolate": form.interpolate or "hold",
            "time_offset": form.time_offset or Fraction(0),
        }
    return {}


def _source(context: Context, name: str, kind: Kind, form: ComponentForm) -> str | None:
    path = ("components", name, kind.value)
    match kind:
        case Kind.FMU:
            found, message = _fmu(form.fmu or "", context.folder(path))
        case Kind.PYTHON:
            found, message = _python(form.python or "", context.folder(path))
        case Kind.DEVICE:
            device = form.device
            found, message = _url(device.url if isinstance(device, DeviceForm) else device or "")
        case Kind.PLAYBACK:
            found, message = _folder(form.playback or "", context.folder(path))
        case Kind.TABLE:
            found, message = _file(form.table or "", context.folder(path))
    if found is None:
        context.problems.add(path, f"components.{name}: {message}")
    return found


def bundled_models() -> list[str]:
    """The names of the models that come with cohaptic."""
    files = (file for folder in _model_folders() for file in folder.glob("*/variables.py"))
    return sorted(file.parent.name for file in files)


@cache
def _is_bundled(text: str) -> bool:
    is_name = re.fullmatch(r"\w+", text) is not None
    return is_name and any((at / text / "variables.py").is_file() for at in _model_folders())


def _model_folders() -> list[Path]:
    spec = find_spec("fmus")
    return [Path(at) for at in (spec and spec.submodule_search_locations) or []]


def _fmu(text: str, folder: Path) -> tuple[str | None, str]:
    is_path = "/" in text or "\\" in text or text.casefold().endswith(".fmu")
    if not is_path:
        if _is_bundled(text):
            return text, ""
        hint = did_you_mean(text, bundled_models(), listed=20)
        return (
            None,
            f"no bundled FMU is called '{text}'.{hint} A file needs a path that ends in .fmu.",
        )
    file = (folder / Path(text).expanduser()).absolute()
    if file.is_file() or (file / "modelDescription.xml").is_file():
        return str(file), ""
    if file.is_dir():
        return None, f"{file} is a folder without a modelDescription.xml, so it is no unpacked FMU."
    return None, f"there is no file {file}."


def _python(text: str, folder: Path) -> tuple[str | None, str]:
    if found := re.fullmatch(r"(.+\.py):([^\W\d]\w*)", text):
        file = (folder / Path(found[1]).expanduser()).absolute()
        if not file.is_file():
            return None, f"there is no file {file}."
        return f"{file}:{found[2]}", ""
    if re.fullmatch(r"[^\W\d]\w*(\.[^\W\d]\w*)*:[^\W\d]\w*", text):
        return text, ""
    # A package that is installed may have registered a short name.
    if re.fullmatch(r"[\w.-]+", text):
        names = [entry.name for entry in registered(COMPONENTS)]
        if text in names:
            return text, ""
        hint = did_you_mean(text, names)
    else:
        hint = ""
    message = (
        f"'{text}' is no Python class; write 'package.module:Class' or 'file.py:Class', or the "
        f"name of one that a package has registered.{hint}"
    )
    return None, message


def _url(text: str) -> tuple[str | None, str]:
    if re.match(r"[a-z][a-z0-9+._-]*://", text):
        return text, ""
    return None, f"'{text}' is no device URL; write 'driver://port', such as 'mock://'."


def _file(text: str, folder: Path) -> tuple[str | None, str]:
    file = (folder / Path(text).expanduser()).absolute()
    return (str(file), "") if file.is_file() else (None, f"there is no file {file}.")


def _folder(text: str, folder: Path) -> tuple[str | None, str]:
    place = (folder / Path(text).expanduser()).absolute()
    return (str(place), "") if place.is_dir() else (None, f"there is no run folder {place}.")
