"""Makes a wheel of the package that a build has put together.

    python3 client/python/wheel.py build/release [FOLDER]      -> multitetra-0.1.0-cp311-cp311-linux_x86_64.whl

The C++ client is inside, and, where the build has it, the server with its viewer and demo volume: `multitetra view FILE` is a command
of the wheel. Both are linked with Debian's libraries (docker/packages.txt, section [run]), so the wheel is for Debian 12 and systems
like it, and for the Python of the build (-DPython_EXECUTABLE=...).
"""
import base64
import hashlib
import pathlib
import platform
import re
import sys
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
PROJECT = HERE.parent.parent
REQUIRES = ["numpy"]
BEGINNING = (1980, 1, 1, 0, 0, 0)  # Fixed, so that the same build gives the same wheel.


def version():
    return re.search(r"project\(multitetra VERSION (\S+)", (PROJECT / "CMakeLists.txt").read_text())[1]


def files_of(package):
    for file in sorted(package.rglob("*")):
        if file.is_file() and file.suffix != ".pyc":
            yield f"multitetra/{file.relative_to(package)}", file.read_bytes()


ENTRY_POINTS = """[console_scripts]
multitetra = multitetra.programs:main

[napari.manifest]
multitetra = multitetra:napari.yaml
"""


def programs_of(build):
    """The server with what it finds beside itself: ../share."""
    server = build / "bin" / "multitetra-server"
    if not server.exists():
        return
    yield "multitetra/programs_of_build/bin/multitetra-server", server.read_bytes()
    share = build / "share" / "multitetra"
    for file in sorted(share.rglob("*")):
        if file.is_file() and ".sources" not in file.suffixes:
            yield f"multitetra/programs_of_build/share/multitetra/{file.relative_to(share)}", file.read_bytes()


def record_line(name, data):
    digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    return f"{name},sha256={digest},{len(data)}\n"


def main():
    package = pathlib.Path(sys.argv[1]) / "python" / "multitetra"
    module = next(package.glob("_client.cpython-*.so"), None)
    if module is None:
        sys.exit(f"There is no client in {package}: build the target multitetra_python first.")
    folder = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else pathlib.Path(".")
    folder.mkdir(parents=True, exist_ok=True)
    python = "cp" + module.name.split("-")[1]  # From _client.cpython-311-x86_64-linux-gnu.so
    tag = f"{python}-{python}-linux_{platform.machine()}"
    info = f"multitetra-{version()}.dist-info"
    files = dict(files_of(package)) | dict(programs_of(pathlib.Path(sys.argv[1])))
    files[f"{info}/METADATA"] = "".join([
        "Metadata-Version: 2.1\n", "Name: multitetra\n", f"Version: {version()}\n",
        "Summary: Isosurfaces of remote volumes, with a certified error\n", "License: Apache-2.0\n",
        "Requires-Python: >=3.9\n", *(f"Requires-Dist: {name}\n" for name in REQUIRES),
        "Description-Content-Type: text/markdown\n", "\n", (HERE / "README.md").read_text()]).encode()
    files[f"{info}/WHEEL"] = (f"Wheel-Version: 1.0\nGenerator: wheel.py\nRoot-Is-Purelib: false\nTag: {tag}\n").encode()
    files[f"{info}/entry_points.txt"] = ENTRY_POINTS.encode()
    record = f"{info}/RECORD"
    files[record] = ("".join(record_line(*file) for file in files.items()) + f"{record},,\n").encode()
    wheel = folder / f"multitetra-{version()}-{tag}.whl"
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            entry = zipfile.ZipInfo(name, BEGINNING)
            entry.external_attr = (0o100755 if "/bin/" in name else 0o100644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, data)
    print(wheel)


if __name__ == "__main__":
    main()
