"""A key is made once, kept from others, and never lets two sessions share what it derives."""

from __future__ import annotations

import os
import stat

import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.base.errors import InputError
from cosim.cli.keygen import command
from cosim.link.session.keys import create_key_file, read_key_file, session_keys
from tests.support.link.support import KEY

posix = pytest.mark.skipif(os.name != "posix", reason="file modes are a POSIX matter")


def derived(**changes):
    given_ = {
        "own": "a",
        "peer": "b",
        "own_nonce": b"1" * 32,
        "peer_nonce": b"2" * 32,
        "contract": b"3" * 32,
    }
    keys = session_keys(KEY, **(given_ | changes))
    return {keys.outgoing, keys.incoming}


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


@settings(deadline=None, max_examples=30)
@given(
    change=st.sampled_from(["own", "peer", "own_nonce", "peer_nonce", "contract"]),
    data=st.data(),
)
def test_any_change_of_names_nonces_or_contract_gives_unrelated_keys(change, data) -> None:
    if change in {"own", "peer"}:
        value = data.draw(st.text(min_size=1, max_size=8).filter(lambda s: s not in {"a", "b"}))
    else:
        value = data.draw(st.binary(min_size=32, max_size=32).filter(lambda b: len(set(b)) > 1))
    assert not derived() & derived(**{change: value})
