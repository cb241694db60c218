"""Writes the page of paper.sh from its measurements.

    page.py WORK OUT

WORK holds the counts (*.counts.json), pictures and notes; OUT becomes README.md, paper.json, SVG and PNG files.
"""
import json
import pathlib
import platform
import re
import sys

import matplotlib
import matplotlib.pyplot as plt
from PIL import Image

HERE = pathlib.Path(__file__).resolve().parent
TESTS = HERE.parent.parent

# The numbers printed in the paper: tetrahedra and triangles by error in voxels.
PAPER = {
    "box": {0: (1646568, 182376), 1.5: (138042, 68788), 2.5: (115210, 52194), 4: (114556, 51490)},
    "head": {0: (5390896, 255256), 4: (304468, 89300)},
}
PAPER_HALVES = (2891024, 184228)
PAPER_SECONDS = {"subdivision": 90, "fusion": {"box": 19, "head": 55}}  # On an R10000.

VOLUME_ERRORS = ("0", "1", "4")  # For the pictures of volumes.

WAYS = {"paper": "the paper's error and rule", "certified": "certified bound, exact rule",
        "spectrum": "the same from the spectrum"}


def count(number):
    return f"{number:,}".replace(",", " ")


def percent(share):
    return f"{100 * share:.1f} %"


def table(header, rows, align=None):
    align = align or ["---"] + ["---:"] * (len(header) - 1)
    lines = [header, align] + rows
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines) + "\n"


class Measured:
    """The measurements in the folder of paper.sh."""

    def __init__(self, work):
        self.work = work

    def counts(self, name):
        return json.loads((self.work / f"{name}.counts.json").read_text())

    def report(self, name):
        return json.loads((self.work / f"{name}.json").read_text())

    def note(self, name):
        return (self.work / f"{name}.txt").read_text().strip()

    @property
    def portrait(self):
        return self.note("portrait.name")

    @property
    def has_rays(self):
        return (self.work / "rays.json").exists()

    def everything(self):
        counts = {path.name.removesuffix(".counts.json"): json.loads(path.read_text())
                  for path in sorted(self.work.glob("*.counts.json"))}
        return {"paper": {"counts": PAPER, "halves": PAPER_HALVES, "seconds": PAPER_SECONDS}, "ours": counts,
                "volume_rendering": {name: {error: self.report(f"{name}_volume_{error}") for error in VOLUME_ERRORS}
                                     for name in ("head", self.portrait)},
                **({"rays": self.report("rays")} if self.has_rays else {})}


def figure_5(measured, name, title, path):
    """Tetrahedra and triangles by error, with the paper's values as points."""
    curves = measured.counts(name)["curves"]
    plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "paper", "font.size": 9})
    figure, both = plt.subplots(1, 2, figsize=(9, 3.6))
    styles = {"paper": ("#1f77b4", "-", 2), "certified": ("#d62728", "-", 2), "spectrum": ("#222222", ":", 1.4)}
    for axes, what, index in zip(both, ("tetrahedra", "triangles"), (0, 1)):
        for way, label in WAYS.items():
            color, dashes, width = styles[way]
            axes.plot([point["error"] for point in curves[way]], [point[what] for point in curves[way]], color=color,
                      linestyle=dashes, linewidth=width, label=label)
        axes.plot(list(PAPER[name]), [values[index] for values in PAPER[name].values()], "D", color="#2ca02c",
                  markersize=6, label="published in the paper")
        axes.set_yscale("log")
        axes.set_xlabel("error, voxels")
        axes.set_title(what)
        axes.grid(True, which="both", alpha=0.25)
    both[0].legend(fontsize=8)
    figure.suptitle(title)
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


def keep_picture(source, target, crop=None):
    """Saves with 128 colors: a third of the bytes without a visible difference."""
    picture = Image.open(source).convert("RGB")
    if crop:
        picture = picture.crop(crop)
    picture.quantize(128, dither=Image.Dither.NONE).save(target, optimize=True)


def fused(measured, name, counts):
    return percent(1 - counts["tetrahedra"] / measured.counts(name)["all_tetrahedra"])


def table_1(measured):
    times = {name: {time["threads"]: time for time in measured.counts(name)["times"]} for name in ("box", "head")}
    threads = sorted(times["box"])

    def ours(what):
        return [f"{times[name][n][what]:.2f} s" for name in ("box", "head") for n in threads]

    header = ["", "paper (R10000), box", "head"] + [f"ours, {name}, {n} thread{'s' if n > 1 else ''}"
                                                  for name in ("box", "head") for n in threads]
    subdivision, fusion = PAPER_SECONDS["subdivision"], PAPER_SECONDS["fusion"]
    return table(header, [
        ["subdivision: building the framework"] + [f"{subdivision} s"] * 2 + ["none"] * (2 * len(threads)),
        ["fusion: errors of one isovalue", f"{fusion['box']} s", f"{fusion['head']} s"] + ours("exact_errors_seconds"),
        ["errors of all isovalues", "--", "--"] + ours("all_isovalues_seconds"),
    ])


def box_figures(measured):
    rows = []
    for error in ("0", "1.5", "2.5", "4"):
        ours = measured.counts(f"box_{error}")
        tetrahedra, triangles = PAPER["box"][float(error)]
        rows.append([f"![box](box_{error}.png)", error,
                     count(tetrahedra), count(ours["tetrahedra"]), count(triangles), count(ours["triangles"]),
                     fused(measured, "box", ours), open_edges(ours)])
    return rows


def open_edges(ours):
    return f"{ours['open_edges']}, {ours['nonmanifold_edges']}"


def head_figures(measured):
    portrait = measured.portrait
    rows = []
    for key, words, paper in (("0", "0", PAPER["head"][0]), ("4", "4", PAPER["head"][4]),
                              ("halves", "0 left, 4 right", PAPER_HALVES)):
        ours = measured.counts(f"head_{key}")
        shown = measured.counts(f"{portrait}_{key}")
        cells = [f"![head](head_{key}.png)", words, count(paper[0]), count(ours["tetrahedra"]),
                 count(paper[1]), count(ours["triangles"]), fused(measured, "head", ours), open_edges(ours)]
        if portrait != "head":
            cells.append(f"{count(shown['tetrahedra'])}; {count(shown['triangles'])}")
        rows.append(cells)
    return rows


def few_triangles(measured):
    """The isovalues at which our head has at most as many triangles as the paper's."""
    printed = PAPER["head"][0][1]
    sizes = measured.counts("head")["triangles_by_isovalue"]
    few = [size["isovalue"] for size in sizes if size["triangles"] <= printed]
    others = min(size["triangles"] for size in sizes if size["triangles"] > printed)
    if not few:
        return f"of ours the surface of no isovalue has as few triangles: the least has {count(others)}."
    return (f"of {len(sizes)} isovalues over its range, those from {min(few)} to {max(few)} have as few triangles as the "
            f"paper's {count(printed)} at error 0, all others {count(others)} and more.")


def check_claims(claims):
    """Requires that every named test exists."""
    sources = "\n".join(path.read_text() for path in TESTS.rglob("*_test.cpp"))
    named = re.findall(r"`(\w+)\.(\w+)`", claims)
    missing = [f"{suite}.{test}" for suite, test in named
               if not re.search(rf"TEST(_[PF])?\(\s*{suite},\s*{test}\)", sources)]
    if missing or not named:
        sys.exit("claims.md names tests that do not exist: " + ", ".join(missing))


def page(measured):
    head, portrait = measured.counts("head"), measured.portrait
    box0 = measured.counts("box_0")
    head0, head4 = measured.counts("head_0"), measured.counts("head_4")
    halves = measured.counts("head_halves")
    halves_simplified = measured.counts("head_halves_simplified")
    simplified = measured.counts("head_simplified_4")
    volumes = {error: measured.report(f"head_volume_{error}") for error in VOLUME_ERRORS}
    at_8 = {way: head["curves"][way][-1] for way in ("paper", "certified")}
    claims = (HERE / "claims.md").read_text()
    check_claims(claims)
    header = ["picture", "error", "tetrahedra, paper", "ours", "triangles, paper", "ours", "fused",
              "open, non-manifold edges"]
    other = "" if portrait == "head" else (
        f"The paper's head may not be shown here. The pictures and the last column are of {measured.note(f'{portrait}.about')}.\n\n")
    head_header = header if portrait == "head" else header + ["shown: tetrahedra; triangles"]
    names = ["---", "---"]
    same_triangles = 100 * (box0["triangles"] / PAPER["box"][0][1] - 1)
    return f"""# The paper, point by point

Compares Y. Zhou, B. Chen, A. Kaufman, *Multiresolution Tetrahedral Framework for Visualizing Regular Volume Data* (IEEE Visualization 1997)
with this project. All numbers are in [paper.json](paper.json); [claims](../../../tests/bench/paper/claims.md) names code and test of each claim.

    bash tests/bench/paper.sh      # makes this page

* **box**: {measured.note("box.about")}; the paper's own is not public.
* **head**: {measured.note("head.about")}; the paper's isovalue is 55.5, of other values.

Both lie in a grid of {head["grid_points_a_side"]}^3 points, padded with zero, with {count(head["all_tetrahedra"])} tetrahedra in the finest level. Errors are in
voxels. "Ours" uses the paper's error and topology rule unless stated otherwise.

## Table 1: preparing

{table_1(measured)}
The minimum of several runs on {head["processors"]} processors ({platform.machine()}). The framework is implicit; the errors of all isovalues are
[the spectrum](../README.md).

## Figure 5: error against size

![box: tetrahedra and triangles by error](figure_5_box.svg)

![head: tetrahedra and triangles by error](figure_5_head.svg)

The certified bound keeps more than the paper's error where errors are small, the exact topology rule less where they are large: at error {at_8["paper"]["error"]:.0f}
{count(at_8["certified"]["triangles"])} triangles of the head instead of {count(at_8["paper"]["triangles"])}.

## Figures 6 to 11

{table(header, box_figures(measured), names + ["---:"] * 6)}
{other}{table(head_header, head_figures(measured), names + ["---:"] * (len(head_header) - 2))}
*Fused* is the share of the finest level's tetrahedra that are gone. The border between the halves has no crack:

![Fine triangles to the left, coarse ones to the right](head_border.png)

Simplification leaves {count(halves_simplified["triangles"])} of {count(halves["triangles"])} triangles, no open edge, and the same topology.

![The left half at error 0, the right half simplified within error 4](head_halves_simplified.png)

## Where our numbers differ

* **The box at error 0**: {same_triangles:+.1f} % triangles. The paper counts {PAPER["box"][0][0] / box0["tetrahedra"]:.1f} times as many tetrahedra, and
  {PAPER["head"][0][0] / head0["tetrahedra"]:.1f} times as many for the head: ours fuses all that do not change this isosurface.
* **The box at larger errors**: no reading of the paper's guard against flips that we measured (`readings` in [paper.json](paper.json))
  gives its numbers.
* **The head** has other values than the paper's and one slice less: {few_triangles(measured)} At error 4 the tetrahedra agree
  within {abs(100 * (head4["tetrahedra"] / PAPER["head"][4][0] - 1)):.0f} %.

## What the conclusions promise

* **Smooth change between levels in one image**: the two halves above have
  {halves["open_edges"]} open edges, {halves["components"]} components and Euler characteristic {halves["euler_characteristic"]}, as with error 0 ({head0["components"]}, {head0["euler_characteristic"]}) and 4 ({head4["components"]}, {head4["euler_characteristic"]}) everywhere.
* **Meshes simplified by simplifying volumes**: {count(head0["triangles"])} triangles at error 0 become {count(head4["triangles"])} at
  error 4. Simplifying the mesh as well, within the same certified error, leaves {count(simplified["triangles"])}.
* **Direct projection and splatting**: `extract --model` writes the tetrahedra with their values. {volumes["0"]["renderer"]} draws
  them as a volume, by rays, on one thread of a processor{"" if portrait == "head" else " (pictures of the head that may be shown, figures of the paper's)"}:

{table([""] + [f"error {error}" for error in volumes], [
    ["picture"] + [f"![volume](volume_{error}.png)" for error in volumes],
    ["tetrahedra"] + [count(volume["tetrahedra"]) for volume in volumes.values()],
    ["a picture takes"] + [f'{volume["seconds"]:.1f} s' for volume in volumes.values()],
])}
  The error holds at the isosurface only.
{rays(measured)}"""


def rays(measured):
    """The viewer's volume rendering beside VTK's."""
    if not measured.has_rays:
        return ""
    report = measured.report("rays")
    return f"""* **Direct volume projection** of all samples, together with the surfaces: the viewer's rays, and those of {report["renderer"]} with the same
  transfer function and camera. {percent(report["silhouettes_in_common"])} of the two silhouettes' union is in both, and the brightness within has
  the rank correlation {report["rank_correlation"]:.3f}.

| the viewer | {report["renderer"]} |
| --- | --- |
| ![The viewer's volume](rays_viewer.png) | ![VTK's volume](rays_vtk.png) |
"""


def main():
    matplotlib.use("svg")
    work, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    out.mkdir(parents=True, exist_ok=True)
    measured = Measured(work)
    text = page(measured)
    figure_5(measured, "box", "box of 62 x 127 x 67 samples", out / "figure_5_box.svg")
    figure_5(measured, "head", "head, 128 x 128 x 112 samples", out / "figure_5_head.svg")
    for error in ("0", "1.5", "2.5", "4"):
        keep_picture(work / f"box_{error}.png", out / f"box_{error}.png")
    for key in ("0", "4", "halves", "halves_simplified"):
        keep_picture(work / f"portrait_{key}.png", out / f"head_{key}.png")
    middle, above = 1440, 1100
    keep_picture(work / "portrait_border.png", out / "head_border.png", (middle - 360, above, middle + 360, above + 480))
    for error in VOLUME_ERRORS:
        keep_picture(work / f"{measured.portrait}_volume_{error}.png", out / f"volume_{error}.png")
    for renderer in ("viewer", "vtk") if measured.has_rays else ():
        keep_picture(work / f"rays_{renderer}.png", out / f"rays_{renderer}.png")
    (out / "paper.json").write_text(json.dumps(measured.everything(), indent=1) + "\n")
    (out / "README.md").write_text(text)
    size = sum(path.stat().st_size for path in out.iterdir())
    print(f"{size / 1024:.0f} KiB")


if __name__ == "__main__":
    main()
