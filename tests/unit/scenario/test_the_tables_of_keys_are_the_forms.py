"""The tables of keys in the pages are those of the forms, and each form has one."""

from __future__ import annotations

import pytest

from tests.support.forms.tables import DOCS, MARK, forms, written


@pytest.mark.parametrize("page", ["scenario.md", "hardware.md"])
def test_a_pages_tables_are_up_to_date(page) -> None:
    text = (DOCS / page).read_text("utf-8")
    assert MARK.search(text)
    assert text == written(text), "run: python -m tests.support.forms.tables"


def test_every_form_has_a_table() -> None:
    told = {
        mark[2] for page in DOCS.glob("*.md") for mark in MARK.finditer(page.read_text("utf-8"))
    }
    # A reason stands beside its limit, and has nothing to say of itself.
    assert told == forms().keys() - {"LoosenedForm", "DriverSettings"}
