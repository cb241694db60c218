"""The house: includes point one way, and private headers stay private.

    python3 tests/structure_test.py

Each folder below is a library. It may include what stands on the lines above it, in its own list; who is a
part of another folder's business only is named among the private headers.
"""
import pathlib
import re
import sys

PROJECT = pathlib.Path(__file__).resolve().parent.parent

# Folder -> the folders that it may include besides itself; all that those may include, too.
ROOMS = {
    "common/base": [],
    "common/image": ["common/base"],
    "common/mesh": ["common/base"],
    "common/request": ["common/mesh"],
    "common/net": ["common/base"],
    "common/wire": ["common/request", "common/net"],
    "common/cli": ["common/request"],
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
    "server/dataset/formats": ["common/request", "server/store"],
    "server/dataset": ["server/core/spectrum", "server/dataset/formats"],
    "server/dataset/families": ["server/dataset"],
    "server/dataset/objects": ["server/dataset"],
    "server/dataset/parts": ["server/dataset/objects"],
    "server/extraction": ["server/dataset/objects", "server/core/planning", "server/core/sampling", "common/wire"],
    "server/stream": ["server/extraction"],
    "server/operations": ["common/net"],
    "server/trees": ["server/dataset", "common/wire"],
    "server/session": ["server/stream", "server/operations"],
    "server/transport": ["server/session"],
    "server/http": ["server/transport", "server/trees", "common/cli", "common/image"],
    "server/gateway": ["server/http"],
    "server/programs": ["server/gateway", "server/dataset/families", "server/dataset/parts"],
    "client": ["common/wire", "common/cli"],
    "client/picture": ["common/mesh", "common/image"],
    "client/commands": ["client", "client/picture"],
    "client/load": ["client/commands"],
    "client/python": ["common/wire"],
}

# What only its own folder and its tests include.
PRIVATE = {
    "common/mesh": ["disjoint_sets"],
    "common/net": ["stream_socket"],
    "common/wire": ["glb", "triangle_normals", "vtp_file", "wire_bytes", "wire_checks", "wire_dataset", "wire_request", "wire_samples", "wire_scalars",
                    "wire_vectors"],
    "common/cli": ["threshold_image", "option_words"],
    "server/core/thresholds": ["threshold_bound", "region_set", "region_octree", "threshold_pyramid", "view_threshold"],
    "server/core/spectrum": ["coarse_level", "curve_tiles", "level_wavefront", "own_error_curve", "own_error_rows",
                             "spectrum_column", "error_codes", "spectrum_brick", "error_curve"],
    "server/core/fine_errors": ["fine_cells", "cell_samples", "cell_bits", "mixed_diamonds"],
    "server/core/surface": ["octree_cube_surface", "edge_vertices", "cell_gradient", "cell_values"],
    "server/core/simplification": ["collapsing_mesh", "quadric", "vectors", "collapse_fan", "successive_mapping"],
    "server/dataset": ["image_payload", "nrrd_payload", "plain_payload", "payload_size", "brick_layers", "prepared_sinks",
                       "sample_conversion", "numbered_files", "source_apart"],
    "server/dataset/formats": ["vti_header", "header_bytes", "chunked_slices", "hdf5_object", "imaris_volume"],
    "server/dataset/parts": ["part_files"],
    "server/transport": ["session_admission", "idle_watch"],
    "server/gateway": ["upstream_questions", "forwarded_stream", "rendezvous"],
}
# A folder that needs what is private of another, and why.
ALLOWED = {
    ("server/operations/tls_files.cpp", "common/net/stream_socket.hpp"),  # Fills the context that it wraps.
}

# Third-party headers that public headers do not show, and the folders whose business they are.
THIRD_PARTY = {
    r"boost/": ["common/net", "server/http"],
    r"CLI/": [],
    r"draco/": [],
    r"itk\w*\.h": [],
    r"gdcm|hdf5|expat\.h|blosc\.h|zstd\.h|lz4\.h|bzlib\.h|zlib\.h|curl/": [],
    r"google/protobuf|\.pb\.h": ["common/wire"],
    r"spdlog/": [],
    r"openssl/": [],
    r"nlohmann/json\.hpp": [],
}


def room_of(path):
    folder = str(path.parent)
    while folder not in ROOMS and "/" in folder:
        folder = folder.rsplit("/", 1)[0]
    return folder if folder in ROOMS else None


def reachable(room):
    found = {room}
    for next_room in ROOMS[room]:
        found |= reachable(next_room)
    return found


def complaints():
    for file in sorted(PROJECT.glob("common/**/*.[ch]pp")) + sorted(PROJECT.glob("server/**/*.[ch]pp")) + sorted(
            PROJECT.glob("client/**/*.[ch]pp")):
        path = file.relative_to(PROJECT)
        if "node_modules" in path.parts:
            continue
        room = room_of(path)
        if room is None:
            yield f"{path}: its folder is not among the rooms of tests/structure_test.py."
            continue
        text = file.read_text()
        for header in re.findall(r'#include "([^"]+)"', text):
            target = pathlib.Path(header)
            if target.suffix != ".hpp":
                continue
            other = room_of(target)
            if other is None or other not in reachable(room):
                yield f"{path}: {room} may not include {header}."
            elif other != room and target.stem in PRIVATE.get(other, []) and (str(path), header) not in ALLOWED:
                yield f"{path}: {header} is a private matter of {other}."
        if path.suffix == ".hpp" and path.stem not in PRIVATE.get(room, []):
            for header in re.findall(r"#include [<\"]([^>\"]+)[>\"]", text):
                for pattern, owners in THIRD_PARTY.items():
                    if re.match(pattern, header) and room not in owners:
                        yield f"{path}: a public header shows {header}."


def main():
    wrong = list(complaints())
    for line in wrong:
        print(line)
    print(f"{len(wrong)} complaints about the structure")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
