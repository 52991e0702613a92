"""A key is made once, kept from others, and never lets two sessions share what it derives."""

from __future__ import annotations

import base64
import os
import stat

import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from cosim.base.errors import InputError
from cosim.cli.keygen import command
from cosim.link.session.keys import create_key_file, read_key_file
from tests.support.link.support import KEY

posix = pytest.mark.skipif(os.name != "posix", reason="file modes are a POSIX matter")


def test_keygen_writes_a_file_that_can_be_read_back_and_differs_each_time(tmp_path) -> None:
    runner = CliRunner()
    for name in ("one", "two"):
        result = runner.invoke(command, [str(tmp_path / name)], catch_exceptions=False)
        assert result.exit_code == 0
        assert (tmp_path / name).read_text().split()[1] not in result.output
    one, two = (read_key_file(tmp_path / name).derive("x") for name in ("one", "two"))
    assert one != two


@posix
def test_the_file_is_for_its_owner_alone_whatever_the_umask(tmp_path) -> None:
    old = os.umask(0)
    try:
        create_key_file(tmp_path / "key")
    finally:
        os.umask(old)
    assert stat.S_IMODE((tmp_path / "key").stat().st_mode) == 0o600


@posix
@pytest.mark.parametrize("mode", [0o640, 0o604, 0o620, 0o602, 0o644])
def test_a_file_that_others_may_open_is_refused(tmp_path, mode: int) -> None:
    create_key_file(tmp_path / "key")
    (tmp_path / "key").chmod(mode)
    with pytest.raises(InputError, match=r"can be read or written by others.*chmod 600"):
        read_key_file(tmp_path / "key")


def test_a_key_is_never_overwritten(tmp_path) -> None:
    create_key_file(tmp_path / "key")
    with pytest.raises(InputError, match="never overwritten"):
        create_key_file(tmp_path / "key")


@pytest.mark.parametrize("text", ["", "cohaptic-key-1", "cohaptic-key-1 AAAA", "secret", "\xff"])
def test_what_is_no_key_is_refused_without_showing_it(tmp_path, text: str) -> None:
    path = tmp_path / "key"
    path.write_text(text, encoding="latin-1")
    path.chmod(0o600)
    with pytest.raises(InputError, match="is not a key") as caught:
        read_key_file(path)
    assert "AAAA" not in str(caught.value)


def test_a_missing_file_is_a_sentence(tmp_path) -> None:
    with pytest.raises(InputError, match="cannot be read: No such file"):
        read_key_file(tmp_path / "absent")


@posix
def test_a_pipe_in_place_of_a_key_is_refused_and_not_waited_for(tmp_path) -> None:
    os.mkfifo(tmp_path / "key", 0o600)
    with pytest.raises(InputError, match="is not a regular file"):
        read_key_file(tmp_path / "key")


@pytest.mark.skipif(os.name != "posix" or os.geteuid() != 0, reason="to give files away")
def test_a_file_of_somebody_else_is_refused(tmp_path) -> None:
    create_key_file(tmp_path / "key")
    os.chown(tmp_path / "key", 12345, -1)
    with pytest.raises(InputError, match="belongs to somebody else"):
        read_key_file(tmp_path / "key")


def test_a_key_that_everybody_knows_is_no_key(tmp_path) -> None:
    path = tmp_path / "key"
    path.write_text("cohaptic-key-1 " + base64.b64encode(bytes(32)).decode())
    path.chmod(0o600)
    with pytest.raises(InputError, match="all zero, which everybody knows"):
        read_key_file(path)


@given(purpose=st.text(max_size=8), context=st.binary(max_size=8), other=st.binary(max_size=8))
def test_other_purposes_and_contexts_give_unrelated_keys(purpose, context, other) -> None:
    base = KEY.derive("noise", context=b"ab")
    assert KEY.derive("noise", context=b"ab") == base
    assert purpose == "noise" or KEY.derive(purpose, context=b"ab") != base
    assert other == context or KEY.derive("x", context=context) != KEY.derive("x", context=other)
