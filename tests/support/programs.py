"""Runs whole programs in tests. Failed checks are printed and counted, so that one run shows all failures.

Commands are written as users type them, with short names for the programs of the build: `server` is multitetra-server,
`client` is multitetra-client, and `view` is `multitetra view`. Tests are called with the programs' directory, and
optionally with the names of the groups to run.
"""

import concurrent.futures
import json
import os
import pathlib
import re
import shlex
import signal
import subprocess
import sys
import tempfile
import time
import traceback
import urllib.request

PROGRAMS = pathlib.Path(sys.argv[1]).resolve()
PROJECT = pathlib.Path(__file__).resolve().parent.parent.parent
NAMES = {
    "server": [f"{PROGRAMS}/multitetra-server"],
    "client": [f"{PROGRAMS}/multitetra-client"],
    "view": [f"{PROGRAMS}/multitetra", "view"],
}
started = []
failures = []


def fail(message):
    print(f"FAILED: {message}", file=sys.stderr, flush=True)
    failures.append(message)


def check(holds, message):
    if not holds:
        line = next(frame.lineno for frame in reversed(traceback.extract_stack()) if frame.filename != __file__)
        fail(f"line {line}: {message}")


def words_of(command):
    first, *others = shlex.split(command)
    return NAMES.get(first, [first]) + others


def execute(command, **options):
    return subprocess.run(words_of(command), encoding="utf-8", errors="surrogateescape", stdout=subprocess.PIPE, **options)


def printed(command):
    """Returns all that a command prints, whatever its exit code is."""
    return execute(command, stderr=subprocess.STDOUT).stdout


def run(command):
    """Expects exit code 0, and returns the standard output."""
    done = execute(command, stderr=subprocess.PIPE)
    check(done.returncode == 0, f"exit code {done.returncode} of: {command}\n{done.stdout}{done.stderr}")
    return done.stdout


def report_of(command):
    """Returns what a command prints with --json."""
    return json.loads(run(f"{command} --json"))


def expect_exit(code, words, command):
    """Checks the exit code and that `words` are printed. Returns all that is printed."""
    done = execute(command, stderr=subprocess.STDOUT)
    check(done.returncode == code, f"exit code {done.returncode} instead of {code} of: {command}\n{done.stdout}")
    check(words in done.stdout, f'"{words}" is not printed by: {command}\n{done.stdout}')
    return done.stdout


def expect_info(dataset, *all_words):
    facts = run(f"server info {dataset}")
    for words in all_words:
        check(words in facts, f'"{words}" is not in the facts of {dataset}: {facts}')


def same_bytes(one, other):
    return pathlib.Path(one).read_bytes() == pathlib.Path(other).read_bytes()


def files(*patterns):
    """Returns the sorted names that match."""
    return sorted(str(path) for pattern in patterns for path in pathlib.Path().glob(pattern))


def expect_files(pattern, *names):
    check(files(pattern) == sorted(names), f"{pattern} is {files(pattern)} instead of {names}")


def read_json(file):
    return json.loads(pathlib.Path(file).read_text())


def write_nrrd(file, sizes, samples, kind="uint8", keys=""):
    """Writes a volume. `keys` are further lines of its header, each with its end."""
    pathlib.Path(file).parent.mkdir(parents=True, exist_ok=True)
    head = f"NRRD0004\ntype: {kind}\ndimension: {len(sizes)}\nsizes: {' '.join(map(str, sizes))}\nendian: little\n{keys}"
    pathlib.Path(file).write_bytes(f"{head}encoding: raw\n\n".encode() + samples)


def write_vti(file, side, arrays, keys=""):
    """Writes a VTK image of named arrays. `keys` are further elements before its piece."""
    extent = f"0 {side - 1} " * 3
    parts = "".join(f'<DataArray type="{"Float32" if kind is float else "UInt8"}" Name="{name}" format="ascii">{" ".join(map(str, values))}'
                    "</DataArray>" for name, kind, values in arrays)
    pathlib.Path(file).parent.mkdir(parents=True, exist_ok=True)
    pathlib.Path(file).write_text(f'<VTKFile type="ImageData"><ImageData WholeExtent="{extent}">{keys}<Piece Extent="{extent}"><PointData>'
                                  f"{parts}</PointData></Piece></ImageData></VTKFile>")


def write_zarr(folder, shape, samples, axes=(), scale=None, **more):
    """Writes an OME-Zarr image of bytes. `axes` are those before z, y and x, which are in micrometers."""
    folder = pathlib.Path(folder)
    (folder / "0").mkdir(parents=True)
    axes = [*axes, *({"name": name, "type": "space", "unit": "micrometer"} for name in "zyx")]
    steps = {"type": "scale", "scale": scale or [1] * len(shape)}
    (folder / ".zgroup").write_text('{"zarr_format": 2}')
    (folder / ".zattrs").write_text(json.dumps({"multiscales": [{"version": "0.4", "axes": axes, "datasets": [
        {"path": "0", "coordinateTransformations": [steps]}]}], **more}))
    (folder / "0/.zarray").write_text(json.dumps({"zarr_format": 2, "shape": shape, "chunks": shape, "dtype": "|u1", "order": "C",
                                                  "compressor": None, "filters": None, "fill_value": 0}))
    (folder / "0" / ".".join("0" for _ in shape)).write_bytes(samples)


def get(address, token=None):
    headers = {"Authorization": f"Bearer {token}"} if token else {}
    return urllib.request.urlopen(urllib.request.Request(address, headers=headers), timeout=60).read()


def wait_for(condition, seconds=60):
    """Waits until the condition holds, and returns whether it does."""
    end = time.monotonic() + seconds
    while not (holds := condition()) and time.monotonic() < end:
        time.sleep(0.05)
    return holds


class Started:
    """A program that runs besides the test. It is killed at the end of the group."""

    def __init__(self, command, **environment):
        self.command = command
        self.log = pathlib.Path(f"{len(started)}.log")
        with open(self.log, "w") as log:
            self.process = subprocess.Popen(words_of(command), stdout=log, stderr=log, env={**os.environ, **environment})
        started.append(self.process)

    def printed(self):
        return self.log.read_text()

    def match(self, pattern):
        """Waits until the pattern is printed, and returns its first group."""
        find = lambda: re.search(pattern, self.printed())
        wait_for(lambda: find() or self.process.poll() is not None)
        found = find()
        if not found:
            raise AssertionError(f'"{pattern}" is not printed by: {self.command}\n{self.printed()}')
        return found[1]

    def url(self, scheme):
        return self.match(rf'listening on ({scheme}://[^ "\n]*)')

    def ends_well(self, by=signal.SIGTERM):
        """Sends a signal and expects exit code 0."""
        self.process.send_signal(by)
        try:
            code = self.process.wait(60)
            check(code == 0, f"exit code {code} after {by.name} of: {self.command}\n{self.printed()}")
        except subprocess.TimeoutExpired:
            fail(f"still running after {by.name}: {self.command}")


def run_group(group):
    """Runs a function in a working folder of its own, and returns the number of failures."""
    failures.clear()
    started.clear()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        os.environ["XDG_CACHE_HOME"] = f"{folder}/cache"
        try:
            group()
        except Exception:  # Its other groups go on.
            fail(f"{group.__name__}: {traceback.format_exc()}")
        for process in started:
            process.kill()
            process.wait()
        os.chdir("/")
    return len(failures)


def run_groups(*groups):
    """Runs functions, two at a time, each in a process and a folder of its own. Exits with 1 if any check failed."""
    chosen = [group for group in groups if group.__name__ in sys.argv[2:] or not sys.argv[2:]]
    if not chosen:
        sys.exit(f"There are only the groups {', '.join(group.__name__ for group in groups)}.")
    with concurrent.futures.ProcessPoolExecutor(max_workers=2) as pool:
        failed = sum(pool.map(run_group, chosen))
    sys.exit(f"{failed} failures." if failed else 0)
