"""The page's own files over HTTP, and who may ask for them."""

from __future__ import annotations

import http
import secrets
import urllib.parse
from importlib import resources

from websockets.datastructures import Headers
from websockets.http11 import Request, Response

_OURS = (
    "index.html",
    "view.css",
    "view.js",
    "common.js",
    "body.js",
    "strips.js",
    "controls.js",
    "story.js",
)
_OF_REPORTS = ("uPlot.iife.min.js", "uPlot.min.css")
_TYPES = {"html": "text/html", "css": "text/css", "js": "text/javascript"}
# Scripts and styles from here only, nothing inline (uPlot sets element styles from its script, which needs no
# exception), no frames around the page, and no connection but to this server.
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


class Doorkeeper:
    """Decides which requests are looked at.

    Another site that is open in the same browser can send requests here, too. It cannot choose their ``Origin`` and
    ``Host``: a name of its own that it lets point here shows in ``Host``, its page in ``Origin``.

    Args:
        address: what the server listens on.
        port: and its port.
        token: wanted in each request where the address is not loopback; None on loopback.
    """

    def __init__(self, address: str, port: int, token: str | None) -> None:
        names = {address, "127.0.0.1", "localhost", "[::1]"}
        self._hosts = {f"{name}:{port}" for name in names} | (names if port == 80 else set())
        self._open = token is not None  # others reach it by names that we do not know
        self._token = token

    def refuses(self, request: Request) -> str | None:
        """Why a request is not answered; None where it is."""
        host, origin = request.headers.get("Host", ""), request.headers.get("Origin")
        if not self._open and host not in self._hosts:
            return f"the host {host!r} is not this server's"
        if origin is not None and origin not in (f"http://{host}", f"https://{host}"):
            return "asked for by a page of another site"
        if self._token is not None:
            given = urllib.parse.parse_qs(urllib.parse.urlsplit(request.path).query).get("token", [""])[0]
            if not secrets.compare_digest(given.encode(), self._token.encode()) and not _is_plain_file(
                request
            ):
                return "the token in the address is missing or wrong"
        return None


def _is_plain_file(request: Request) -> bool:
    """Style and scripts hold no secret; the page asks for them without the token."""
    return urllib.parse.urlsplit(request.path).path.lstrip("/") in (*_OURS[1:], *_OF_REPORTS)


def answer(request: Request) -> Response:
    """One of the page's files."""
    name = urllib.parse.urlsplit(request.path).path.lstrip("/") or "index.html"
    if name in _OURS:
        found = resources.files("snakebot.view").joinpath("page", name)
    elif name in _OF_REPORTS:
        found = resources.files("snakebot.report").joinpath("assets", name)
    else:
        return refusal(http.HTTPStatus.NOT_FOUND, "no such file")
    return _response(http.HTTPStatus.OK, found.read_bytes(), _TYPES[name.rpartition(".")[2]])


def refusal(status: http.HTTPStatus, why: str) -> Response:
    """An answer that is an error, in one line."""
    return _response(status, f"{why}\n".encode(), "text/plain")


def _response(status: http.HTTPStatus, body: bytes, kind: str) -> Response:
    headers = Headers(
        {
            "Content-Type": f"{kind}; charset=utf-8",
            "Content-Length": str(len(body)),
            "Content-Security-Policy": _POLICY,
            "X-Content-Type-Options": "nosniff",
            "Referrer-Policy": "no-referrer",
            "Cache-Control": "no-store",
            "Connection": "close",
        }
    )
    return Response(status.value, status.phrase, headers, body)
