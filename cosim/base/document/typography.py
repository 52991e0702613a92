"""Characters that a word processor or a web page puts in the place of those that are meant."""

from __future__ import annotations

_ODD = {
    "a curly quote": ("“”„‘’‚«»", "straight quotes or none"),
    "a typographic dash or minus": ("−–—‐‑", "'-'"),
    "an arrow character": ("→⇒➔", "'->'"),
    "a no-break space": ("\u00a0\u202f\u2007\u3000", "a plain space"),
    "a wide colon": ("：", "':'"),
    "a wide comma": ("，", "','"),
    "an invisible character": ("\u200b\u200c\u200d\u2060\ufeff\u00ad", "it without"),
}


def odd_characters(text: str) -> str:
    """What in a refused text is probably a typographic accident; empty if nothing is.

    A sentence that follows an error; begins with a space.
    """
    for what, (characters, instead) in _ODD.items():
        if any(character in text for character in characters):
            return f" There is {what} in it; write {instead}."
    return ""


def comma_in_number(text: str) -> str:
    """What to write for a number with commas in it, as a sentence."""
    whole, point = text.replace(",", ""), text.replace(",", ".")
    decimal = f", or {point} with a decimal point" if point.count(".") == 1 else ""
    return f"a number has no commas: '{text}' is written {whole}{decimal}."
