"""Serves a folder on a free port, with ranges; below /s3/volumes/ only to requests signed as S3 wants it, below /whole/
without ranges; below /lies/KIND/N/ with a lie to the first N requests of each path:

    401  403  503  401-blocks  403-blocks (of objects whose names are numbers)  truncated  wrong-bytes  wrong-range  lost (the connection ends)  stalled (nothing comes)

Below /moved/ everything is redirected to the path behind it, below /redirect/HOST/ to that host; below /private/ only a user
"reader" with the password "a secret" may read; below /headers/ every object is the text of the request's headers.

    python3 serve_folder.py FOLDER

Prints its address and its process.
"""
import base64
import collections
import hashlib
import hmac
import http.server
import os
import pathlib
import re
import sys
import time

folder = pathlib.Path(sys.argv[1]).resolve()
BUCKET = "/s3/volumes/"
WHOLE = "/whole/"
LIES = re.compile(r"/lies/([\w-]+)/(\d+)/")
asked = collections.Counter()


def signed(secret, *texts):
    key = secret
    for text in texts:
        key = hmac.new(key, text.encode(), hashlib.sha256).digest()
    return key


def is_signed(request):
    """Whether the signature (version 4) is that of the key "a secret", computed anew."""
    match = re.fullmatch(r"AWS4-HMAC-SHA256 Credential=reader/(\d+)/([^/]+)/s3/aws4_request, "
                         r"SignedHeaders=([^,]+), Signature=(\w+)", request.headers.get("Authorization", ""))
    if not match:
        return False
    day, region, names, signature = match.groups()
    headers = "".join(f"{name}:{request.headers[name].strip()}\n" for name in names.split(";"))
    payload = request.headers.get("x-amz-content-sha256") or hashlib.sha256(b"").hexdigest()
    canonical = "\n".join(["GET", request.path, "", headers, names, payload])
    text = "\n".join(["AWS4-HMAC-SHA256", request.headers["x-amz-date"], f"{day}/{region}/s3/aws4_request",
                      hashlib.sha256(canonical.encode()).hexdigest()])
    key = signed(b"AWS4a secret", day, region, "s3", "aws4_request")
    return hmac.compare_digest(signature, hmac.new(key, text.encode(), hashlib.sha256).hexdigest())


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    wbufsize = 1 << 16  # Head and body in one packet.

    def answer(self, status, body=b"", content_range=None):
        if self.kind == "wrong-bytes" and body:
            body = body[:-1] + bytes([body[-1] ^ 1])
        self.send_response(status)
        if content_range:
            self.send_header("Content-Range", content_range)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        if self.kind == "truncated":
            body = body[:len(body) // 2]
            self.close_connection = True
        self.wfile.write(body)

    def lie(self, kind):
        """Whether that is the whole answer."""
        if kind.endswith("-blocks") and not self.path.rsplit("/", 1)[1].isdigit():
            return False
        if kind[:3] in ("401", "403", "503"):
            self.send_response(int(kind[:3]))
            self.send_header("Retry-After", "0")
            self.send_header("Content-Length", "0")
            self.end_headers()
        elif kind == "lost":
            self.close_connection = True
        elif kind == "stalled":
            time.sleep(30)
            self.close_connection = True
        else:
            return False
        return True

    def do_GET(self):
        path = self.path
        self.kind = None
        if lies := LIES.match(path):
            asked[path] += 1
            path = path[lies.end() - 1:]
            if asked[self.path] <= int(lies[2]):
                self.kind = lies[1]
                if self.lie(self.kind):
                    return
        if path.startswith("/moved/") or path.startswith("/redirect/"):
            to = path[len("/moved"):] if path.startswith("/moved/") else "http://" + path[len("/redirect/"):]
            self.send_response(302)
            self.send_header("Location", to)
            self.send_header("Content-Length", "0")
            return self.end_headers()
        if path.startswith("/headers/"):
            return self.answer(200, str(self.headers).encode())
        if path.startswith("/private/"):
            if self.headers.get("Authorization") != "Basic " + base64.b64encode(b"reader:a secret").decode():
                return self.answer(401)
            path = path[len("/private"):]
        if path.startswith(BUCKET):
            if not is_signed(self):
                return self.answer(403)
            path = path[len(BUCKET):]
        serves_ranges = not path.startswith(WHOLE)
        file = (folder / path.removeprefix(WHOLE).lstrip("/")).resolve()
        if folder not in file.parents or not file.is_file():
            return self.answer(404)
        data = file.read_bytes()
        span = re.fullmatch(r"bytes=(\d*)-(\d*)", self.headers.get("Range", ""))
        if not span or not serves_ranges:
            return self.answer(200, data)
        first, last = span.groups()
        begin = int(first) if first else max(0, len(data) - int(last))
        end = min(len(data), int(last) + 1) if first else len(data)
        if self.kind == "wrong-range":
            begin, end = begin // 2, begin // 2 + end - begin
        self.answer(206, data[begin:end], f"bytes {begin}-{end - 1}/{len(data)}")

    def log_message(self, *arguments):
        pass


server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
print(f"http://127.0.0.1:{server.server_address[1]} {os.getpid()}", flush=True)
server.serve_forever()
