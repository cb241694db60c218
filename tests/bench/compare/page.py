"""Puts together the page of compare.sh from what compare_bench measured.

    page.py WORK OUT

WORK holds a JSON report for each volume; OUT becomes README.md, compare.json and two plots for each volume.
"""
import json
import pathlib
import sys

import matplotlib
import matplotlib.pyplot as plt

STYLES = {
    "ours": ("#d62728", "o-"),
    "ours, unsimplified": ("#ff9896", "o--"),
    "flying edges": ("#222222", "*"),
    "flying edges, meshoptimizer": ("#1f77b4", "s-"),
    "flying edges, downsampled": ("#2ca02c", "^-"),
    "OpenVDB": ("#9467bd", "D-"),
}


def count(number):
    return f"{number:,}".replace(",", " ")


def plot(report, path):
    """Bytes and seconds against the largest and the 99 % distance."""
    plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "compare", "font.size": 9})
    figure, axes = plt.subplots(1, 3, figsize=(12, 3.8))
    for ax, x, y in zip(axes, ("largest", "percentile_99", "largest"), ("bytes", "bytes", "seconds")):
        for method, (colour, style) in STYLES.items():
            rows = [row for row in report["rows"] if row["method"] == method and row["triangles"] > 0]
            if rows:
                ax.plot([row["distance"][x] for row in rows], [row[y] for row in rows], style, color=colour, label=method, markersize=4)
        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.set_xlabel({"largest": "largest distance, voxels", "percentile_99": "99 % of distances, voxels"}[x])
        ax.set_title(y)
        ax.grid(True, which="both", alpha=0.2)
    handles, methods = axes[0].get_legend_handles_labels()
    figure.legend(handles, methods, loc="lower center", ncols=len(methods), frameon=False)
    figure.suptitle(f"{report['name']}, isovalue {report['isovalue']}")
    figure.tight_layout(rect=(0, 0.06, 1, 1))
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


def distances(text, between):
    return between.join(f"{text[key]:.3f}" for key in ("largest", "percentile_99", "mean")) if text else ""


def table(report):
    full = report["full_surface"]
    lines = ["| | | seconds | triangles | bytes | largest distance | 99 % | mean | the same to flying edges | "
             "open, non-manifold edges | Euler characteristic | components |", "| --- | --- |" + " ---: |" * 10,
             f"| full surface | | | {count(full['triangles'])} | | 0 | 0 | 0 | | | {full['euler_characteristic']} | "
             f"{full['components']} |"]
    for row in report["rows"]:
        changed = [row["euler_characteristic"] - full["euler_characteristic"], row["components"] - full["components"]]
        text = ["as it is" if change == 0 else f"{change:+d}" for change in changed]
        lines.append(
            f"| {row['method']} | {row['setting']} | {row['seconds']:.2f} | {count(row['triangles'])} | {count(row['bytes'])} | "
            f"{distances(row['distance'], ' | ')} | {distances(row.get('distance_to_flying_edges'), '; ')} | "
            f"{row['open_edges']}, {row['nonmanifold_edges']} | {text[0]} | {text[1]} |")
    return "\n".join(lines) + "\n"


def at_distance(rows, limit, what):
    """The fewest bytes (or seconds, ...) of the rows that stay within a distance."""
    return min((row[what] for row in rows if row["distance"]["largest"] <= limit and row["triangles"] > 0), default=None)


def summary(reports):
    """The smallest mesh within one voxel, and the fastest."""
    methods = list(STYLES)
    text = ""
    for what, form in (("bytes", count), ("seconds", lambda s: f"{s:.2f}")):
        text += (f"The least {what} with no sampled point farther than a voxel (--: not reached):\n\n"
                 f"| | {' | '.join(methods)} |\n| --- |{' ---: |' * len(methods)}\n")
        for report in reports:
            best = {m: at_distance([r for r in report["rows"] if r["method"] == m], 1, what) for m in methods}
            least = min((b for b in best.values() if b is not None), default=None)
            cells = ["--" if best[m] is None else (f"**{form(best[m])}**" if best[m] == least else form(best[m]))
                     for m in methods]
            text += f"| {report['name']} | " + " | ".join(cells) + " |\n"
        text += "\n"
    return text


def page(reports):
    peers = sorted({peer for report in reports for peer in report["peers"]})
    missing = [name for name in ("VTK", "meshoptimizer", "OpenVDB") if not any(peer.startswith(name) for peer in peers)]
    parts = [f"""# Beside what people use instead

Made by `bash tests/bench/compare.sh`; all numbers in [compare.json](compare.json). Peers: {", ".join(peers) or "none"}.
{"NOT THERE: " + ", ".join(missing) + "." if missing else ""}
Seconds are from "isovalue named" to "encoded mesh", {reports[0]["threads"]} threads (meshoptimizer and the peers' Draco use one), the
least of some runs; volumes are open. All meshes are Draco's. Distances are sampled both ways to what marching tetrahedra makes at
full resolution, in voxels; that is *our* full surface, from which that of flying edges differs between samples, however fine: the
their distances to the latter are listed as well. Changes of Euler characteristic and components are to ours; the peers' surfaces join
or part diagonal neighbours otherwise. Open edges at the data's border do not count. Bold is the best: where that is a peer, it is
better at this, and what it does not promise is in the columns of distances and topology.

{summary(reports)}"""]
    for report in reports:
        dims = " x ".join(str(n) for n in report["dims"])
        parts.append(f"## {report['name']}\n\n{dims} samples, isovalue {report['isovalue']}.\n\n"
                     f"![Bytes and seconds against distances]({report['name']}.svg)\n\n{table(report)}")
    return "\n".join(parts)


def main():
    matplotlib.use("svg")
    work, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    out.mkdir(parents=True, exist_ok=True)
    reports = [json.loads(path.read_text()) for path in sorted(work.glob("*.json"))]
    for report in reports:
        plot(report, out / f"{report['name']}.svg")
    (out / "compare.json").write_text(json.dumps(reports, indent=1) + "\n")
    (out / "README.md").write_text(page(reports))


if __name__ == "__main__":
    main()
