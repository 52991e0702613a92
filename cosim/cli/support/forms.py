"""The forms of a scenario's sections, each from the package that obeys it."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pydantic import BaseModel

    from cosim.scenario.form.sections import Forms


def _safety() -> type[BaseModel]:
    from hil.safety.form import SafetyForm

    return SafetyForm


def _realtime() -> type[BaseModel]:
    from cosim.realtime.form import RealtimeForm

    return RealtimeForm


def _link() -> type[BaseModel]:
    from cosim.link.stream.form import LinkForm

    return LinkForm


def _expect() -> type[BaseModel]:
    from cosim.report.expectation_form import expect_form

    return expect_form()


FORMS: Forms = {"safety": _safety, "realtime": _realtime, "link": _link, "expect": _expect}
