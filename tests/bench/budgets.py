"""How much of a budget is used: every prepared dataset of a folder, its first isovalues, budgets of triangles and of bytes.

    multitetra-server prepare ../shared/data -o prepared        # some minutes
    /usr/bin/python3 tests/bench/budgets.py --programs build/release/bin prepared

Starts a server, fetches each surface without a budget, then with parts of its size as budgets, and prints one table in Markdown:
how much of the budget was used, the error that was reached, the least error whose surface without a budget fits (--least, by
bisection to a twentieth: four to six more fetches a budget), and how many times as long as the surface without a budget it took.
An answer is good when it is within the budget and has at least 0.9 of it (0.7 without simplification), or the request's own error;
or when the server refuses with what would be enough, and that is more than the budget. Ends with 1 when an answer is neither.
"""

import argparse
import dataclasses
import json
import math
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import time

PARTS = (0.5, 0.15, 0.03)
MOST_OF_IT = {"on": 0.9, "off": 0.7}  # With and without simplification.
NEAR_ENOUGH = 1.05  # Precision of a bisected error.
COLUMNS = ("volume, isovalue", "simplify", "budget", "used", "error reached", "least plain error", "reached / least",
           "times as long", "")


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

    def datasets(self):
        listed = subprocess.run([self.client, "list", "--server", self.url, "--json"], capture_output=True, check=True)
        return json.loads(listed.stdout)["datasets"]

    def run(self, command, dataset, isovalue, *options):
        """Returns the printed JSON, or None and the error."""
        done = subprocess.run(
            [self.client, command, "--server", self.url, "--dataset", dataset, f"--isovalue={isovalue!r}", "--json", *options],
            capture_output=True, text=True)
        if done.returncode != 0:
            return None, done.stderr.strip().splitlines()[-1]
        return json.loads(done.stdout), ""

    def fetch(self, dataset, isovalue, *options):
        return self.run("fetch", dataset, isovalue, "--quiet", "-o", self.mesh, *options)


@dataclasses.dataclass
class Case:
    """The result of one budget."""
    surface: str
    simplify: str
    budget: int
    unit: str
    is_good: bool
    refusal: str = ""
    used: float = math.nan  # Fraction of the budget.
    error: float = math.nan  # The error reached.
    least: float = math.nan  # The least error that fits without a budget.
    times: float = math.nan  # Relative to the surface without a budget.

    def row(self):
        def text(number, form):
            return "" if math.isnan(number) else format(number, form)
        ratio = self.error / self.least
        cells = [self.surface, self.simplify, f"{self.budget} {self.unit}", text(self.used, ".2f"), text(self.error, ".3g"),
                 text(self.least, ".3g"), text(ratio, ".2f"), text(self.times, ".1f"),
                 ("" if self.is_good else "**bad** ") + self.refusal]
        return f"| {' | '.join(cells)} |"


def size(report, unit):
    return report["steps"][-1][unit]


def error_of(report):
    final = report["steps"][-1]["parameters"]
    return max(final["error"], final.get("thresholds", {}).get("at_least", 0))


def timed(run):
    start = time.monotonic()
    return run(), time.monotonic() - start


class Surface:
    """One isovalue of a dataset, with or without simplification."""

    def __init__(self, programs, dataset, isovalue, error, simplify):
        self.programs = programs
        self.dataset, self.isovalue, self.error, self.simplify = dataset, isovalue, error, simplify
        self.sizes = {}  # Reports without a budget, by error.
        (self.whole, self.refusal), self.seconds = timed(lambda: self.fetch(error))

    def fetch(self, error, *options):
        return self.programs.fetch(self.dataset, self.isovalue, "--error", repr(error), "--simplify", self.simplify, *options)

    def fits(self, error, budget, unit):
        if error not in self.sizes:
            report, refusal = self.fetch(error)
            if report is None:
                sys.exit(f"{self.dataset} {self.isovalue:g}: {refusal}")
            self.sizes[error] = {unit: size(report, unit) for unit in ("triangles", "bytes")}
        return self.sizes[error][unit] <= budget

    def least_error(self, budget, unit, reached):
        """The least error that fits without a budget, of the request's own and larger ones."""
        too_fine, fits = self.error, max(reached, self.error * NEAR_ENOUGH)
        while not self.fits(fits, budget, unit):
            too_fine, fits = fits, 2 * fits
        while fits / too_fine > NEAR_ENOUGH:
            middle = math.sqrt(too_fine * fits)
            if self.fits(middle, budget, unit):
                fits = middle
            else:
                too_fine = middle
        return fits

    def case(self, part, unit, finds_least):
        budget = max(1, int(part * size(self.whole, unit)))
        (report, refusal), seconds = timed(lambda: self.fetch(self.error, f"--max-{unit}", str(budget)))
        case = Case(surface=f"{self.dataset}, {self.isovalue:g}", simplify=self.simplify, budget=budget, unit=unit, is_good=False)
        if report is None:
            summary = re.search(r"at least (\d+) triangles and (\d+) bytes|at least (\d+) (triangles|bytes)", refusal)
            case.is_good, case.refusal = "too small" in refusal and summary is not None, refusal
            return case
        case.used, case.error, case.times = size(report, unit) / budget, error_of(report), seconds / self.seconds
        case.is_good = case.used <= 1 and (case.used >= MOST_OF_IT[self.simplify] or case.error <= self.error)
        if finds_least:
            case.least = self.least_error(budget, unit, case.error)
        return case


def summary(cases):
    """Medians and ends of what was not refused."""
    for simplify in MOST_OF_IT:
        some = [case for case in cases if case.simplify == simplify and not case.refusal]
        if not some:
            continue
        columns = {"used": [c.used for c in some], "times as long": [c.times for c in some],
                   "reached / least": [c.error / c.least for c in some if not math.isnan(c.least)]}
        summary = [f"{name} {statistics.median(values):.2f} ({min(values):.2f} to {max(values):.2f})"
                for name, values in columns.items() if values]
        print(f"{len(some)} budgets, simplify {simplify}, median (least to most): {', '.join(summary)}")


def surfaces(programs, arguments):
    for info in programs.datasets():
        for isovalue in info["suggested_isovalues"][: arguments.isovalues]:
            for simplify in MOST_OF_IT:
                estimate, refusal = programs.run("estimate", info["name"], isovalue, "--error", repr(arguments.error),
                                                 "--simplify", simplify)
                if estimate is None or estimate["triangles"] > arguments.most_triangles:
                    print(f"{info['name']} {isovalue:g}, simplify {simplify}: passed over {refusal}", file=sys.stderr)
                    continue
                surface = Surface(programs, info["name"], isovalue, arguments.error, simplify)
                if surface.whole is None:
                    print(f"{info['name']} {isovalue:g}: {surface.refusal}", file=sys.stderr)
                    continue
                ratio = estimate["triangles"] / max(1, size(surface.whole, "triangles"))
                print(f"{info['name']} {isovalue:g}, simplify {simplify}: estimated {ratio:.2f} times what came", file=sys.stderr)
                yield surface


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--programs", type=pathlib.Path, required=True)
    parser.add_argument("--isovalues", type=int, default=1, help="of each dataset (default 1)")
    parser.add_argument("--error", type=float, default=0.5)
    parser.add_argument("--most-triangles", type=float, default=3e6, help="larger surfaces are passed over")
    parser.add_argument("--least", action="store_true", help="finds the least error that fits a budget, too")
    parser.add_argument("folder", type=pathlib.Path)
    arguments = parser.parse_args()
    cases = []
    with tempfile.TemporaryDirectory() as work:
        programs = Programs(arguments.programs, sorted(arguments.folder.rglob("*.mtd")), pathlib.Path(work))
        try:
            print(f"| {' | '.join(COLUMNS)} |\n| --- | --- |{' ---: |' * 6} --- |")
            for surface in surfaces(programs, arguments):
                for unit in ("triangles", "bytes"):
                    for part in PARTS:
                        cases.append(surface.case(part, unit, arguments.least))
                        print(cases[-1].row(), flush=True)
        finally:
            programs.server.terminate()
            programs.server.wait()
    print()
    summary(cases)
    bad = sum(not case.is_good for case in cases)
    print(f"{len(cases)} budgets, {bad} of them neither filled nor refused with what is needed")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
