"""Makes a wheel of the package that a build has put together.

    python3 client/python/wheel.py build/release [FOLDER]      -> multitetra-0.2.0-cp311-cp311-manylinux_2_36_x86_64.whl

The C++ client and the engine are inside, and, where the build has it, the server with its viewer and demo volume: `multitetra view FILE` is a command
of the wheel. The libraries of both are inside as well, with their licences and a bill of materials, so the wheel runs on every Linux
with the C library of the build machine or a later one, for the Python of the build (-DPython_EXECUTABLE=...).
"""
import base64
import hashlib
import pathlib
import platform
import re
import shutil
import sys
import tempfile
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
PROJECT = HERE.parent.parent
sys.path.insert(0, str(PROJECT / "docker"))
import contents  # noqa: E402

REQUIRES = ["numpy"]
BEGINNING = (1980, 1, 1, 0, 0, 0)  # Fixed, so that the same build gives the same wheel.


def version():
    return re.search(r"project\(multitetra VERSION (\S+)", (PROJECT / "CMakeLists.txt").read_text())[1]


def put_together(build, package):
    """Copies the Python package, and the programs with what they find beside themselves, to the folder `package`."""
    shutil.copytree(build / "python" / "multitetra", package, ignore=shutil.ignore_patterns("__pycache__"))
    programs = package / "programs_of_build"
    server = build / "bin" / "multitetra-server"
    modules = sorted(package.glob("_*.so"))
    linked = list(modules)
    if server.exists():
        (programs / "bin").mkdir(parents=True)
        linked.append(shutil.copy2(server, programs / "bin"))
        shutil.copytree(build / "share", programs / "share", ignore=shutil.ignore_patterns("*.sources", "jupyter"))
    contents.bundle(PROJECT, programs, linked)
    for module in modules:
        contents.find_libraries_in(module, "programs_of_build/lib")
    for program in linked[len(modules):]:
        contents.find_libraries_in(program, "../lib")


def files_of(folder, place):
    for file in sorted(folder.rglob("*")):
        if file.is_file():
            yield f"{place}/{file.relative_to(folder)}", file.read_bytes()


ENTRY_POINTS = """[console_scripts]
multitetra = multitetra.programs:main

[napari.manifest]
multitetra = multitetra:napari.yaml
"""


def record_line(name, data):
    digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    return f"{name},sha256={digest},{len(data)}\n"


def main():
    build = pathlib.Path(sys.argv[1])
    package = build / "python" / "multitetra"
    module = next(package.glob("_client.cpython-*.so"), None)
    if module is None:
        sys.exit(f"There is no client in {package}: build the target multitetra_python first.")
    folder = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else pathlib.Path(".")
    folder.mkdir(parents=True, exist_ok=True)
    python = "cp" + module.name.split("-")[1]  # From _client.cpython-311-x86_64-linux-gnu.so
    c_library = "_".join(platform.libc_ver()[1].split(".")[:2])
    tag = f"{python}-{python}-manylinux_{c_library}_{platform.machine()}"
    info = f"multitetra-{version()}.dist-info"
    with tempfile.TemporaryDirectory() as folder_of_files:
        put_together(build, pathlib.Path(folder_of_files) / "multitetra")
        files = dict(files_of(pathlib.Path(folder_of_files) / "multitetra", "multitetra"))
    # The viewer's part of JupyterLab, where it looks for it.
    files |= files_of(build / "share" / "jupyter", f"multitetra-{version()}.data/data/share/jupyter")
    files[f"{info}/METADATA"] = "".join([
        "Metadata-Version: 2.1\n", "Name: multitetra\n", f"Version: {version()}\n",
        "Summary: Crack-free isosurfaces with a certified error, of arrays, files and remote volumes\n", "License: Apache-2.0\n",
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
