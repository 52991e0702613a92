"""Did-you-mean for every name a user can misspell."""

from __future__ import annotations

from collections.abc import Iterable


def did_you_mean(word: str, names: Iterable[str], *, listed: int = 8) -> str:
    """A sentence that follows an error: the nearest name, or the few there are to choose from.

    Empty where there is nothing to suggest. Begins with a space.
    """
    known = sorted(set(names) - {word})
    if not known:
        return ""
    near = nearest(word, known, 0.6)
    if near:
        return f" Did you mean {near}?"
    if len(known) <= listed:
        return f" There is {known[0]}." if len(known) == 1 else f" There are {_list(known)}."
    return ""


def nearest(word: str, names: Iterable[str], alike: float) -> str:
    """The name most like ``word``, letter case aside; empty if none is ``alike`` (0 to 1)."""
    from difflib import get_close_matches

    folded = {name.casefold(): name for name in names}
    near = get_close_matches(word.casefold(), folded, n=1, cutoff=alike)
    return folded[near[0]] if near else ""


def _list(names: list[str]) -> str:
    return f"{', '.join(names[:-1])} and {names[-1]}"


def index_hint(path: str) -> str:
    """A sentence for a path that counts its elements from 0; empty for others."""
    import re

    if not re.search(r"\[(.*,)?0(,.*)?\]$", path):
        return ""
    from_one = re.sub(r"\d+(?=[,\]][^\[]*$)", lambda index: str(int(index.group()) + 1), path)
    return f" Indices begin at 1: write {from_one}."
