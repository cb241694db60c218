"""HTTP clients that send requests and do not read the responses, from several addresses of this machine.

    python3 unread_answers.py HOST:PORT [--token-file FILE] --clients 400 --addresses 4 --seconds 20 PATH...

Each connection requests the next path, reads the first bytes of the response, and nothing more until the time is over.
Prints JSON: the numbers of responses with status 200, and of rejections with 503 or 429.
"""
import argparse
import json
import socket
import time

arguments = argparse.ArgumentParser()
arguments.add_argument("server")
arguments.add_argument("--clients", type=int, default=100)
arguments.add_argument("--addresses", type=int, default=4)
arguments.add_argument("--seconds", type=float, default=10)
arguments.add_argument("--token-file")
arguments.add_argument("paths", nargs="+")
options = arguments.parse_args()

authorization = f"Authorization: Bearer {open(options.token_file).read().strip()}\r\n" if options.token_file else ""
host, port = options.server.rsplit(":", 1)
end = time.monotonic() + options.seconds
clients = []
for number in range(options.clients):
    client = socket.socket()
    client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    client.bind((f"127.0.1.{1 + number % options.addresses}", 0))
    client.connect((host, int(port)))
    path = options.paths[number // options.addresses % len(options.paths)]
    client.sendall(f"GET {path} HTTP/1.1\r\nHost: localhost\r\n{authorization}\r\n".encode())
    clients.append(client)
counts = {"clients": len(clients), "answered": 0, "refused": 0, "other": 0}
for client in clients:
    client.settimeout(max(end - time.monotonic(), 0.1))
    try:
        status = client.recv(12)[9:12]
    except OSError:
        status = b""
    counts["answered" if status == b"200" else "refused" if status in (b"503", b"429") else "other"] += 1
time.sleep(max(end - time.monotonic(), 0))
print(json.dumps(counts))
