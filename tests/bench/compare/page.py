"""Writes the page of compare.sh from the measurements of compare_bench.

    page.py WORK OUT

WORK holds a JSON report for each volume; OUT becomes README.md, compare.json and two plots for each volume: bytes and seconds by
distance, and seconds until a surface is complete over links of several speeds.
"""
import json
import pathlib
import sys

import matplotlib
import matplotlib.pyplot as plt

STYLES = {
    "ours": ("#d62728", "o-"),
    "ours, embedded": ("#8c564b", "o:"),
    "ours, unsimplified": ("#ff9896", "o--"),
    "ours, samples": ("#ff7f0e", "P-"),
    "flying edges": ("#222222", "*-"),
    "flying edges, meshopt codec": ("#7f7f7f", "X-"),
    "flying edges, meshoptimizer": ("#1f77b4", "s-"),
    "flying edges, meshoptimizer, meshopt codec": ("#17becf", "s--"),
    "flying edges, downsampled": ("#2ca02c", "^-"),
    "OpenVDB": ("#9467bd", "D-"),
}

LINKS = {"1 Mbit/s": 1e6, "10 Mbit/s": 1e7, "100 Mbit/s": 1e8, "1 Gbit/s": 1e9}
ERRORS = (0.1, 0.25, 0.5, 1, 2, 4)  # Voxels, in the table of seconds.
LEAST_DISTANCE = 0.01  # Voxels. Smaller distances are drawn here, because a logarithmic axis has no 0.


def count(number):
    return f"{number:,}".replace(",", " ")


def plot(report, path):
    """Bytes and seconds against the largest and the 99 % distance."""
    plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "compare", "font.size": 9})
    figure, axes = plt.subplots(1, 3, figsize=(12, 3.8))
    for ax, x, y in zip(axes, ("largest", "percentile_99", "largest"), ("bytes", "bytes", "seconds")):
        for method, (color, style) in STYLES.items():
            rows = [row for row in report["rows"] if row["method"] == method and row["triangles"] > 0]
            if rows:
                distances = [max(row["distance"][x], LEAST_DISTANCE) for row in rows]
                ax.plot(distances, [row[y] for row in rows], style, color=color, label=method, markersize=4)
        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.set_xlabel({"largest": "largest distance, voxels", "percentile_99": "99 % of distances, voxels"}[x])
        ax.set_title(y)
        ax.grid(True, which="both", alpha=0.2)
    save(figure, axes[0], report, path)


def save(figure, ax, report, path):
    handles, methods = ax.get_legend_handles_labels()
    figure.legend(handles, methods, loc="lower center", ncols=5, frameon=False)
    figure.suptitle(f"{report['name']}, isovalue {report['isovalue']}")
    figure.tight_layout(rect=(0, 0.11, 1, 1))
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


def stated_error(row):
    """The certified error; without one, the largest measured distance, to our full surface or to that of flying edges, whichever is less."""
    measured = [row[key]["largest"] for key in ("distance", "distance_to_flying_edges") if key in row]
    return row.get("certified", min(measured))


def complete_after(row, bits_per_second):
    """Seconds from the request to the decoded mesh at the client: computing, sending and decoding in sequence."""
    return row["seconds"] + 8 * row["bytes"] / bits_per_second + row["decode_seconds"]


def shortest(rows, error, bits_per_second):
    """The shortest time of the rows within an error; None: there is none."""
    return min((complete_after(row, bits_per_second) for row in rows if row["triangles"] > 0 and stated_error(row) <= error),
               default=None)


def plot_links(report, path):
    """Seconds until a surface with at most a stated error is complete."""
    errors = [0.02 * 2 ** (i / 8) for i in range(65)]  # Up to 5 voxels.
    figure, axes = plt.subplots(1, len(LINKS), figsize=(14, 4.2), sharey=True)
    for ax, (link, bits_per_second) in zip(axes, LINKS.items()):
        for method, (color, style) in STYLES.items():
            rows = [row for row in report["rows"] if row["method"] == method]
            found = [(error, shortest(rows, error, bits_per_second)) for error in errors]
            found = [(error, seconds) for error, seconds in found if seconds is not None]
            if found:
                ax.plot(*zip(*found), style[1:], drawstyle="steps-post", color=color, label=method)
        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.set_xlim(errors[0], errors[-1])
        ax.set_xlabel("error, voxels")
        ax.set_title(link)
        ax.grid(True, which="both", alpha=0.2)
    axes[0].set_ylabel("seconds until complete")
    save(figure, max(axes, key=lambda ax: len(ax.lines)), report, path)


def links_table(report):
    """The shortest time of each method, by link and error."""
    methods = [m for m in STYLES if any(row["method"] == m for row in report["rows"])]
    lines = [f"| link | error | {' | '.join(methods)} |", f"| --- | ---: |{' ---: |' * len(methods)}"]
    for link, bits_per_second in LINKS.items():
        for error in ERRORS:
            best = [shortest([r for r in report["rows"] if r["method"] == m], error, bits_per_second) for m in methods]
            least = min((b for b in best if b is not None), default=None)
            cells = ["--" if b is None else f"**{b:.2f}**" if b == least else f"{b:.2f}" for b in best]
            lines.append(f"| {link} | {error} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def distances(text, between):
    return between.join(f"{text[key]:.3f}" for key in ("largest", "percentile_99", "mean")) if text else ""


def table(report):
    full = report["full_surface"]
    lines = ["| | | seconds | decoding | triangles | bytes | certified | largest distance | 99 % | mean | the same to flying edges | "
             "open, non-manifold edges | Euler characteristic | components |", "| --- | --- |" + " ---: |" * 12,
             f"| full surface | | | | {count(full['triangles'])} | | | 0 | 0 | 0 | | | {full['euler_characteristic']} | "
             f"{full['components']} |"]
    for row in report["rows"]:
        changed = [row["euler_characteristic"] - full["euler_characteristic"], row["components"] - full["components"]]
        text = ["unchanged" if change == 0 else f"{change:+d}" for change in changed]
        lines.append(
            f"| {row['method']} | {row['setting']} | {row['seconds']:.2f} | {row['decode_seconds']:.3f} | {count(row['triangles'])} | "
            f"{count(row['bytes'])} | {format(row['certified'], '.3f') if 'certified' in row else ''} | "
            f"{distances(row['distance'], ' | ')} | {distances(row.get('distance_to_flying_edges'), '; ')} | "
            f"{row['open_edges']}, {row['nonmanifold_edges']} | {text[0]} | {text[1]} |")
    return "\n".join(lines) + "\n"


def at_distance(rows, limit, what):
    """The least `what` (bytes or seconds) of the rows within a distance."""
    return min((row[what] for row in rows if row["distance"]["largest"] <= limit and row["triangles"] > 0), default=None)


def summary(reports):
    """The smallest mesh within one voxel, and the fastest."""
    methods = list(STYLES)
    text = ""
    for what, form in (("bytes", count), ("seconds", lambda s: f"{s:.2f}")):
        text += (f"The least {what} with all sampled distances within one voxel (--: not reached):\n\n"
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
    parts = [f"""# Comparison with other software

Made by `bash tests/bench/compare.sh`; all numbers in [compare.json](compare.json). Peers: {", ".join(peers) or "none"}.
{"NOT INSTALLED: " + ", ".join(missing) + "." if missing else ""}

* **Seconds**: from the request to the encoded mesh, minimum of several runs, volumes open, {reports[0]["threads"]} threads (meshoptimizer
  and the peers' Draco use one). "Decoding" is at the client; ours includes the checks of each tile. Over a link: computing, sending and
  decoding in sequence.
* **Bytes**: of Draco, or of meshoptimizer's codec with zstd ("meshopt codec"); the peers' with 14 bits per coordinate over the box.
  "Ours, samples" are sample shells.
* **Error**: the certified error. Peers certify none: for them, the largest sampled distance to our full surface or to that of flying
  edges, whichever is less. Rounding to 14 bits or to our lattice (sqrt(3) / 32 steps) is added.
* **Distances**: sampled in both directions, in voxels, to the surface of marching tetrahedra at full resolution. The surface of flying
  edges differs from it between samples at any resolution, so distances of the peers to flying edges are listed as well.
* **Topology**: changes of Euler characteristic and components relative to our full surface; peers may connect diagonal neighbors
  differently. Open edges at the border of the data do not count.

Bold is the best value.

{summary(reports)}"""]
    for report in reports:
        dims = " x ".join(str(n) for n in report["dims"])
        parts.append(f"## {report['name']}\n\n{dims} samples, isovalue {report['isovalue']}.\n\n"
                     f"![Bytes and seconds against distances]({report['name']}.svg)\n\n{table(report)}\n"
                     "Seconds until a surface with at most the error is complete at the client, the shortest time of each "
                     "method's settings (--: none):\n\n"
                     f"![Seconds until complete, by link]({report['name']}_links.svg)\n\n{links_table(report)}")
    return "\n".join(parts)


def main():
    matplotlib.use("svg")
    work, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    out.mkdir(parents=True, exist_ok=True)
    reports = [json.loads(path.read_text()) for path in sorted(work.glob("*.json"))]
    for report in reports:
        plot(report, out / f"{report['name']}.svg")
        plot_links(report, out / f"{report['name']}_links.svg")
    (out / "compare.json").write_text(json.dumps(reports, indent=1) + "\n")
    (out / "README.md").write_text(page(reports))


if __name__ == "__main__":
    main()
