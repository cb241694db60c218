"""C++ files are formatted by .clang-format, with clang-format 14.

    python3 tests/format_test.py [FILE...]         all files of the repository by default
    python3 tests/format_test.py --fix [FILE...]   formats them
"""
import concurrent.futures
import pathlib
import shutil
import subprocess
import sys

PROJECT = pathlib.Path(__file__).resolve().parent.parent
VERSION = "version 14."  # Others break other lines.


def formatter():
    for name in ("clang-format-14", "clang-format"):
        program = shutil.which(name)
        if program and VERSION in subprocess.run([program, "--version"], capture_output=True, text=True).stdout:
            return program
    return None


def main():
    program = formatter()
    if program is None:
        print("NOT TESTED: clang-format 14 is not installed.")
        return 77
    arguments = sys.argv[1:]
    mode = ["-i"] if "--fix" in arguments else ["--dry-run", "--Werror"]
    files = [file for file in arguments if not file.startswith("--")]
    if not files:
        listed = subprocess.run(["git", "ls-files", "*.cpp", "*.hpp"], cwd=PROJECT, capture_output=True, text=True, check=True)
        files = listed.stdout.split()
    groups = [files[begin : begin + 50] for begin in range(0, len(files), 50)]
    with concurrent.futures.ThreadPoolExecutor(max_workers=2) as pool:
        results = list(pool.map(
            lambda group: subprocess.run([program, *mode, *group], cwd=PROJECT, capture_output=True, text=True), groups))
    sys.stderr.write("".join(result.stderr for result in results))
    if any(result.returncode != 0 for result in results):
        print("Run python3 tests/format_test.py --fix.")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
