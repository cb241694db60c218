#!/usr/bin/env python3
"""Breaks the product in thirty places, one at a time, and says which test notices first.

    python3 tests/support/mutations.py [NUMBER...]     in a clean checkout; builds in build/mutations
    python3 tests/support/mutations.py --check         only whether the places are there

A place that no test notices is a promise that nothing holds. Run it before a sweep gets smaller, and after. It takes an hour
or more: the tests of the library come first, then all others up to the first that fails, which need a build of all they touch.
"""

import subprocess
import sys
import time
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]
COPY = PROJECT / "build" / "mutations"

# File, what stands there once, what stands there instead.
MUTATIONS = [
    # ---- the method
    ("server/core/errors/saturated_errors.cpp", "std::max(below.error, rounded_up(own.displacement))", "rounded_up(own.displacement)"),
    ("server/core/errors/saturated_errors.cpp", "is_forbidden ? 1 + exponent_ : flip_below", "is_forbidden ? exponent_ : flip_below"),
    ("server/core/errors/saturated_errors.cpp", "rule_ == TopologyRule::kPaper ? own.flip : own.critical", "own.flip"),
    ("server/core/surface/marching_tetrahedra.cpp", "static_cast<double>(values[i]) > isovalue", "static_cast<double>(values[i]) >= isovalue"),
    ("server/core/surface/marching_tetrahedra.cpp", "kMarchingCases[signs][is_negative ? 1 : 0]", "kMarchingCases[signs][is_negative ? 0 : 1]"),
    ("server/core/spectrum/cell_ranges.cpp", "row[x] > high[x] ? row[x] : high[x]", "high[x]"),
    ("server/core/spectrum/cell_ranges.cpp", "cell_z <= end_z", "cell_z < end_z"),
    ("server/core/spectrum/cell_ranges.cpp", "v % kSpectrumSpacing == 0 ? cell - 1 : cell", "cell"),
    ("server/core/thresholds/threshold_map.cpp", "info.margin + info.dims[axis] - 1 + border", "info.margin + info.dims[axis] - 2 + border"),
    ("server/core/thresholds/threshold_map.cpp", "request.unit == ErrorUnit::kVoxel ? voxel_length(info) : 1.0", "1.0"),
    # ---- simplification
    ("server/core/simplification/detail/first_stage.cpp", "if (a_triangle_turns_over() || merges_boundaries(mesh_, ring_)) return false;", "if (a_triangle_turns_over()) return false;"),
    ("server/core/simplification/detail/allowed_distance.cpp", "least_near(box_of(positions), largest_, largest_) == largest_", "true"),
    # ---- meshes
    ("common/mesh/merged_tiles.cpp", "(p.x == box.high.x ? 2U : 0U)", "0U"),
    ("common/mesh/mesh_checks.cpp", "return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];", "return t[0] == t[1] || t[1] == t[2];"),
    ("common/mesh/mesh_checks.cpp", "std::min(a1, b1) >= high1 - inset", "std::min(a1, b1) >= high1 - inset - 1"),
    # ---- codecs
    ("common/codec/shell_decoder.cpp", "is_positive ? below_ + 1 + magnitude : below_ - magnitude", "is_positive ? below_ + magnitude : below_ - magnitude"),
    ("common/codec/shell_decoder.cpp", "is_whole && coder.is_used_up() &&", "is_whole &&"),
    # ---- streams
    ("server/stream/stream_plan.cpp", "is > 0 ? is / was_expected : 1.0", "is > 0 ? was_expected / is : 1.0"),
    ("server/core/planning/refinement_plan.cpp", "shells.triangles <= limits_.shell_triangles", "true"),
    ("server/core/planning/refinement_plan.cpp", "(1 << info.grid_exponent) / finest >= kMinStepsPerSide", "true"),
    ("server/extraction/budgeted_surface.cpp", "triangles < simplification.max_triangles() - 2", "triangles < simplification.max_triangles() + 2"),
    ("server/extraction/budgeted_surface.cpp", "bound *= (1 + 1e-12) / (", "bound *= 0.5 / ("),
    # ---- rights
    ("server/service/client_access.cpp", "!is_for_surfaces_only() && may_see(dataset) && ", "may_see(dataset) && "),
    ("server/service/client_access.cpp", "is_for_surfaces_only() && !(rights_.surfaces_only() && rights_.colors())", "false"),
    ("server/service/client_access.cpp", "if (regions <= limits.max_regions) return {};", "return {};"),
    # ---- the client's checks
    ("client/library/assembler.cpp", "mesh.triangles.size() == promised.triangles &&", "true &&"),
    ("client/library/stream_validator.cpp", "if (begin.step != steps_ended_) {", "if (begin.step < steps_ended_) {"),
    ("client/library/stream_validator.cpp", "if (tile.index >= step_->tiles.size()) {", "if (tile.index > step_->tiles.size()) {"),
    ("client/library/stream_validator.cpp", "if (bytes != promised.bytes) {", "if (bytes > promised.bytes) {"),
    ("client/library/assembler.cpp", "request.topology_tolerance == 0 || begin.shell) && begin.finest_spacing == 1", "request.topology_tolerance == 0 || begin.shell)"),
]


OWN_TESTS = {
    "server/core": "core_test", "server/stream": "stream_test", "server/extraction": "budgeted_surfaces_test", "server/service": "service_test",
    "common/mesh": "mesh_test", "common/codec": "codec_test", "client/library": "client_test",
}  # fmt: skip


def run(*command: str) -> subprocess.CompletedProcess:
    return subprocess.run(command, cwd=COPY, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)


def build(*target: str) -> bool:
    return run("cmake", "--build", "--preset", "tests", *target).returncode == 0


def first_failure(own_tests: str) -> str:
    """The test that fails first; empty if none does. Builds what it runs."""
    stages = ((own_tests, "-R", f"^{own_tests}$"), ("all", "-LE", "slow"), ("all", "-L", "slow"))  # The slow tests last.
    for target, *which in stages:
        if not build("--target", target):
            return "the compiler"
        # All but the test that the places are there, and that of the format.
        tests = run("ctest", "--test-dir", "build/tests", "-j2", "--stop-on-failure", "--timeout", "400", "-E", "^(Mutations|Format)", *which)
        failed = [line for line in tests.stdout.splitlines() if "***Failed" in line or "***Timeout" in line or "***Exception" in line]
        if failed:
            return failed[0].split("...")[0].strip()
        if tests.returncode:
            return "ctest itself"
    return ""


def missing_places() -> list[str]:
    places = enumerate(MUTATIONS)
    return [f"{number}: {file} does not hold this once: {old}" for number, (file, old, _) in places if (PROJECT / file).read_text().count(old) != 1]


def main(numbers: list[int]) -> int:
    if not COPY.exists():
        subprocess.run(["git", "clone", "-q", PROJECT, COPY], check=True)
    run("git", "fetch", "-q")
    run("git", "reset", "-q", "--hard", "origin/HEAD")
    run("cmake", "--preset", "tests")
    if not build():
        sys.exit("The product does not build as it is.")
    unnoticed = 0
    for number in numbers or range(len(MUTATIONS)):
        file, old, new = MUTATIONS[number]
        path, began = COPY / file, time.monotonic()
        whole = path.read_text()
        path.write_text(whole.replace(old, new))
        noticed = first_failure(OWN_TESTS["/".join(Path(file).parts[:2])])
        path.write_text(whole)
        unnoticed += not noticed
        print(f"{number:2}  {noticed or 'NOT NOTICED':60}  {time.monotonic() - began:5.0f} s  {file}: {old} -> {new}", flush=True)
    return 1 if unnoticed else 0


if __name__ == "__main__":
    if missing := missing_places():
        sys.exit("\n".join(missing))
    if sys.argv[1:] != ["--check"]:
        sys.exit(main([int(text) for text in sys.argv[1:]]))
