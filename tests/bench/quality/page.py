"""Writes the page of quality.sh from the output of its programs.

    page.py OUT

OUT has quality.txt, final_steps.md and shells.txt; it gets README.md, quality.json and certified.svg.
"""
import json
import pathlib
import sys

import matplotlib
import matplotlib.pyplot as plt

CLIENTS = {
    "draco": ("Draco alone", "#1f77b4", "s-"),
    "samples": ("sample shells", "#2ca02c", "^-"),
    "display": ("sample shells, keeps no mesh", "#d62728", "o-"),
    "viewer": ("the same, reports its speed", "#9467bd", "D--"),
}
MOMENTS = {"50 ms": 0.05, "250 ms": 0.25, "1 s": 1.0}


def streams_of(text):
    return [json.loads(line) for line in text.splitlines() if line.startswith("{")]


def name_of(stream):
    return f"{stream['volume']}, {stream['isovalue']:g}"


def chosen(streams, **wanted):
    return [s for s in streams if all(s[key] == value for key, value in wanted.items())]


def unique(values):
    return list(dict.fromkeys(values))


def seconds(number):
    return f"{number:.3f}" if number < 0.0995 else f"{number:.2f}"


def certified(stream):
    if stream["certified_seconds"] is None:
        return "never"
    return f"{seconds(stream['certified_seconds'])} s, {stream['certified_bytes'] / 1024:.0f} KiB"


def markdown(head, rows):
    lines = [f"| {' | '.join(head)} |", f"| {' | '.join(['---'] * len(head))} |"]
    return "\n".join(lines + [f"| {' | '.join(row)} |" for row in rows]) + "\n"


def overview(streams):
    """README.md, "How fast it is"."""
    rows = []
    for volume in unique(map(name_of, streams)):
        some = [s for s in chosen(streams, client="display", error=0.5) if name_of(s) == volume]
        of = {s["link"]: s for s in some}
        first = f"{seconds(some[0]['steps'][0]['seconds'])} s"
        rows.append([volume, first] + [f"{seconds(of[link]['certified_seconds'])} s" if link in of else ""
                                       for link in ("unlimited", "10 Mbit/s", "1 Mbit/s")])
    return markdown(["volume", "first mesh", "certified mesh, loopback", "10 Mbit/s", "1 Mbit/s"], rows)


def shown_at(stream, moment):
    shown = [step for step in stream["steps"] if step["seconds"] <= moment]
    if not shown:
        return f"(first after {1000 * stream['steps'][0]['seconds']:.0f} ms)"
    return shown_text(shown[-1])


def shown_text(step):
    return f"{step['error']:.3g}; {step['p99']:.2g}" if step["p99"] is not None else f"{step['error']:.3g}"


def screen(streams):
    """tests/bench/README.md, "What is on the screen, and when"."""
    rows = []
    for stream in chosen(streams, client="display", error=0.5):
        [kept] = [s for s in chosen(streams, client="samples", error=0.5, link=stream["link"]) if name_of(s) == name_of(stream)]
        last = kept["steps"][-1]
        rows.append([name_of(stream), stream["link"]] + [shown_at(stream, moment) for moment in MOMENTS.values()] +
                    [certified(stream), f"{shown_text(last)} after {seconds(last['seconds'])} s, {last['bytes'] / 1024:.0f} KiB"])
    return markdown(["volume, isovalue", "link", *MOMENTS, "certified", "final step of a client that keeps it"], rows)


def by_client(streams, error):
    """Seconds and received bytes until each client has a certified surface."""
    rows = []
    some = chosen(streams, error=error)
    for volume, link in unique((name_of(s), s["link"]) for s in some):
        of = {s["client"]: s for s in some if name_of(s) == volume and s["link"] == link}
        rows.append([volume, link] + [certified(of[client]) if client in of else "" for client in CLIENTS])
    return markdown(["volume, isovalue", "link", *(words for words, _, _ in CLIENTS.values())], rows)


def plot(streams, path):
    """Seconds until half a voxel is certified, by the link."""
    plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "quality", "font.size": 9})
    volumes = unique(map(name_of, streams))
    figure, axes = plt.subplots(1, len(volumes), figsize=(3.6 * len(volumes), 3.8), sharey=True, squeeze=False)
    for ax, volume in zip(axes[0], volumes):
        for client, (words, color, style) in CLIENTS.items():
            points = sorted((s["megabits_per_second"] or 10_000, s["certified_seconds"])
                            for s in chosen(streams, client=client, error=0.5)
                            if name_of(s) == volume and s["certified_seconds"] is not None)
            if points:
                ax.plot(*zip(*points), style, color=color, label=words, markersize=4)
        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.set_xticks([1, 10, 100, 1000, 10_000], ["1", "10", "100", "1000", "loopback"])
        ax.set_xlabel("Mbit/s")
        ax.set_title(volume)
        ax.grid(True, which="both", alpha=0.2)
    axes[0][0].set_ylabel("seconds until half a voxel is certified")
    figure.legend(*axes[0][0].get_legend_handles_labels(), loc="lower center", ncols=len(CLIENTS), frameon=False)
    figure.tight_layout(rect=(0, 0.06, 1, 1))
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


def page(streams, final_steps, shells):
    return f"""# When surfaces are complete

Made by `bash tests/bench/quality.sh`; all numbers of the streams in [quality.json](quality.json). Isovalues were never requested
before; server and client share two threads. "Certified" is when the first step that is within the error, with the topology of the
full-resolution surface, is complete and checked at the client, and the payload bytes received until then. Errors and distances
are in voxels.

![Seconds until half a voxel is certified, by link and client](certified.svg)

## Overview: error 0.5, a client that draws and keeps no mesh

{overview(streams)}
## On screen: error of the step; measured distance of 99 % of the samples

{screen(streams)}
## Error 0.5, by client

{by_client(streams, 0.5)}
## Error 0, by client

{by_client(streams, 0)}
## Final steps

Seconds until the simplified final step is complete and checked: requested alone, and after the previews of a stream.

{final_steps}
## Sample shells and Draco

Bits and nanoseconds per vertex, one thread; decoding includes marching.

```
{shells}```
"""


def main():
    matplotlib.use("svg")
    out = pathlib.Path(sys.argv[1])
    streams = streams_of((out / "quality.txt").read_text())
    plot(streams, out / "certified.svg")
    (out / "quality.json").write_text(json.dumps(streams, indent=1) + "\n")
    (out / "README.md").write_text(page(streams, (out / "final_steps.md").read_text(), (out / "shells.txt").read_text()))


if __name__ == "__main__":
    main()
