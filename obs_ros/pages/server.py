"""A small server of one page and its numbers, for this machine unless told otherwise."""

import ipaddress
import json
import socket
import urllib.parse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import BoundedSemaphore, Thread
from typing import Any

from obs_ros.core.texts import one_line, quoted

Answer = Callable[[Mapping[str, Sequence[str]]], Mapping[str, Any]]


@dataclass(frozen=True)
class ServerSettings:
    """Limits by which no caller can use up the process."""

    most: int = 16  # requests at once; more are closed unheard
    patience: float = 10.0  # s for which a connection may be silent
    longest: int = 4000  # characters of a request's path
    fields: int = 40  # of its query


SETTINGS = ServerSettings()
HEADERS = {
    'Cache-Control': 'no-store',
    'Cross-Origin-Opener-Policy': 'same-origin',
    'Cross-Origin-Resource-Policy': 'same-origin',
    'Referrer-Policy': 'no-referrer',
    'X-Content-Type-Options': 'nosniff',
    'X-Frame-Options': 'DENY',
}


class PageServer:
    """Serves `page` at / and what `answer` makes of a query at /data, from threads of its own.

    Only requests that name this machine as people do are answered: a page elsewhere whose name is
    made to lead here (DNS rebinding) is refused. Raises OSError where it cannot listen.
    """

    def __init__(self, host: str, port: int, page: str, policy: str, answer: Answer) -> None:
        self._server = _Server((host, port), host, (page.encode(), policy, answer))
        self._thread = Thread(target=self._server.serve_forever, name='page', daemon=True)
        self._thread.start()

    @property
    def port(self) -> int:
        """The port that it listens on."""
        return int(self._server.server_address[1])

    @property
    def address(self) -> str:
        """Where a browser finds it."""
        host = str(self._server.server_address[0])
        if _is_any(host):
            host = socket.gethostname()
        return f'http://{f"[{host}]" if ":" in host else host}:{self.port}/'

    def close(self) -> None:
        """End it."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()


class _Server(ThreadingHTTPServer):
    daemon_threads = True

    def __init__(
        self, address: tuple[str, int], host: str, served: tuple[bytes, str, Answer]
    ) -> None:
        if ':' in host:
            self.address_family = socket.AF_INET6
        self.host = host
        self.served = served
        self._slots = BoundedSemaphore(SETTINGS.most)
        super().__init__(address, _Handler)

    def server_bind(self) -> None:
        """Bind, without the look-up of this machine's name that the base class waits for."""
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.socket.bind(self.server_address)
        self.server_address = self.socket.getsockname()

    def process_request(self, request: Any, client_address: Any) -> None:
        """Answer in a thread, unless there are as many as there may be."""
        if not self._slots.acquire(blocking=False):
            self.shutdown_request(request)
            return
        try:
            super().process_request(request, client_address)
        except BaseException:  # of a machine that has no more threads
            self._slots.release()
            raise

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """Answer, and make room for another."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._slots.release()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing: a browser that went away is no defect of the node."""

    def is_ours(self, host: str) -> bool:
        """Whether a request's Host names this server."""
        name = host.strip().lower()
        if name.startswith('['):
            name, _, port = name[1:].partition(']')
            port = port.removeprefix(':')
        else:
            name, _, port = name.partition(':')
        if port and port != str(self.server_address[1]):
            return False
        if name in ('localhost', self.host.lower()):
            return True
        try:
            address = ipaddress.ip_address(name)
        except ValueError:
            return _is_any(self.host) and name == socket.gethostname().lower()
        # A number cannot be made to lead elsewhere.
        own = ipaddress.ip_address(str(self.server_address[0]))
        return address.is_loopback or not own.is_loopback


class _Handler(BaseHTTPRequestHandler):
    server: _Server
    timeout = SETTINGS.patience
    server_version, sys_version = 'obs_ros', ''

    def do_GET(self) -> None:
        page, policy, answer = self.server.served
        path, _, query = self.path.partition('?')
        if not self.server.is_ours(self.headers.get('Host', '')):
            self._say(HTTPStatus.MISDIRECTED_REQUEST, 'open the address that the node prints\n')
        elif len(self.path) > SETTINGS.longest:
            self._say(HTTPStatus.REQUEST_URI_TOO_LONG, 'ask for less at once\n')
        elif path == '/':
            self._send(HTTPStatus.OK, 'text/html; charset=utf-8', page, policy)
        elif path == '/data':
            try:
                asked = urllib.parse.parse_qs(query, max_num_fields=SETTINGS.fields)
                found = json.dumps(answer(asked), allow_nan=False, separators=(',', ':'))
            except ValueError as error:
                self._say(HTTPStatus.BAD_REQUEST, f'{one_line(error)}\n')
            except Exception as error:  # the page says so, and asks again
                self._say(HTTPStatus.INTERNAL_SERVER_ERROR, f'{quoted(error)}\n')
            else:
                self._send(HTTPStatus.OK, 'application/json', found.encode())
        else:
            self._say(HTTPStatus.NOT_FOUND, 'there is / and /data\n')

    do_HEAD = do_GET

    def send_error(self, code: int, message: str | None = None, explain: str | None = None) -> None:
        """Say what is wrong with a request in plain text, and nothing of what it held."""
        self._say(HTTPStatus(code), f'{HTTPStatus(code).phrase}\n')

    def log_message(self, format: str, *args: Any) -> None:
        """Log nothing: twice a second is no news."""

    def _say(self, status: HTTPStatus, text: str) -> None:
        self._send(status, 'text/plain; charset=utf-8', text.encode())

    def _send(
        self, status: HTTPStatus, kind: str, body: bytes, policy: str = "default-src 'none'"
    ) -> None:
        self.send_response(status)
        headers = {
            **HEADERS, 'Content-Type': kind, 'Content-Length': str(len(body)),
            'Content-Security-Policy': policy,
        }  # fmt: skip
        for name, value in headers.items():
            self.send_header(name, value)
        self.end_headers()
        if self.command != 'HEAD':
            self.wfile.write(body)


def _is_any(host: str) -> bool:
    return host in ('', '0.0.0.0', '::')
