"""The server of the survey: waitress on a port of this machine."""

import logging
import resource
from collections.abc import Callable
from pathlib import Path

from flask import Flask
from waitress.server import MultiSocketServer, TcpWSGIServer, create_server

from emovid.errors import EmovidError, InputError, reason
from emovid.survey.app import create_app
from emovid.survey.codes import status_token
from emovid.survey.store import open_survey

_THREADS = 8  # most requests wait for the disk
_PATIENCE = 0.5  # seconds that a page waits for the write lock before it asks the browser to send again
_MAX_BODY = 16 * 1024 * 1024  # bytes; the application refuses smaller ones in the study's words
_MAX_HEADER = 16 * 1024  # bytes
_MAX_CONNECTIONS = 4000  # 200 participants with up to six connections each, beside many that are slow or idle
_IDLE = 20  # seconds after which a connection without traffic is closed


def serve(
    path: Path,
    host: str,
    port: int,
    *,
    pilot: bool,
    https: bool,
    release: float,
    kiosk: bool,
    prefix: str,
    started: Callable[[str, int, str], None],
) -> None:
    """Serve a kit's survey until a signal ends it.

    Args:
        path: folder of the kit.
        host: address to listen on.
        port: port to listen on; 0 selects a free one.
        pilot: whether to record pilot answers, in a database of their own.
        https: whether a proxy in front speaks TLS with participants.
        release: seconds without activity after which an unfinished participant's row of the orders is free again.
        kiosk: whether participants share this computer.
        prefix: path of the survey's address, as in /study1; "" for none.
        started: called with host, port and the token of the page for researchers once the server accepts connections.

    Raises:
        InputError: as `open_survey`.
        EmovidError: if the port is not available.
    """
    _allow_open_files()
    kit, store = open_survey(path, pilot=pilot, create=True, patience=_PATIENCE)
    logging.getLogger("waitress.queue").setLevel(logging.ERROR)  # requests that wait for a thread are normal
    try:
        server = _server(
            create_app(kit, store, https=https, release=release, pilot=pilot, kiosk=kiosk, prefix=prefix), host, port
        )
        # A name with several addresses, such as localhost, has one server for each.
        several = isinstance(server, MultiSocketServer)
        found = server.effective_listen[0][1] if several else server.effective_port
        started(host, found, status_token(store.secret))
        server.run()
        server.close()
    finally:
        store.close()


def _allow_open_files() -> None:
    """Raise the limit of open files, so that slow or idle connections do not block others."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = 2 * _MAX_CONNECTIONS if hard == resource.RLIM_INFINITY else min(2 * _MAX_CONNECTIONS, hard)
    if soft != resource.RLIM_INFINITY and soft < wanted:
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))


def _server(app: Flask, host: str, port: int) -> MultiSocketServer | TcpWSGIServer:
    """Return waitress's server, which is listening."""
    try:
        return create_server(
            app,
            host=host,
            port=port,
            threads=_THREADS,
            connection_limit=_MAX_CONNECTIONS,
            max_request_body_size=_MAX_BODY,
            max_request_header_size=_MAX_HEADER,
            channel_timeout=_IDLE,
            cleanup_interval=5,
            asyncore_use_poll=True,  # select() fails at the 1024th open file, be it connection or video
            ident="emovid",
            clear_untrusted_proxy_headers=True,
        )
    except OSError as error:
        raise EmovidError(f"--host {host} --port {port}: {reason(error)}") from None
    except ValueError:  # waitress found no such name
        raise InputError(f"--host {host}: not an address of this machine; expected one such as 127.0.0.1") from None
