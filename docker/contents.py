"""What is inside a package: bundles shared libraries with their licences, and writes bills of materials.

    python3 docker/contents.py bundle PROJECT FOLDER    copies the libraries of the programs in FOLDER/bin to FOLDER/lib
    python3 docker/contents.py bill PROJECT FILE BUILD    writes a bill of materials (CycloneDX 1.5) of the programs in BUILD/bin

Facts about libraries come from dpkg. The C library is never bundled: programs need the one of the build machine or a later one.
"""
import json
import pathlib
import re
import shutil
import subprocess
import sys

# Parts of the C library, which belong to the machine.
C_LIBRARY = re.compile(r"^(ld-linux.*|lib(c|m|dl|pthread|rt|resolv|util|nsl|mvec|anl))\.so")


def output_of(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def is_elf(file):
    with open(file, "rb") as opened:
        return opened.read(4) == b"\x7fELF"


def programs_in(folder):
    """The programs of `folder`, without links to them."""
    return [file for file in sorted(folder.iterdir()) if file.is_file() and not file.is_symlink() and is_elf(file)]


def libraries_of(programs):
    """Shared libraries that `programs` load, by name; without the C library."""
    found = {}
    for program in programs:
        for name, path in re.findall(r"^\s*(\S+) => (/\S+)", output_of("ldd", str(program)), re.M):
            if not C_LIBRARY.match(name):
                found[name] = pathlib.Path(path)
    return dict(sorted(found.items()))


def packages_of(files):
    """The names of the Debian packages that `files` belong to, sorted."""
    names = {file: {str(file), str(file.resolve()), "/usr" + str(file), str(file).removeprefix("/usr")} for file in files}
    known = subprocess.run(["dpkg", "-S", *sorted(set().union(*names.values()))], capture_output=True, text=True).stdout
    package_of = {path: package.split(",")[0] for package, path in re.findall(r"^(.+): (/\S+)$", known, re.M)}
    packages = set()
    for file, paths in names.items():
        found = [package_of[path] for path in sorted(paths) if path in package_of]
        if not found:
            sys.exit(f"No Debian package has {file}.")
        packages.add(found[0])
    return sorted(packages)


def copyright_file(package):
    return pathlib.Path("/usr/share/doc") / package.split(":")[0] / "copyright"


def licences_of(package):
    """Short names of licences, where the package's copyright file is machine-readable."""
    text = copyright_file(package).read_text(errors="replace")
    return sorted(set(re.findall(r"^License: *(\S.*?) *$", text, re.M))) if text.startswith("Format:") else []


def component_of(package):
    name, version, architecture, homepage = output_of(
        "dpkg-query", "-W", "-f", "${Package}\t${Version}\t${Architecture}\t${Homepage}", package).split("\t")
    component = {
        "type": "library", "name": name, "version": version,
        "purl": f"pkg:deb/debian/{name}@{version}?arch={architecture}",
        "licenses": [{"license": {"name": licence}} for licence in licences_of(package)]}
    return component | ({"externalReferences": [{"type": "website", "url": homepage}]} if homepage else {})


def header_packages(project):
    """Packages of the build whose headers are compiled into the programs."""
    listed = output_of("bash", str(project / "docker" / "install.sh"), "--list", "build").split()
    return [name for name in listed if re.match(r"(lib.*|nlohmann-json3|prometheus-cpp|zlib1g)-dev$", name)]


def viewer_components(share):
    """Packages of npm that the viewer in the folder `share` holds."""
    for third_party in share.glob("**/viewer/THIRD_PARTY.txt"):
        for name, version, licence in re.findall(r"^(@?[\w./-]+) (\d\S*) \((.+)\)$", third_party.read_text(), re.M):
            yield {"type": "library", "name": name, "version": version,
                   "purl": f"pkg:npm/{name.replace('@', '%40')}@{version}", "licenses": [{"license": {"name": licence}}]}


def bill_of_materials(project, libraries, share):
    version = re.search(r"project\(multitetra VERSION (\S+)", (project / "CMakeLists.txt").read_text())[1]
    packages = sorted({*packages_of(libraries.values()), *header_packages(project)})
    return {
        "bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
        "metadata": {"component": {"type": "application", "name": "multitetra", "version": version,
                                   "licenses": [{"license": {"id": "Apache-2.0"}}]}},
        "components": [component_of(package) for package in packages] + list(viewer_components(share))}


def write_bill(project, libraries, share, file):
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(bill_of_materials(project, libraries, share), indent=1) + "\n")


def find_libraries_in(program, path):
    """Makes `program` look for its libraries at `path` relative to itself before anywhere else."""
    subprocess.run(["patchelf", "--force-rpath", "--set-rpath", f"$ORIGIN/{path}".rstrip("/"), str(program)], check=True)


def bundle(project, folder, programs):
    """Copies the libraries of `programs` to folder/lib, with licences and a bill of materials in folder/share/doc."""
    libraries = libraries_of(programs)
    lib = folder / "lib"
    licences = folder / "share" / "doc" / "multitetra" / "licences"
    for made in (lib, licences):
        made.mkdir(parents=True, exist_ok=True)
    for name, file in libraries.items():
        shutil.copyfile(file, lib / name)
        (lib / name).chmod(0o755)
        find_libraries_in(lib / name, "")
    for package in packages_of(libraries.values()):
        shutil.copyfile(copyright_file(package), licences / f"{package.split(':')[0]}.txt")
    shutil.copyfile(project / "LICENSE", licences / "multitetra.txt")
    write_bill(project, libraries, folder / "share", licences.parent / "sbom.cdx.json")


def main():
    if len(sys.argv) not in (4, 5) or sys.argv[1] not in ("bundle", "bill"):
        sys.exit(__doc__)
    project, target, *build = map(pathlib.Path, sys.argv[2:])
    if sys.argv[1] == "bill":
        write_bill(project, libraries_of(programs_in(build[0] / "bin")), build[0] / "share", target)
        return
    programs = programs_in(target / "bin")
    bundle(project, target, programs)
    for program in programs:
        find_libraries_in(program, "../lib")


if __name__ == "__main__":
    main()
