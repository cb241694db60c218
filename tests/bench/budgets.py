"""What budgets are filled with: every prepared dataset of a folder, its first isovalues, budgets of triangles and of bytes.

    multitetra-server prepare ../shared/data -o prepared        # some minutes
    /usr/bin/python3 tests/bench/budgets.py --programs build/release/bin prepared

Starts a server, fetches each surface without a budget, then with parts of its size as budgets. An answer is good when it is
within the budget and has at least 0.9 of it (0.7 without simplification), or the request's own error; or when the server refuses
with what would be enough, and that is more than the budget. Estimates, and how many times as long as the surface without a budget
an answer took, stand beside what came. Ends with 1 when an answer is neither.
"""

import argparse
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import time

PARTS = (0.5, 0.15, 0.03)
MOST_OF_IT = {"on": 0.9, "off": 0.7}  # By whether surfaces are simplified.


class Programs:
    def __init__(self, folder, prepared, work):
        self.client = folder / "multitetra-client"
        self.mesh = work / "mesh.ply"
        log = work / "server.log"
        self.server = subprocess.Popen(
            [folder / "multitetra-server", "serve", *prepared, "--tcp", "127.0.0.1:0", "--http", "127.0.0.1:0"],
            stdout=log.open("w"), stderr=subprocess.STDOUT)
        for _ in range(600):
            listening = re.search(r"listening on (tcp://\S+)", log.read_text())
            if listening:
                break
            time.sleep(0.1)
        else:
            sys.exit(f"The server does not listen:\n{log.read_text()}")
        self.url = listening.group(1)

    def ask(self, command, dataset, isovalue, *options):
        """The JSON that it prints, or what it refuses with."""
        done = subprocess.run(
            [self.client, command, "--server", self.url, "--dataset", dataset, f"--isovalue={isovalue!r}", "--json", *options],
            capture_output=True, text=True)
        if done.returncode != 0:
            return None, done.stderr.strip().splitlines()[-1]
        return json.loads(done.stdout), ""

    def fetch(self, dataset, isovalue, *options):
        return self.ask("fetch", dataset, isovalue, "--quiet", "-o", self.mesh, *options)


def size(report, unit):
    return report["steps"][-1][unit]


def timed(ask):
    start = time.monotonic()
    return ask(), time.monotonic() - start


def judged(unit, budget, most_of_it, report, refusal):
    """What became of a budget, and whether that is good."""
    if report is None:
        least = re.search(r"at least (\d+) triangles and (\d+) bytes|at least (\d+) (triangles|bytes)", refusal)
        return f"refused: {refusal}", "too small" in refusal and least is not None
    used = size(report, unit) / budget
    final = report["steps"][-1]["parameters"]
    error = max(final["error"], final.get("thresholds", {}).get("at_least", 0))
    is_own = error <= report["parameters"]["error"]
    told = f"{size(report, unit)} of {budget} ({used:.2f}), error {error:.3g}"
    return told, used <= 1 and (used >= most_of_it or is_own)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--programs", type=pathlib.Path, required=True)
    parser.add_argument("--isovalues", type=int, default=1, help="of each dataset (default 1)")
    parser.add_argument("--error", default="0.5")
    parser.add_argument("--most-triangles", type=float, default=3e6, help="larger surfaces are passed over")
    parser.add_argument("folder", type=pathlib.Path)
    arguments = parser.parse_args()
    prepared = sorted(arguments.folder.rglob("*.mtd"))
    bad = cases = 0
    with tempfile.TemporaryDirectory() as work:
        programs = Programs(arguments.programs, prepared, pathlib.Path(work))
        try:
            listed = subprocess.run([programs.client, "list", "--server", programs.url, "--json"], capture_output=True, check=True)
            for info in json.loads(listed.stdout)["datasets"]:
                for isovalue in info["suggested_isovalues"][: arguments.isovalues]:
                    for simplify in ("on", "off"):
                        options = ("--error", arguments.error, "--simplify", simplify)
                        estimate, _ = programs.ask("estimate", info["name"], isovalue, *options)
                        if estimate is None or estimate["triangles"] > arguments.most_triangles:
                            print(f"{info['name']} {isovalue:g} simplify {simplify}: passed over", flush=True)
                            continue
                        (whole, refusal), alone = timed(lambda: programs.fetch(info["name"], isovalue, *options))
                        if whole is None:
                            print(f"{info['name']} {isovalue:g}: {refusal}")
                            continue
                        for unit in ("triangles", "bytes"):
                            for part in PARTS:
                                budget = max(1, int(part * size(whole, unit)))
                                (came, refusal), seconds = timed(lambda: programs.fetch(
                                    info["name"], isovalue, *options, f"--max-{unit}", str(budget)))
                                told, is_good = judged(unit, budget, MOST_OF_IT[simplify], came, refusal)
                                cases += 1
                                bad += not is_good
                                mark = "  " if is_good else "! "
                                print(f"{mark}{info['name']} {isovalue:g} simplify {simplify} {unit}: {told}, {seconds / alone:.1f} times as long", flush=True)
                        ratio = estimate["triangles"] / max(1, size(whole, "triangles"))
                        print(f"  {info['name']} {isovalue:g} simplify {simplify}: estimated {ratio:.2f} times what came")
        finally:
            programs.server.terminate()
            programs.server.wait()
    print(f"{cases} budgets, {bad} of them neither filled nor refused with what is needed")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
