"""Messages over WebSockets, TCP or TLS, blocking, with a limit on every wait."""

import asyncio
import socket
import ssl
import struct
import threading
from urllib.parse import urlsplit

MAX_MESSAGE_BYTES = 16 * 1024 * 1024


def open_transport(url, ca, insecure, timeout):
    parts = urlsplit(url if "://" in url else "tcp://" + url)
    if parts.scheme not in ("tcp", "tls", "ws", "wss") or not parts.hostname:
        raise ValueError(f'"{url}" is no server address; write ws://HOST:PORT, wss://, tcp:// or tls://.')
    context = None
    if parts.scheme in ("tls", "wss"):
        context = ssl.create_default_context(cafile=ca)
        if insecure:
            context.check_hostname = False
            context.verify_mode = ssl.CERT_NONE
    if parts.scheme in ("tcp", "tls"):
        return FrameTransport(parts, context, timeout)
    return WebSocketTransport(url, parts, context, timeout)


class FrameTransport:
    """A 4-byte little-endian length, then the message."""

    def __init__(self, parts, context, timeout):
        self._socket = socket.create_connection((parts.hostname, parts.port or 7410), timeout)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if context:
            self._socket = context.wrap_socket(self._socket, server_hostname=parts.hostname)

    def send(self, content):
        self._socket.sendall(struct.pack("<I", len(content)) + content)

    def receive(self):
        (size,) = struct.unpack("<I", self._exactly(4))
        if not 0 < size <= MAX_MESSAGE_BYTES:
            raise ConnectionError(f"The server sends a frame of {size} bytes.")
        return self._exactly(size)

    def _exactly(self, size):
        parts = bytearray()
        while len(parts) < size:
            try:
                part = self._socket.recv(min(size - len(parts), 1 << 20))
            except socket.timeout:
                raise ConnectionError("The server was silent for too long; see `timeout`.") from None
            if not part:
                raise ConnectionError("The server hung up.")
            parts += part
        return bytes(parts)

    def close(self):
        self._socket.close()


class WebSocketTransport:
    """Binary messages of the subprotocol multitetra.v1.

    The event loop has a thread of its own, so that this works in notebooks, which run one already.
    """

    def __init__(self, url, parts, context, timeout):
        import websockets

        self._timeout = timeout
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        if parts.path in ("", "/"):
            url = f"{parts.scheme}://{parts.netloc}/v1/stream"

        async def opened():
            return await websockets.connect(
                url,
                ssl=context,
                subprotocols=["multitetra.v1"],
                compression=None,
                max_size=MAX_MESSAGE_BYTES,
                open_timeout=timeout,
            )

        try:
            self._socket = self._run(opened())
        except BaseException:
            self._stop()
            raise
        if self._socket.subprotocol != "multitetra.v1":
            self.close()
            raise ConnectionError(f"{url} does not speak multitetra.v1.")

    def _run(self, work):
        import websockets

        future = asyncio.run_coroutine_threadsafe(asyncio.wait_for(work, self._timeout), self._loop)
        try:
            return future.result()
        except asyncio.TimeoutError:
            raise ConnectionError(f"The server was silent for {self._timeout:g} s.") from None
        except websockets.exceptions.ConnectionClosed as closed:
            raise ConnectionError(f"The server hung up: {closed}.") from None

    def send(self, content):
        self._run(self._socket.send(content))

    def receive(self):
        content = self._run(self._socket.recv())
        if not isinstance(content, bytes):
            raise ConnectionError("A text message came; the conversation is in binary ones.")
        return content

    def close(self):
        try:
            self._run(self._socket.close())
        finally:
            self._stop()

    def _stop(self):
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()
