"""Frames into one moving picture: gif, webp (Pillow) or mp4 (PyAV, of the extra ``video``)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from cosim.base.errors import InputError
from cosim.base.system.writing import writing

FORMATS = (".gif", ".webp", ".mp4")
COLOURS = 128
"""Of a gif, the same for all frames: chosen from the frame in the middle."""


def write_film(frames: Callable[[], Iterator[Any]], out: Path, rate: int) -> None:
    """Write frames (Pillow images of one size) one after another.

    Args:
        frames: gives them, each time from the first.
        out: a file that ends in one of ``FORMATS``.
        rate: frames a second.

    Raises:
        InputError: the file cannot be written, or what writes it is not installed.
    """
    with writing(out):
        WRITERS[out.suffix.lower()](frames, out, rate)


def _gif(frames: Callable[[], Iterator[Any]], out: Path, rate: int) -> None:
    """Hundredths of a second are all that the format knows; the error is carried on."""
    every = list(frames())
    palette = every[len(every) // 2].quantize(COLOURS)
    drawn = [frame.quantize(palette=palette, dither=0) for frame in every]
    ends = [round(100 * (number + 1) / rate) for number in range(len(drawn))]
    lengths = [10 * (end - begin) for begin, end in zip([0, *ends], ends, strict=False)]
    drawn[0].save(
        out, save_all=True, append_images=drawn[1:], duration=lengths, loop=0, optimize=False
    )


def _webp(frames: Callable[[], Iterator[Any]], out: Path, rate: int) -> None:
    first, *others = frames()
    first.save(
        out,
        save_all=True,
        append_images=others,
        duration=round(1000 / rate),
        loop=0,
        quality=80,
        method=2,
    )


def _mp4(frames: Callable[[], Iterator[Any]], out: Path, rate: int) -> None:
    try:
        av: Any = import_module("av")
    except ImportError:
        raise InputError(
            "mp4 needs the package av: install cohaptic[video], or write a .webp or a .gif."
        ) from None
    with av.open(str(out), "w") as container:
        stream: Any = None
        for image in frames():
            if stream is None:
                stream = container.add_stream("libx264", rate=rate, options={"crf": "20"})
                stream.width, stream.height = image.size
                stream.pix_fmt = "yuv420p"
            container.mux(stream.encode(av.VideoFrame.from_image(image)))
        if stream is not None:
            container.mux(stream.encode())


WRITERS: Mapping[str, Callable[[Callable[[], Iterator[Any]], Path, int], None]] = {
    ".gif": _gif,
    ".webp": _webp,
    ".mp4": _mp4,
}
