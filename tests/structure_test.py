"""The layers: includes point one way, headers in a folder detail/ stay private to their library, and no name is
defined twice in one namespace: two types of one name in one program share the symbols of their members.

    python3 tests/structure_test.py

Each folder below is a library. It may include the folders that it lists, and all that those may include.
"""
import collections
import pathlib
import re
import sys

PROJECT = pathlib.Path(__file__).resolve().parent.parent
MOST_FILES = 40  # Of a folder: what a reader takes in at once.

# Folder -> the folders that it may include besides itself; their dependencies are included.
LIBRARIES = {
    "common/base": [],
    "common/sandbox": ["common/base"],
    "common/codec": ["common/base"],
    "common/image": ["common/base"],
    "common/mesh": ["common/base"],
    "common/picture": ["common/mesh", "common/image"],
    "common/dataset": ["common/image", "common/mesh"],
    "common/request": ["common/dataset", "common/codec"],
    "common/net": ["common/base"],
    "common/wire": ["common/request", "common/net"],
    "common/json": ["common/wire"],
    "common/cli": ["common/json"],
    "common/python": ["common/mesh"],
    "server/core/framework": ["common/request"],
    "server/core/thresholds": ["server/core/framework"],
    "server/core/errors": ["server/core/thresholds"],
    "server/core/spectrum": ["server/core/errors"],
    "server/core/sampling": ["server/core/spectrum"],
    "server/core/fine_errors": ["server/core/spectrum"],
    "server/core/surface": ["server/core/fine_errors"],
    "server/core/simplification": ["server/core/surface"],
    "server/core/planning": ["server/core/simplification"],
    "server/store": ["common/base"],
    "server/volume/formats": ["common/request", "common/sandbox", "server/store"],
    "server/volume": ["server/core/framework", "server/volume/formats"],
    "server/dataset": ["server/core/spectrum", "server/volume", "server/store"],
    "server/dataset/partitioned": ["server/dataset"],
    "server/extraction": ["server/dataset", "server/core/planning", "server/core/sampling", "common/wire"],
    "server/certify": ["server/dataset", "server/core/surface", "common/wire", "common/cli"],
    "server/stream": ["server/extraction"],
    "server/operations": ["common/net"],
    "server/service": ["server/stream", "server/operations", "common/json"],
    "server/tilesets": ["server/dataset", "common/wire"],
    "server/session": ["server/service"],
    "server/conversation": ["server/session"],
    "server/transport": ["server/conversation"],
    "server/http": ["server/transport", "common/image"],
    "server/routes": ["server/http", "server/tilesets", "common/json", "common/picture"],
    "server/gateway": ["server/session"],
    "server/programs": ["server/gateway", "server/routes", "server/certify", "server/dataset/partitioned"],
    "server/python": ["server/service", "server/certify", "server/dataset/partitioned", "common/python"],
    "client/library": ["common/wire", "common/cli", "common/sandbox"],
    "client": ["client/library"],
    "client/commands": ["client", "common/picture"],
    "client/load": ["client/commands"],
    "client/python": ["client/library", "common/python"],
}

# Third-party headers that public headers must not include, except in these folders.
THIRD_PARTY = {
    r"boost/": ["common/net", "server/http"],
    r"CLI/": [],
    r"draco/": [],
    r"gdcm|hdf5|libaec\.h|expat\.h|tiff|png\.h|blosc\.h|zstd\.h|lz4\.h|bzlib\.h|zlib\.h|curl/": [],
    r"google/protobuf|\.pb\.h": ["common/wire"],
    r"spdlog/": [],
    r"cairo|pango": [],
    r"openssl/": [],
    r"nlohmann/json\.hpp": ["common/base"],
}


def library_of(path):
    folder = str(path.parent)
    while folder not in LIBRARIES and "/" in folder:
        folder = folder.rsplit("/", 1)[0]
    return folder if folder in LIBRARIES else None


def reachable(library):
    found = {library}
    for dependency in LIBRARIES[library]:
        found |= reachable(dependency)
    return found


def is_private(header):
    return "detail" in header.parts


def crowded_folders():
    counts = collections.Counter(file.relative_to(PROJECT).parent for file in sources())
    return {folder: count for folder, count in sorted(counts.items()) if count > MOST_FILES}


def sources():
    for folder in ("common", "server", "client"):
        for file in sorted(PROJECT.glob(f"{folder}/**/*.[ch]pp")):
            if "node_modules" not in file.parts:
                yield file


def defined_types(text):
    """The types and aliases at the top of named namespaces, with what an alias stands for."""
    namespaces = []
    for line in text.splitlines():
        if opened := re.match(r"(?:inline )?namespace(?: ([\w:]+))? \{", line):
            namespaces.append(opened[1])
        elif line.startswith("}  // namespace") and namespaces:
            namespaces.pop()
        elif None in namespaces:
            continue  # Private to its file.
        elif found := re.match(r"(?:class|struct|union|enum(?: class)?) (\w+)(?: final)?(?: : [^:].*)? \{", line):
            yield "::".join(namespaces), found[1], None
        elif found := re.match(r"using (\w+) = (.*)", line):
            yield "::".join(namespaces), found[1], found[2]


def names_defined_twice():
    definitions = collections.defaultdict(dict)  # Name -> what it stands for -> the first file.
    for file in sources():
        path = file.relative_to(PROJECT)
        for namespace, name, stands_for in defined_types(file.read_text()):
            if path.suffix == ".cpp" and stands_for is not None:
                continue  # An alias has no symbol, and no other file sees this one.
            definitions[f"{namespace}::{name}"].setdefault(stands_for or str(path), path)
    return {name: list(found.values()) for name, found in sorted(definitions.items()) if len(found) > 1}


def errors():
    for name, files in names_defined_twice().items():
        yield f"{files[1]}: {name} is also in {files[0]}."
    for folder, count in crowded_folders().items():
        yield f"{folder}: {count} files; a folder has at most {MOST_FILES}."
    for file in sources():
        path = file.relative_to(PROJECT)
        library = library_of(path)
        if library is None:
            yield f"{path}: its folder is not among the libraries of tests/structure_test.py."
            continue
        text = file.read_text()
        for header in re.findall(r'#include "([^"]+)"', text):
            target = pathlib.Path(header)
            if target.suffix != ".hpp":
                continue
            other = library_of(target)
            if other is None or other not in reachable(library):
                yield f"{path}: {library} may not include {header}."
            elif other != library and is_private(target):
                yield f"{path}: {header} is private to {other}."
        if path.suffix == ".hpp" and not is_private(path):
            for header in re.findall(r"#include [<\"]([^>\"]+)[>\"]", text):
                for pattern, owners in THIRD_PARTY.items():
                    if re.match(pattern, header) and library not in owners:
                        yield f"{path}: a public header shows {header}."


def main():
    wrong = list(errors())
    for line in wrong:
        print(line)
    print(f"{len(wrong)} errors in the structure")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
