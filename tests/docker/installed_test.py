"""`cmake --install`, and what the archive adds: programs find their viewer and their libraries, licences and a bill are there.

    python3 tests/docker/installed_test.py BUILD
"""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

PROJECT = pathlib.Path(__file__).resolve().parent.parent.parent


def run(*command, **options):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, **options)
    assert done.returncode == 0, f"{command} ends with {done.returncode}: {done.stdout}{done.stderr}"
    return done.stdout


def main():
    build = pathlib.Path(sys.argv[1])
    if shutil.which("patchelf") is None or shutil.which("dpkg-query") is None:
        print("NOT TESTED: the archive needs patchelf and dpkg.")
        return 77
    with tempfile.TemporaryDirectory() as folder:
        prefix = pathlib.Path(folder) / "multitetra"
        run("cmake", "--install", build, "--prefix", prefix)
        for program in ("multitetra", "multitetra-client", "multitetra-gateway", "multitetra-load", "multitetra-server"):
            assert run(prefix / "bin" / program, "--version").strip(), program
            assert (prefix / "share/bash-completion/completions" / program).is_file(), program
        assert not (prefix / "etc").exists() and not (prefix / "lib").exists(), "files of the Debian package are installed"

        run(sys.executable, PROJECT / "docker/contents.py", "bundle", PROJECT, prefix)
        libraries = {file.name for file in (prefix / "lib").iterdir()}
        assert any(name.startswith("libtiff.so") for name in libraries), libraries
        assert not any(name.startswith(("libc.so", "libm.so", "ld-linux")) for name in libraries), libraries
        # The programs take these libraries and no others, wherever the folder is moved to.
        moved = prefix.rename(prefix.with_name("moved"))
        for name in ("multitetra-server", "multitetra-client"):
            loaded = [line.split()[2] for line in run("ldd", moved / "bin" / name).splitlines() if "=> /" in line]
            others = [path for path in loaded if not path.startswith(str(moved)) and pathlib.Path(path).name in libraries]
            assert not others, others

        bill = json.loads((moved / "share/doc/multitetra/sbom.cdx.json").read_text())
        assert bill["bomFormat"] == "CycloneDX" and bill["specVersion"] == "1.5"
        named = {component["name"]: component for component in bill["components"]}
        for name in ("libtiff6", "libdraco-dev"):
            assert named[name]["version"] and named[name]["purl"].startswith("pkg:deb/debian/"), named.get(name)
        if (moved / "share/multitetra/viewer/THIRD_PARTY.txt").exists():
            assert named["three"]["licenses"] == [{"license": {"name": "MIT"}}], named.get("three")
        licences = {file.stem for file in (moved / "share/doc/multitetra/licences").iterdir()}
        assert "multitetra" in licences and "libtiff6" in licences, licences

        environment = dict(os.environ, XDG_CACHE_HOME=folder)
        volume = moved / "share/multitetra/demo/visible_female_head.nrrd"
        run(moved / "bin/multitetra-server", "prepare", volume, "-o", pathlib.Path(folder) / "head.mtd", env=environment)
    return 0


if __name__ == "__main__":
    sys.exit(main())
