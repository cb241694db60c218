#!/usr/bin/env bash
# The wheel that client/python/wheel.py makes of this build works, package and command, when it is unpacked.
# Usage: wheel_test.sh BUILD PYTHON
set -euo pipefail

build=$(cd "$1" && pwd)
python=$2
project=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
"$python" -c 'import numpy' 2>/dev/null && ls "$build"/python/multitetra/_client.*.so >/dev/null 2>&1 || exit 77
source "$project/tests/support/programs.sh"

wheel=$("$python" "$project/client/python/wheel.py" "$build" "$work")
# Installs like pip: checks modes and digests, and makes a script for each entry point.
"$python" - "$wheel" site <<'END'
import base64, configparser, csv, hashlib, io, pathlib, sys, zipfile
archive = zipfile.ZipFile(sys.argv[1])
site = pathlib.Path(sys.argv[2])
for entry in archive.infolist():
    archive.extract(entry, site)
    (site / entry.filename).chmod(entry.external_attr >> 16 & 0o777)
info = next(name.split("/")[0] for name in archive.namelist() if name.endswith(".dist-info/WHEEL"))
recorded = {path: digest for path, digest, _ in csv.reader(io.StringIO(archive.read(f"{info}/RECORD").decode()))}
assert set(recorded) == set(archive.namelist()), "RECORD names other files"
for part in ("package.json", "static/remoteEntry.js"):
    place = f".data/data/share/jupyter/labextensions/multitetra_viewer/{part}"
    assert any(path.endswith(place) for path in recorded), f"JupyterLab's {part} is missing"
for path, digest in recorded.items():
    found = base64.urlsafe_b64encode(hashlib.sha256(archive.read(path)).digest()).rstrip(b"=").decode()
    assert not digest or digest == "sha256=" + found, path
points = configparser.ConfigParser()
points.read_string(archive.read(f"{info}/entry_points.txt").decode())
module, function = points["console_scripts"]["multitetra"].split(":")
(site / "multitetra-command").write_text(f"#!{sys.executable}\nfrom {module} import {function}\n{function}()\n")
(site / "multitetra-command").chmod(0o755)
END
export PYTHONPATH=$work/site XDG_CACHE_HOME=$work/cache

"$python" -c 'import multitetra; assert "/site/" in multitetra.__file__; print(multitetra.__version__)' >version ||
  fail "the package cannot be imported"
[ "$(site/multitetra-command --version | tail -n 1)" != "" ] && site/multitetra-command --version | grep -qF "$(cat version)" ||
  fail "the command's version is not $(cat version): $(site/multitetra-command --version)"

# --- napari finds its plugin, which needs no napari to be imported
"$python" - site <<'END' || fail "the wheel is no plugin of napari"
import configparser, importlib, pathlib, re, sys
sys.modules["napari"] = None
points = configparser.ConfigParser()
points.read(next(pathlib.Path(sys.argv[1]).glob("*.dist-info/entry_points.txt")))
(entry,) = points["napari.manifest"].values()
module, file = entry.split(":")
manifest = (pathlib.Path(importlib.import_module(module).__file__).parent / file).read_text()
names = re.findall(r"^ *python_name: *(\S+)$", manifest, re.M)
assert names, manifest
for name in names:
    module, function = name.split(":")
    assert callable(getattr(importlib.import_module(module), function)), name
END

# --- `multitetra view` finds its demo volume and its viewer
start view site/multitetra-command view --no-browser --quiet
url=
for _ in $(seq 600); do
  url=$(sed -n 's/.*\(http:\/\/[^ #]*\).*/\1/p' view.log | head -n 1)
  token=$(sed -n 's/.*#token=\([^& ]*\).*/\1/p' view.log | head -n 1)
  [ -z "$url" ] || break
  kill -0 "$pid" 2>/dev/null || break
  sleep 0.1
done
[ -n "$url" ] || fail "view prints no address: $(cat view.log)"
curl -s -o page.html "$url" || true
grep -qi '<html' page.html || fail "there is no page at $url"
"$python" - "$url" "$token" <<'END' || fail "the package cannot talk to its own server"
import sys, multitetra
with multitetra.connect(sys.argv[1], token=sys.argv[2]) as server:
    assert len(server.isosurface("visible_female_head", -300.5, error=2).faces) > 1000
END
ends_well view "$pid"
