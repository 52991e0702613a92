"""CAN frames as an adapter's lines of text: ``tIIILDD..`` and a carriage return (LAWICEL)."""

from __future__ import annotations

Frame = tuple[int, bytes]


class Lines:
    """Frames out of a stream of characters."""

    def __init__(self) -> None:
        self.pending = b""

    def frames(self, data: bytes) -> list[Frame]:
        *lines, self.pending = (self.pending + data).split(b"\r")
        found = []
        for line in lines:
            if line[:1] != b"t" or len(line) < 5 or len(line) != 5 + 2 * int(line[4:5], 16):
                continue
            found.append((int(line[1:4], 16), bytes.fromhex(line[5:].decode())))
        return found


def line(identifier: int, data: bytes) -> bytes:
    return f"t{identifier:03X}{len(data)}{data.hex().upper()}\r".encode()
