"""The survey on a port of this machine."""

import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any

from flask import Flask
from waitress.server import MultiSocketServer, create_server

from emovid.errors import EmovidError, InputError, reason
from emovid.survey.app import MOST_BYTES, create_app
from emovid.survey.open import open_survey

_THREADS = 8  # most requests wait for the disk
_MOST_HEADER = 16 * 1024  # bytes
_CONNECTIONS = 1000  # 200 participants with six connections each come in turns


def serve(
    path: Path, host: str, port: int, *, pilot: bool, https: bool, release: float, started: Callable[[str, int], None]
) -> None:
    """Serve a kit's survey until a signal ends it.

    Args:
        path: of the kit.
        host: address to listen at.
        port: 0 takes a free one.
        pilot: whether answers are a pilot's, which go into a database of their own.
        https: whether a proxy in front speaks TLS with the participants.
        release: seconds without a sign after which a row of the orders is free again.
        started: is told host and port once connections are taken.

    Raises:
        InputError: see `open_survey`.
        EmovidError: if the port cannot be had.
    """
    kit, store = open_survey(path, pilot=pilot, begin=True)
    logging.getLogger("waitress.queue").setLevel(logging.ERROR)  # requests that wait for a thread are no fault
    try:
        server = _server(create_app(kit, store, https=https, release=release), host, port)
        # A name of several addresses, as localhost can be, has a server for each.
        several = isinstance(server, MultiSocketServer)
        started(host, server.effective_listen[0][1] if several else server.effective_port)
        server.run()
        server.close()
    finally:
        store.close()


def _server(app: Flask, host: str, port: int) -> Any:
    """Return waitress's server, which listens already."""
    try:
        return create_server(
            app,
            host=host,
            port=port,
            threads=_THREADS,
            connection_limit=_CONNECTIONS,
            max_request_body_size=MOST_BYTES,
            max_request_header_size=_MOST_HEADER,
            channel_timeout=60,
            asyncore_use_poll=True,  # select() ends the server at the 1024th open file, be it connection or video
            ident="emovid",
            clear_untrusted_proxy_headers=True,
        )
    except OSError as error:
        raise EmovidError(f"--host {host} --port {port}: {reason(error)}") from None
    except ValueError:  # no such name, as waitress says it
        raise InputError(f"--host {host}: not an address of this machine; expected one as in 127.0.0.1") from None
