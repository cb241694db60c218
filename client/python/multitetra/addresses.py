"""One address for everything: of a server's page, or of its conversation."""

from urllib.parse import urlsplit, urlunsplit

_STREAM_PATH = "/v1/stream"


def stream_address(url):
    """The address to connect to: "ws://host:7480" for "http://host:7480/#dataset=head"; other addresses are unchanged."""
    parts = urlsplit(url)
    schemes = {"http": "ws", "https": "wss"}
    if parts.scheme not in schemes:
        return url
    path = parts.path.removesuffix("/").removesuffix(_STREAM_PATH)
    return urlunsplit((schemes[parts.scheme], parts.netloc, path + _STREAM_PATH, "", ""))


def page_address(url):
    """The address of the viewer: "http://host:7480/" for "ws://host:7480/v1/stream". ValueError if there is none."""
    parts = urlsplit(url)
    scheme = {"ws": "http", "wss": "https", "http": "http", "https": "https"}.get(parts.scheme)
    if scheme is None or not parts.netloc:
        raise ValueError(f"'{url}' is not the address of a server's page, such as http://127.0.0.1:7480/.")
    path = parts.path.removesuffix(_STREAM_PATH)
    return urlunsplit((scheme, parts.netloc, path if path.endswith("/") else path + "/", "", ""))
