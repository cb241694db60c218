"""Serves a folder on a free port, with ranges, ETags and conditions; below /s3/volumes/ it is an S3 bucket: only for
requests signed as S3 wants it, with listing and multipart uploads. Elsewhere it behaves badly:

    /whole/          without ranges
    /no-conditions/  ignores If-Match and If-Unmodified-Since
    /no-etag/        has Last-Modified only
    /weak-etag/      has a weak ETag and Last-Modified
    /no-version/     has neither
    /moved/          redirects to the path behind it
    /redirect/HOST/  redirects to that host
    /private/        only for the user "reader" with the password "a secret"
    /headers/        every object is the text of the request's headers
    /lies/KIND/N/    the first N requests of each path get a lie:
                     401  403  503  401-blocks  403-blocks (of objects whose names are numbers)  truncated  long
                     wrong-bytes  wrong-range  lost (the connection ends)  stalled (nothing comes)
                     trickle (ten bytes a second)

Uploads to names with "fails-part2" and "fails-complete" fail there. Listings below endless/ have no last page, those below
repeats/ return to their second page, and one below long-token/ has a token of 5000 bytes.

    python3 serve_folder.py FOLDER

Prints its address and its process.
"""
import base64
import collections
import email.utils
import hashlib
import hmac
import http.server
import os
import pathlib
import re
import shutil
import sys
import time
import urllib.parse
import xml.sax.saxutils

folder = pathlib.Path(sys.argv[1]).resolve()
BUCKET = "/s3/volumes"
LIES = re.compile(r"/lies/([\w-]+)/(\d+)/")
BEHAVIOURS = ("whole", "no-conditions", "no-etag", "weak-etag", "no-version")
KEYS_AN_ANSWER = 10
requests = collections.Counter()
uploads = {}


def signed(secret, *texts):
    key = secret
    for text in texts:
        key = hmac.new(key, text.encode(), hashlib.sha256).digest()
    return key


def is_signed(request, body):
    """Returns whether the signature (version 4) is that of the key "a secret", computed anew."""
    match = re.fullmatch(r"AWS4-HMAC-SHA256 Credential=reader/(\d+)/([^/]+)/s3/aws4_request, "
                         r"SignedHeaders=([^,]+), Signature=(\w+)", request.headers.get("Authorization", ""))
    if not match:
        return False
    day, region, names, signature = match.groups()
    headers = "".join(f"{name}:{request.headers[name].strip()}\n" for name in names.split(";"))
    payload = request.headers.get("x-amz-content-sha256", "")
    if payload != hashlib.sha256(body).hexdigest():
        return False
    path, _, query = request.path.partition("?")
    path = urllib.parse.quote(urllib.parse.unquote(path), safe="/~")  # As buckets do, however it was sent.
    query = "&".join(sorted(query.split("&")))
    canonical = "\n".join([request.command, path, query, headers, names, payload])
    text = "\n".join(["AWS4-HMAC-SHA256", request.headers["x-amz-date"], f"{day}/{region}/s3/aws4_request",
                      hashlib.sha256(canonical.encode()).hexdigest()])
    key = signed(b"AWS4a secret", day, region, "s3", "aws4_request")
    return hmac.compare_digest(signature, hmac.new(key, text.encode(), hashlib.sha256).hexdigest())


def etag_of(data):
    return f'"{hashlib.md5(data).hexdigest()}"'


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    wbufsize = 1 << 16  # Sends head and body in one packet.
    kind = None

    def answer(self, status, body=b"", headers=None):
        if self.kind == "wrong-bytes" and body:
            body = body[:-1] + bytes([body[-1] ^ 1])
        self.send_response(status)
        for name, value in (headers or {}).items():
            self.send_header(name, value)
        self.send_header("Content-Length", str(len(body) + (10 if self.kind == "long" else 0)))
        self.end_headers()
        if self.kind in ("truncated", "long"):
            body = body[:len(body) // 2] if self.kind == "truncated" else body
            self.close_connection = True
        try:
            if self.kind == "trickle":
                for byte in body[:300]:
                    self.wfile.write(bytes([byte]))
                    time.sleep(0.1)
            self.wfile.write(body)
        except ConnectionError:  # The client disconnected.
            self.close_connection = True

    def lie(self, kind):
        """Sends a wrong answer of this kind; returns False if the file must still be sent."""
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
        path = urllib.parse.unquote(self.path.partition("?")[0])
        self.kind = None
        if lies := LIES.match(path):
            requests[path] += 1
            is_lie = requests[path] <= int(lies[2])
            path = path[lies.end() - 1:]
            if is_lie:
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
        behaviour = path.split("/")[1]
        if path.startswith(BUCKET + "/"):
            if not is_signed(self, b""):
                return self.answer(403, b"<Error><Code>SignatureDoesNotMatch</Code></Error>")
            if "?" in self.path:
                return self.list_bucket()
            path = path[len(BUCKET):]
        elif behaviour in BEHAVIOURS:
            path = path[len(behaviour) + 1:]
        file = (folder / path.lstrip("/")).resolve()
        if folder not in file.parents or not file.is_file():
            return self.answer(404)
        self.send_file(file, behaviour)

    def send_file(self, file, behaviour):
        data = file.read_bytes()
        etag = etag_of(data)
        modified = email.utils.formatdate(file.stat().st_mtime, usegmt=True)
        headers = {"ETag": etag, "Last-Modified": modified}
        if behaviour in ("no-etag", "no-version"):
            del headers["ETag"]
        if behaviour == "no-version":
            del headers["Last-Modified"]
        if behaviour == "weak-etag":
            headers["ETag"] = "W/" + etag
        if behaviour != "no-conditions":
            fails = self.headers.get("If-Match", etag) != etag
            if "If-Match" not in self.headers and "If-Unmodified-Since" in self.headers:
                fails = self.headers["If-Unmodified-Since"] != modified
            if fails:
                return self.answer(412)
        span = re.fullmatch(r"bytes=(\d*)-(\d*)", self.headers.get("Range", ""))
        if not span or behaviour == "whole":
            return self.answer(200, data, headers)
        first, last = span.groups()
        begin = int(first) if first else max(0, len(data) - int(last))
        end = min(len(data), int(last) + 1) if first else len(data)
        if begin >= len(data):
            return self.answer(416, b"", headers)
        if self.kind == "wrong-range":
            begin, end = begin + 1, end + 1
        headers["Content-Range"] = f"bytes {begin}-{end - 1}/{len(data)}"
        self.answer(206, data[begin:end], headers)

    # ---- the bucket

    def list_bucket(self):
        query = urllib.parse.parse_qs(self.path.partition("?")[2])
        prefix = query.get("prefix", [""])[0]
        keys = sorted(str(file.relative_to(folder)) for file in folder.rglob("*") if file.is_file())
        keys = [key for key in keys if key.startswith(prefix) and "/" not in key[len(prefix):]]
        begin = int(query.get("continuation-token", ["0"])[0].rstrip("+/="))  # Amazon's have such characters.
        end = begin + KEYS_AN_ANSWER
        if prefix in ("endless/", "repeats/", "long-token/"):
            token = {"endless/": str(end), "repeats/": str(1 + (begin + 1) % 3), "long-token/": "1" * 5000}[prefix]
            return self.answer(200, f"<ListBucketResult><Contents><Key>{prefix}{begin}.mtd</Key></Contents><IsTruncated>true"
                                    f"</IsTruncated><NextContinuationToken>{token}</NextContinuationToken>"
                                    f"</ListBucketResult>".encode())
        xml_keys = "".join(f"<Contents><Key>{xml.sax.saxutils.escape(key)}</Key></Contents>" for key in keys[begin:end])
        more = (f"<IsTruncated>true</IsTruncated><NextContinuationToken>{end}+/=</NextContinuationToken>"
                if end < len(keys) else "<IsTruncated>false</IsTruncated>")
        self.answer(200, f"<ListBucketResult>{xml_keys}{more}</ListBucketResult>".encode())

    def take(self):
        """Body, file and query of a signed request that writes; None after an answer."""
        body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
        self.kind = None
        if not self.path.startswith(BUCKET + "/") or not is_signed(self, body):
            self.answer(403, b"<Error><Code>SignatureDoesNotMatch</Code></Error>")
            return None
        path, _, query = self.path.partition("?")
        return (body, folder / urllib.parse.unquote(path[len(BUCKET) + 1:]),
                urllib.parse.parse_qs(query, keep_blank_values=True))

    def do_POST(self):
        if not (taken := self.take()):
            return None
        body, file, query = taken
        if "uploads" in query:
            name = f"upload-{len(uploads)}+"  # Includes a character that must be encoded.
            uploads[name] = folder / ("." + name)
            uploads[name].mkdir()
            return self.answer(200, f"<X><UploadId>{name}</UploadId></X>".encode())
        parts = uploads[query["uploadId"][0]]
        if "fails-complete" in file.name:
            return self.answer(200, b"<Error><Code>InternalError</Code></Error>")
        there = etag_of(file.read_bytes()) if file.exists() else None
        if (self.headers.get("If-None-Match") == "*" and there) or self.headers.get("If-Match", there) != there:
            return self.answer(412)
        numbers = re.findall(rb"<PartNumber>(\d+)</PartNumber><ETag>([^<]+)</ETag>", body)
        data = b"".join((parts / number.decode()).read_bytes() for number, _ in numbers)
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(data)
        shutil.rmtree(parts)
        return self.answer(200, b"<CompleteMultipartUploadResult/>")

    def do_PUT(self):
        if not (taken := self.take()):
            return None
        body, file, query = taken
        if "fails-part2" in file.name and query["partNumber"] == ["2"]:
            return self.answer(500)
        (uploads[query["uploadId"][0]] / query["partNumber"][0]).write_bytes(body)
        return self.answer(200, b"", {"ETag": etag_of(body)})

    def do_DELETE(self):
        if not (taken := self.take()):
            return None
        _, file, query = taken
        if "uploadId" in query:
            shutil.rmtree(uploads[query["uploadId"][0]])
        else:
            file.unlink(missing_ok=True)
        return self.answer(204)

    def log_message(self, *arguments):
        pass


server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
print(f"http://127.0.0.1:{server.server_address[1]} {os.getpid()}", flush=True)
server.serve_forever()
