"""The page's files, read once, and the headers that every answer carries."""

from __future__ import annotations

from pathlib import Path

PAGE = Path(__file__).with_name("page")
TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
}


def read_assets() -> dict[str, tuple[str, bytes]]:
    """Path in an address -> content type and content; ``/`` is the page."""
    found = {
        f"/{file.relative_to(PAGE).as_posix()}": (TYPES[file.suffix], file.read_bytes())
        for file in sorted(PAGE.rglob("*"))
        if file.suffix in TYPES
    }
    found["/"] = found.pop("/index.html")
    return found


def headers(host: str) -> dict[str, str]:
    """What a browser is told besides: load from here alone, show up in no frame, keep nothing."""
    policy = (
        "default-src 'none'",
        "script-src 'self'",
        "style-src 'self'",
        "img-src 'self' data:",
        f"connect-src 'self' ws://{host}",
        "base-uri 'none'",
        "form-action 'none'",
        "frame-ancestors 'none'",
    )
    return {
        "Content-Security-Policy": "; ".join(policy),
        "X-Content-Type-Options": "nosniff",
        "Referrer-Policy": "no-referrer",
        "Cross-Origin-Opener-Policy": "same-origin",
        "Cross-Origin-Resource-Policy": "same-origin",
        "Cache-Control": "no-store",
        "Connection": "close",
    }
