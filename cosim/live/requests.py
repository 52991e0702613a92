"""What the server answers to plain requests: the page's own files, and refusals."""

from __future__ import annotations

from collections.abc import Sequence
from http import HTTPStatus

from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.http11 import Request, Response
from websockets.typing import Subprotocol

from cosim.live import assets
from cosim.live.access import FOXGLOVE, PROTOCOL, SOCKET, Access
from cosim.live.foxglove.protocol import chosen_of

MOST_VIEWERS = 16


class PageRequests:
    """Answers what is no socket, and refuses whom neither belongs to.

    ``foxglove``: viewers that speak Foxglove's protocol are let in, too.
    """

    def __init__(self, *, foxglove: bool) -> None:
        self._files, self._foxglove = assets.read_assets(), foxglove

    def answer(self, request: Request, access: Access, viewers: int) -> Response | None:
        """The answer, where ``viewers`` look on already; ``None`` lets a socket be opened."""
        method = str(getattr(request, "method", "GET"))
        refusal = access.refusal(method, request.path, request.headers)
        if refusal is not None:
            return _answer(refusal.status, "text/plain; charset=utf-8", refusal.sentence.encode())
        host = request.headers["Host"]
        if request.path == SOCKET or (self._foxglove and is_foxglove(request)):
            if viewers < MOST_VIEWERS:
                return None
            text = f"{MOST_VIEWERS} pages look on already; close one of them."
            return _answer(HTTPStatus.SERVICE_UNAVAILABLE, "text/plain", text.encode())
        found = self._files.get(request.path)
        if found is None:
            return _answer(HTTPStatus.NOT_FOUND, "text/plain", b"There is nothing of that name.")
        return _answer(HTTPStatus.OK, *found, **assets.headers(host))


def is_foxglove(request: Request | None) -> bool:
    """Whether a request is a Foxglove viewer's."""
    return request is not None and request.path.startswith(FOXGLOVE)


def subprotocol(connection: ServerConnection, offered: Sequence[Subprotocol]) -> Subprotocol:
    """What the page asked for, where the token beside it is no protocol; or one of Foxglove's.

    Raises:
        NegotiationError: a viewer speaks none of those.
    """
    return chosen_of(offered) if is_foxglove(connection.request) else Subprotocol(PROTOCOL)


def _answer(status: HTTPStatus, content_type: str, body: bytes, **more: str) -> Response:
    headers = Headers({"Content-Type": content_type, "Content-Length": str(len(body)), **more})
    if "Connection" not in headers:
        headers["Connection"] = "close"
    return Response(status.value, status.phrase, headers, body)
