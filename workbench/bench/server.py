"""The bench's server: Bokeh's, on this machine alone, for whoever has the token that is part of its address."""

import asyncio
import secrets
import socket
import threading
import weakref
import webbrowser
from collections.abc import Callable
from http import HTTPStatus
from typing import Any

from bokeh.application import Application
from bokeh.application.handlers.function import FunctionHandler
from bokeh.document import Document
from bokeh.server.server import BaseServer
from bokeh.server.tornado import BokehTornado
from tornado.httpserver import HTTPServer
from tornado.httputil import HTTPServerRequest
from tornado.ioloop import IOLoop
from tornado.web import RequestHandler
from tornado.websocket import WebSocketHandler

from workbench.errors import UserError

ADDRESS = "127.0.0.1"

TOKEN_BYTES = 24


class _Refused(RequestHandler):
    """Says no, and nothing else."""

    def prepare(self) -> None:
        self.set_status(HTTPStatus.FORBIDDEN)
        self.finish("refused: open the address that workbench bench printed\n")


class _Guarded(BokehTornado):
    """Bokeh's pages, static files and sockets, none of which is found without the token, under another name of this
    machine, or from a page of another origin.
    """

    def __init__(self, *args: Any, token: str, hosts: frozenset[str], **kwargs: Any) -> None:
        self._token, self._hosts = token, hosts
        self._opened: weakref.WeakSet[WebSocketHandler] = weakref.WeakSet()
        super().__init__(*args, prefix=f"/{token}", extra_websocket_origins=sorted(hosts), **kwargs)

    def find_handler(self, request: HTTPServerRequest, **kwargs: Any) -> Any:
        """Tornado asks here for each request, that which opens a socket included."""
        if not self._admits(request):
            return self.get_handler_delegate(request, _Refused)
        return super().find_handler(request, **kwargs)

    def new_connection(self, protocol: Any, socket: Any, *args: Any) -> Any:
        """Bokeh asks here for each socket that was opened."""
        self._opened.add(socket)
        return super().new_connection(protocol, socket, *args)

    def close_sockets(self) -> None:
        """Cut off whoever is still there."""
        for handler in list(self._opened):
            stream = None if handler.ws_connection is None else handler.ws_connection.stream
            if stream is not None:
                stream.close()

    def _admits(self, request: HTTPServerRequest) -> bool:
        first = request.path.lstrip("/").split("/")[0]
        origin = request.headers.get("Origin")
        return (
            secrets.compare_digest(first.encode(), self._token.encode())
            and request.host in self._hosts
            and (origin is None or origin in {f"http://{host}" for host in self._hosts})
        )


class BenchServer:
    """A page for each browser tab that opens `url`: `build` makes it in an empty document."""

    def __init__(self, build: Callable[[Document], None], port: int = 0) -> None:
        """Bind to a port, by default any that is free.

        Raises:
            UserError: the port is taken.
        """
        try:
            self._socket = socket.create_server((ADDRESS, port))
        except OSError as error:
            raise UserError(f"port {port}: {error.strerror}; take another one, or none for any that is free") from None
        self._socket.setblocking(False)
        self.port = int(self._socket.getsockname()[1])
        token = secrets.token_urlsafe(TOKEN_BYTES)
        self.url = f"http://{ADDRESS}:{self.port}/{token}/"
        hosts = frozenset(f"{host}:{self.port}" for host in (ADDRESS, "localhost"))
        tornado = _Guarded({"/": Application(FunctionHandler(build))}, token=token, hosts=hosts)
        self._tornado = tornado
        self._ready = threading.Event()

    def run(self, *, browser: bool = True) -> None:
        """Serve until the terminal, or `stop`, ends it."""
        asyncio.run(self._serve(browser))

    async def _serve(self, browser: bool) -> None:
        loop, http = IOLoop.current(), HTTPServer(self._tornado)
        http.add_socket(self._socket)
        server = BaseServer(loop, self._tornado, http)
        server.start()
        self._ended = asyncio.Event()
        self._loop = loop
        self._ready.set()
        if browser:
            await loop.run_in_executor(None, webbrowser.open, self.url)
        try:
            await self._ended.wait()
        finally:
            server.stop()
            self._tornado.close_sockets()
            await http.close_all_connections()

    def start_beside(self) -> None:
        """Serve in a thread of its own, as long as the program runs or until `stop`."""
        self._thread = threading.Thread(target=self.run, kwargs={"browser": False}, name="bench", daemon=True)
        self._thread.start()
        self._ready.wait()

    def stop(self) -> None:
        """End what `start_beside` began; when this returns, nothing of it is open."""
        self._loop.add_callback(self._ended.set)
        self._thread.join()
