"""`multitetra view` opens a volume in the browser with one command. Usage: view_test.py DIRECTORY_OF_PROGRAMS [GROUP...]"""

import http.client
import json
import os
import pathlib
import re
import shlex
import shutil
import signal
import sys
import urllib.error
import urllib.parse

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from programs import (PROJECT, Started, check, expect_exit, expect_files, files, get, run, run_groups, same_bytes, wait_for,
                      write_nrrd, write_vti, write_zarr)

for variable in ("DISPLAY", "WAYLAND_DISPLAY", "MULTITETRA_HTTP"):
    os.environ.pop(variable, None)


class Viewed(Started):
    """A running `view`, which is ended by Ctrl-C. `at` is the server's address, `shown` are the settings of its page."""

    def __init__(self, options, **environment):
        super().__init__(f"view --quiet {options}", **environment)
        self.at, _, fragment = self.match(r"(http://\S+)").partition("/#")
        self.token, _, self.shown = fragment.removeprefix("token=").partition("&dataset=")

    def __enter__(self):
        return self

    def __exit__(self, error, *_):
        if error is None:
            self.ends_well(signal.SIGINT)

    def listed(self):
        try:
            return json.loads(get(f"{self.at}/v1/datasets", self.token))["datasets"]
        except urllib.error.URLError:
            return []

    def lists(self, names):
        """Waits until these datasets are listed, as some are prepared while others are served."""
        listed = lambda: " ".join(sorted(dataset["name"] for dataset in self.listed()))
        check(wait_for(lambda: listed() == names), f'datasets "{listed()}" instead of "{names}"')

    def completes(self):
        """Waits until the errors of all datasets are computed."""
        complete = lambda: (listed := self.listed()) and all(dataset["missing"] != "errors" for dataset in listed)
        check(wait_for(complete), f"errors are missing: {self.listed()}")


def view_lists(options, names, shown=None):
    with Viewed(f"--no-browser {options}") as view:
        check(shown in (None, view.shown), f"view {options} shows {view.shown}")
        view.lists(names)


def write_browser():
    """Makes a browser that records the addresses that it opens."""
    pathlib.Path("browser").write_text('#!/bin/sh\necho "$1" >>"$(dirname "$0")/opened"\n')
    pathlib.Path("browser").chmod(0o755)
    return f"{os.getcwd()}/browser"


def write_volume(file, value=lambda x, y: 20 * x + y):
    samples = bytes(value(x, y) for _ in range(12) for y in range(12) for x in range(12))
    write_nrrd(file, (12, 12, 12), samples, keys="spacings: 1 1 1\n")


def other(x, y):
    return 255 - 20 * x - y


def reply(address, method="GET", **headers):
    """Returns the status, where a redirection leads, and the body."""
    parts = urllib.parse.urlsplit(address)
    connection = http.client.HTTPConnection(parts.netloc, timeout=60)
    connection.request(method, parts.path or "/", headers=headers)
    response = connection.getresponse()
    location = response.getheader("Location")
    return response.status, location and urllib.parse.urljoin(address, location), response.read().decode()


def version_of(pattern):
    """Returns what changes when the only file that matches is written again."""
    (file,) = files(pattern)
    return os.stat(file).st_mtime_ns, os.stat(file).st_ino


def without_a_file_the_demo_is_shown():
    view = Viewed("", BROWSER=write_browser())
    check(re.fullmatch(r"visible_female_head&.*isovalue=-300\.5&.*&surfaces=300\.5,.*", view.shown),
          f"the demo does not show bone below the skin: {view.shown}")
    look = view.shown.removeprefix("visible_female_head")
    check(f"look='{look}'" in (PROJECT / "server/demo.sh").read_text(), f"demo.sh shows something else than {look}")
    view.lists("visible_female_head")
    # Everybody can read the words that the browser is started with: they lead to the page once, and hold no token.
    check(wait_for(pathlib.Path("opened").exists), "the browser is not opened")
    opened = pathlib.Path("opened").read_text().strip()
    check(opened.startswith(f"{view.at}/open/") and view.token not in opened, f"the browser opened {opened}")
    check(reply(opened, "HEAD")[0] == 404, "a HEAD request is answered")
    found = reply(opened)[:2]
    check(found == (303, f"{view.at}/#token={view.token}&dataset={view.shown}"), f"the link is used up by a look ahead, or leads to {found}")
    check(reply(opened)[0] == 404, "the link leads to the page again")
    check(reply(f"{view.at}/v1/datasets")[0] == 401, "others may list the datasets")
    check(reply(f"{view.at}/", Host="other.example")[0] == 421, "the page answers to other names")
    page = reply(f"{view.at}/")[2]
    check(re.search("<html|no viewer", page, re.I), f"no page at {view.at}/: {page}")
    view.ends_well(signal.SIGHUP)  # The terminal was closed.


def prepared_datasets_are_found_again():
    """By content. The cache is bounded: the least recently used dataset is evicted, displayed ones stay."""
    os.environ["BROWSER"] = write_browser()
    # Volumes are prepared again when there are newer files beside them, which may belong to them: they are in a folder of their own.
    write_volume("volumes/bar.nrrd")
    with Viewed("--no-browser volumes/bar.nrrd") as view:
        view.lists("bar")
        view.completes()
    run("server prepare volumes/bar.nrrd -o bar.mtd --quiet")
    made = "cache/multitetra/datasets/bar-*/bar.mtd"
    check(same_bytes("bar.mtd", files(made)[0]), "view makes another dataset than prepare")
    before = version_of(made)
    view_lists("volumes/bar.nrrd", "bar")
    check(version_of(made) == before, "the same volume was prepared twice")
    write_volume("volumes/bar.nrrd", other)
    view_lists("volumes/bar.nrrd", "bar")
    check(len(files(made)) == 2, f"another volume of that name was not prepared: {files(made)}")
    # A large file contains its samples and is found in any folder; a small one may be the header of others beside it.
    versions = []
    run("server generate torus --size 65 -o torus.nrrd --quiet")
    check(os.stat("torus.nrrd").st_size > 2**20, "the volume is too small")
    for folder in ("here", "there"):
        pathlib.Path(folder).mkdir()
        shutil.copy("torus.nrrd", folder)
        with Viewed(f"--no-browser {folder}/torus.nrrd") as view:
            view.lists("torus")
            view.completes()
        versions.append(version_of("cache/multitetra/datasets/torus-*/torus.mtd"))
    check(versions[0] == versions[1], "a copy of a volume in another folder was prepared again")
    # Borders are those of `prepare`; another border makes another dataset.
    view_lists("--pad-value 0 --pad 1 volumes/bar.nrrd", "bar")
    outside = [re.search(r"outside.* 0 \(value beyond the data\)", run(f"server info {file}")) is not None for file in files(made)]
    check(sorted(outside) == [False, False, True], f"view --pad-value 0 made datasets with that value: {outside}")
    expect_exit(2, "write void or a finite number", "view --no-browser --pad-value nothing volumes/bar.nrrd")
    expect_exit(5, "There is no dataset to serve", "view --no-browser missing.mtd")
    with Viewed("--no-browser --cache-dir-bytes 1 volumes/bar.nrrd") as view:
        kept = lambda: files("cache/multitetra/datasets/*")
        check(wait_for(lambda: len(kept()) == 2), f"the cache keeps {kept()}")
        view.lists("bar")
    readable = [str(path) for path in pathlib.Path("cache/multitetra").rglob("*") if path.lstat().st_mode & 0o077]
    check(not readable, f"others may read {readable}")
    expect_files("opened")  # By --no-browser.


def caches_delete_only_their_own_entries():
    """And share no folder with other files or users."""
    for file in ("mine/thesis/thesis.tex", "mine/photos/sea.png", "shared/sea.png"):
        pathlib.Path(file).parent.mkdir(parents=True)
        pathlib.Path(file).write_text("text")
    pathlib.Path("shared/sea.png").unlink()
    pathlib.Path("shared").chmod(0o757)
    write_volume("volumes/bar.nrrd")
    write_volume("volumes/other.nrrd", lambda x, y: 7 * x + y)
    expect_exit(2, "holds files that are not of this cache", "view --no-browser --cache-dir mine --cache-dir-bytes 1 volumes/bar.nrrd")
    expect_exit(2, "other users may write", "view --no-browser --cache-dir shared volumes/bar.nrrd")
    view_lists("--cache-dir marked volumes/bar.nrrd", "bar")
    for folder in ("thesis", "datasets/thesis", "datasets/photos-0123456789abcdef"):
        shutil.copytree("mine/thesis", f"marked/{folder}")
    check(files("marked/datasets/bar-*"), "nothing is cached")
    with Viewed("--no-browser --cache-dir marked --cache-dir-bytes 1 volumes/other.nrrd"):
        check(wait_for(lambda: not files("marked/datasets/bar-*")), f"the cache has no limit: {files('marked/datasets/*')}")
    kept = files("mine/**/thesis.tex", "marked/**/thesis.tex")
    check(len(kept) == 4, f"files of others were deleted: {kept} are left")
    shutil.rmtree("cache", ignore_errors=True)
    pathlib.Path("tmp").mkdir()
    with Viewed("--no-browser --no-cache volumes/bar.nrrd", TMPDIR=f"{os.getcwd()}/tmp") as view:
        view.lists("bar")
    check(not files("cache", "tmp/*"), f"--no-cache leaves {files('cache', 'tmp/*')}")


def numbered_files_are_one_series():
    """Other files are separate datasets."""
    for i in (1, 2, 3):
        write_volume(f"flow/flow_{i}.nrrd", lambda x, y: 10 * x + y + i)
        write_nrrd(f"late/late_{i}.nrrd", (128, 128, 128), os.urandom(128**3))
    view_lists("flow", "flow.t0000 flow.t0001 flow.t0002")
    with Viewed("--no-browser late") as view:  # The address appears when the first member is prepared.
        view.lists("late.t0000 late.t0001 late.t0002")
    (last,) = files("cache/multitetra/datasets/late_1-*/late.t0002.mtd")
    check(os.stat(last).st_mtime_ns > view.log.stat().st_mtime_ns, "the address is not printed before the last member is prepared")
    write_volume("two/a.nrrd")
    write_volume("two/b.nrrd", other)
    view_lists("two", "a b")


def times_are_those_of_a_collection():
    """A ParaView collection names the times, also in a folder."""
    for time in range(2):
        write_vti(f"jet/jet_{time}.vti", 6, [(name, int, [(i * step + time) % 200 for i in range(216)])
                                             for name, step in (("pressure", 3), ("heat", 7))])
    names = "jet.heat.t0000 jet.heat.t0001 jet.pressure.t0000 jet.pressure.t0001"
    view_lists("jet", names, shown="jet.pressure.t0000")  # The first field.
    collection = ('<VTKFile type="Collection" version="0.1"><Collection>\n<DataSet timestep="2.5" part="0" file="jet_1.vti"/>'
                  '<DataSet timestep="0.5" part="0" file="jet_0.vti"/>\n</Collection></VTKFile>\n')
    pathlib.Path("jet/jet.pvd").write_text(collection)
    for path in ("jet/jet.pvd", "jet"):
        with Viewed(f"--no-browser {path}") as view:
            view.lists(names)
            times = sorted(dataset["member"]["time"] for dataset in view.listed())
            check(times == [0.5, 0.5, 2.5, 2.5], f"the times of {path} are not those of the collection: {times}")
    for words, old, new, command in (("it has several files of time 0.5", "2.5", "0.5", "server view --no-browser jet/wrong.pvd"),
                                     ("files that each have a time step", 'timestep="2.5"', "", "server prepare jet/wrong.pvd -o pvd"),
                                     ("--follow", "jet_1", "../jet_1", "server prepare jet/wrong.pvd -o pvd")):
        pathlib.Path("jet/wrong.pvd").write_text(collection.replace(old, new))
        expect_exit(2, words, command)


def images_of_ome_zarr_have_labels():
    """Also those of another server, whose labels are not looked for."""
    write_zarr("slide.zarr", [6, 6, 6], bytes(i % 200 for i in range(216)))
    write_zarr("slide.zarr/labels/cells", [6, 6, 6], bytes(1 + i % 2 for i in range(216)))
    view_lists("slide.zarr", "cells.label1 cells.label2 slide", shown="slide")
    server = Started(f"{shlex.quote(sys.executable)} '{PROJECT}/tests/support/serve_folder.py' .")
    view_lists(server.match(r"(http://\S+)") + "/slide.zarr", "slide", shown="slide")


def addresses_of_all_interfaces_work_on_this_machine():
    write_volume("volumes/bar.nrrd")
    with Viewed("--no-browser volumes/bar.nrrd", MULTITETRA_HTTP="http://0.0.0.0:0") as view:
        check(re.fullmatch("http://localhost:[1-9][0-9]*", view.at), f"the address of all interfaces is {view.at}")
        view.lists("bar")
        check(reply(f"{view.at}/", Host="other.example")[0] == 421, "all interfaces answer to other names")
        check("traffic is not encrypted" in view.printed(), "no warning that other machines can connect")


def label_maps_are_offered_as_labels():
    """Beside a volume or opened directly."""
    write_volume("scan/ct.nrrd")
    write_volume("scan/ct_seg.nrrd", lambda x, y: x // 4)
    all_names = "ct ct_seg.label1 ct_seg.label2"
    view_lists("scan/ct.nrrd", all_names, shown="ct")
    view_lists("--no-labels scan/ct.nrrd", "ct")
    view_lists("scan/ct_seg.nrrd", f"ct_seg {all_names.removeprefix('ct ')}")
    run("server prepare scan/ct_seg.nrrd --label all -o prepared_labels --quiet")
    view_lists("scan/ct.nrrd --labels prepared_labels", all_names)
    pathlib.Path("halves.txt").write_text('1 0 255 0 1 1 1 "left half"\n2 255 0 0 1 1 1 "right half"\n')
    with Viewed("--no-browser scan/ct.nrrd --labels scan/ct_seg.nrrd --label-names halves.txt") as view:
        check(view.shown == "ct&labels=ct_seg:&opacity=0.35", f"named labels are not shown: {view.shown}")
        view.lists(all_names)
        names = [dataset["member"]["label"]["name"] for dataset in view.listed() if dataset["member"]]
        check(names == ["left half", "right half"], f"the labels are named {names}")
    # Prepared datasets are served directly, also those in subfolders.
    run("server prepare scan/ct_seg.nrrd --label all -o prepared/organs --quiet")
    run("server prepare scan/ct.nrrd -o prepared/ct.mtd --quiet")
    view_lists("prepared", all_names)


def labels_have_the_grid_of_their_volume():
    write_volume("scan/ct.nrrd")
    write_volume("scan/ct_seg.nrrd", lambda x, y: x // 4)
    def write_changed(source, target, keys):
        pathlib.Path(target).write_bytes(pathlib.Path(source).read_bytes().replace(b"spacings: 1 1 1", keys))
    write_changed("scan/ct_seg.nrrd", "half.nrrd", b"spacings: 0.5 1 1")
    other_grid = Started("view --no-browser scan/ct.nrrd --labels half.nrrd")
    other_grid.match(r"(labels of .half\.nrrd. are on another grid, of the same size, than .ct. \(12 x 12 x 12\))")
    other_grid.ends_well(signal.SIGINT)
    expect_exit(2, "'scan/no.nrrd' does not exist", "view --no-browser scan/ct.nrrd --labels scan/no.nrrd")
    expect_exit(2, "--labels needs the volume that they belong to", "server view --no-browser --labels scan/ct_seg.nrrd")
    tilt = b"space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0.5,1)"
    write_changed("scan/ct.nrrd", "tilted_ct.nrrd", tilt)
    write_changed("scan/ct_seg.nrrd", "tilted_organs.nrrd", tilt)
    expect_exit(2, "with --resample", "view --no-browser tilted_ct.nrrd")
    with Viewed("--no-browser --resample tilted_ct.nrrd --labels tilted_organs.nrrd") as view:
        view.lists("tilted_ct tilted_organs.label1 tilted_organs.label2")
        grids = {json.dumps([dataset["dims"], dataset["index_to_world"]]) for dataset in view.listed()}
        check(len(grids) == 1, f"tilted labels have another grid than their volume: {grids}")


def options_add_what_the_file_lacks():
    write_volume("volumes/bar.nrrd")
    with Viewed("--no-browser --spacing 2,2,3 --length-unit um volumes/bar.nrrd") as view:
        view.lists("bar")
        (listed,) = view.listed()
        check(listed["spacing"] == [2, 2, 3] and listed["length_unit"] == "µm", f"--spacing or --length-unit changes nothing: {listed}")
    view_lists("--up -y --orient x,-z,y volumes/bar.nrrd", "bar", shown="bar&up=-y")
    pathlib.Path("damaged.nrrd").write_bytes(pathlib.Path("volumes/bar.nrrd").read_bytes()[:100])
    for words, options in (("damaged.nrrd", "damaged.nrrd"), ("nowhere.nrrd", "nowhere.nrrd"), ("--spacing", "volumes/bar.nrrd --spacing 0,1,1")):
        expect_exit(2, words, f"view --no-browser {options}")


def samples_are_served_before_their_errors_are_known():
    """What another run has left incomplete is completed, without another preparation."""
    run("server generate head --size 200 -o slow.nrrd --quiet")
    with Viewed("--no-browser slow.nrrd") as view:
        view.lists("slow")
        (listed,) = view.listed()
        check(listed["missing"] == "errors", f"the errors are not computed behind: {listed}")
        pathlib.Path("early.ply").write_bytes(get(f"{view.at}/v1/datasets/slow/isosurface?format=ply&error=1", view.token))
        isovalue = json.loads(get(f"{view.at}/v1/datasets/slow", view.token))["suggested_isovalues"][0]
    run(f"server certify early.ply --volume slow.nrrd --isovalue {isovalue} --error 1 --quiet")
    with Viewed("--no-browser slow.nrrd") as view:
        view.completes()
    run("server prepare slow.nrrd -o slow.mtd --quiet")
    check(same_bytes("slow.mtd", files("cache/multitetra/datasets/slow-*/slow.mtd")[0]), "a dataset that was completed later differs")


if __name__ == "__main__":
    run_groups(samples_are_served_before_their_errors_are_known, prepared_datasets_are_found_again, label_maps_are_offered_as_labels,
               numbered_files_are_one_series, without_a_file_the_demo_is_shown, caches_delete_only_their_own_entries,
               times_are_those_of_a_collection, images_of_ome_zarr_have_labels, addresses_of_all_interfaces_work_on_this_machine,
               labels_have_the_grid_of_their_volume, options_add_what_the_file_lacks)
