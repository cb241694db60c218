"""Tests the notebook viewer, and runs the example notebooks with a server.

Usage: notebooks_test.py DIRECTORY_OF_PROGRAMS [--write]     (with PYTHONPATH set)

With --write the executed examples are stored: the gallery.
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import unittest.mock

try:
    import ipykernel  # noqa: F401
    import ipywidgets  # noqa: F401
    import matplotlib  # noqa: F401
    import nbclient
    import nbformat
    import numpy as np

    import multitetra  # Needs numpy.
except ImportError as missing:
    print(f"!! SKIPPED: notebooks are not tested: {missing}")
    sys.exit(77)

PROJECT = pathlib.Path(__file__).resolve().parents[3]
EXAMPLES = PROJECT / "client" / "python" / "examples"
IS_WRITING = "--write" in sys.argv
sys.argv = [word for word in sys.argv if word != "--write"]
PROGRAMS = pathlib.Path(sys.argv.pop(1))


class ViewerOfNotebooks(unittest.TestCase):
    def test_settings_equal_those_of_the_page(self):
        from multitetra.viewer import SETTINGS

        text = (PROJECT / "client" / "web" / "src" / "state" / "settings.ts").read_text()
        tables = re.findall(r"^const (?:first|view)Table = \{(.*?)^\}", text, re.S | re.M)
        self.assertEqual(SETTINGS, {name for table in tables for name in re.findall(r"^  (\w+): ", table, re.M)})

    def test_sends_only_given_settings_and_keeps_user_changes(self):
        viewer = multitetra.Viewer("https://volumes.example/path", dataset="a head", isovalue=1.5, maxTriangles=9, simplify=False, color="#aabbcc")
        self.assertEqual(
            viewer.page, "https://volumes.example/path/?embed#dataset=a%20head&isovalue=1.5&max_triangles=9&simplify=false&color=aabbcc"
        )
        viewer.settings = {"dataset": "a head", "isovalue": 7.5, "error": 0.25}  # The page does the same.
        viewer.error = 2.0
        self.assertEqual(viewer.wanted["isovalue"], 7.5)
        self.assertEqual(viewer.wanted["error"], 2.0)
        viewer.surfaces = [{"isovalue": 3}]
        self.assertEqual(viewer.wanted["surfaces"][0]["opacity"], 1)
        self.assertEqual(viewer.isovalue, 7.5)
        self.assertIsNone(viewer.camera)
        self.assertIsNone(viewer.time)
        viewer.time = 3
        self.assertEqual((viewer.wanted["t"], viewer.wanted["playing"]), (3.0, False))

    def test_shows_samples_as_a_volume(self):
        viewer = multitetra.Viewer("https://volumes.example/", volume="on", opacities=[{"value": 3, "opacity": 0.5}])
        self.assertIn("volume=on", viewer.page)
        self.assertEqual(viewer.get("volume"), "on")
        self.assertEqual(viewer.wanted["opacities"][0]["opacity"], 0.5)
        with self.assertRaisesRegex(ValueError, "comes first, without a name"):
            multitetra.Viewer(volume="https://volumes.example/")

    def test_raises_errors_at_the_call(self):
        viewer = multitetra.Viewer()
        for mistake in ({"isovlaue": 3}, {"isovalue": float("nan")}):
            with self.assertRaises(ValueError):
                viewer.set(**mistake)
        for neither_server_nor_file in ("nonsense", "javascript:alert(1)"):
            with self.assertRaisesRegex(ValueError, "does not exist"):
                multitetra.Viewer(neither_server_nor_file)

    def test_tells_servers_from_volumes(self):
        from multitetra.viewer import is_server

        for server in ("http://127.0.0.1:7480", "https://volumes.example/some/path/", "wss://a.example/v1/stream", "tcp://127.0.0.1:7410"):
            self.assertTrue(is_server(server), server)
        for volume in ("https://volumes.example/head.zarr", "s3://bucket/head.mtd", "head.nrrd", "tcp", pathlib.Path("x"), np.zeros((3, 3, 3))):
            self.assertFalse(is_server(volume), volume)

    def test_falls_back_to_a_frame_without_widgets(self):
        viewer = multitetra.Viewer(dataset='"><script>')
        frame = viewer.frame().data
        self.assertNotIn("<script", frame)
        self.assertIn('src="http://127.0.0.1:7480/?embed#dataset=%22%3E%3Cscript%3E"', frame)


    def test_passes_messages_on_without_more_than_the_page_takes(self):
        viewer = multitetra.Viewer(np.random.default_rng(1).standard_normal((40, 40, 40), np.float32))
        sent, has_changed = [], threading.Condition()

        def send(content, buffers=()):
            with has_changed:
                sent.append((content, buffers))
                has_changed.notify_all()

        with unittest.mock.patch.object(viewer, "send", send):
            viewer._heard({"kind": "code", "isKnown": True}, [])
            self.assertEqual(sent.pop()[0], {"kind": "code", "token": viewer._token})
            viewer._heard({"channel": 1, "kind": "open"}, [])
            viewer._heard({"channel": 1, "kind": "message"}, [b"\xff" * 9])  # No message: the server says so, and ends.
            with has_changed:
                self.assertTrue(has_changed.wait_for(lambda: any(content["kind"] == "closed" for content, _ in sent), 60), sent)
            viewer._heard({"channel": 1, "kind": "taken", "bytes": 9}, [])  # Of a connection that has ended.
            viewer._heard({"channel": 2, "kind": "open"}, [])
            self.assertEqual(list(viewer._channels), [2], "those that have ended are kept")
        self.assertEqual({content["channel"] for content, _ in sent}, {1})
        folder = viewer._server._folder.name
        viewer.close()
        self.assertFalse(os.path.exists(folder))


class Examples(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        path = pathlib.Path(cls.folder.name)
        server = PROGRAMS / "multitetra-server"
        for words in (
            ["generate", "head", "--size", "65", "-o", path / "head.nrrd", "--quiet"],
            ["prepare", path / "head.nrrd", "-o", path / "head.mtd", "--quiet"],
        ):
            subprocess.run([server, *words], check=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        log = path / "log"
        with open(log, "w") as stderr:
            words = ["serve", path / "head.mtd", "--tcp", "127.0.0.1:0", "--http", "127.0.0.1:0"]
            cls.server = subprocess.Popen([server, *words], stdout=subprocess.DEVNULL, stderr=stderr)
        for _ in range(600):
            found = re.search(r"listening on (http://[0-9.]+:[0-9]+)", log.read_text())
            if found:
                break
            time.sleep(0.05)
        os.environ["MULTITETRA_SERVER"] = found[1] + "/"
        os.environ["MPLBACKEND"] = "module://matplotlib_inline.backend_inline"
        # Separate folders for the kernel, so that none of the user's are read or written.
        for name in ("JUPYTER_CONFIG_DIR", "JUPYTER_RUNTIME_DIR", "IPYTHONDIR", "MPLCONFIGDIR"):
            os.environ[name] = str(path / name)

    @classmethod
    def tearDownClass(cls):
        cls.server.terminate()
        cls.server.wait()
        cls.folder.cleanup()

    def test_surfaces_as_arrays(self):
        self.run_example("surfaces_as_arrays")

    def test_surfaces_of_arrays(self):
        self.run_example("surfaces_of_arrays")

    def test_samples_and_surfaces(self):
        self.run_example("samples_and_surfaces")

    def test_viewer_both_ways(self):
        self.run_example("viewer_both_ways")

    # Checks that the output equals the stored output and that pictures exist.
    def run_example(self, name):
        path = EXAMPLES / f"{name}.ipynb"
        notebook = nbformat.read(path, as_version=4)
        stored = [output_of(cell) for cell in notebook.cells]
        client = nbclient.NotebookClient(
            notebook, timeout=120, kernel_name="python3", record_timing=False, store_widget_state=False
        )
        client.comm_open_handlers = {}  # nbclient would handle widgets as those of ipywidgets 7; nothing displays them here.
        client.execute()
        if IS_WRITING:
            for cell in notebook.cells:  # Warnings depend on the machine.
                cell["outputs"] = [output for output in cell.get("outputs", []) if output.get("name") != "stderr"]
                if cell.cell_type != "code":
                    del cell["outputs"]
            text = nbformat.writes(notebook).replace(os.environ["MULTITETRA_SERVER"], "http://127.0.0.1:7480/")
            path.write_text(text + "\n")
            return
        self.assertEqual([output_of(cell) for cell in notebook.cells], stored)


def output_of(cell):
    """Returns the printed text of a code cell and the kinds of its other outputs."""
    outputs = cell.get("outputs", [])
    text = "".join(output["text"] for output in outputs if output.get("name") == "stdout")
    kinds = {kind for output in outputs for kind in output.get("data", {})}
    for viewer in ({"application/vnd.jupyter.widget-view+json"}, {"application/javascript", "text/html"}):  # By the installed ipywidgets.
        if viewer <= kinds:
            kinds = kinds - viewer | {"viewer"}
    return text, sorted(kinds)


if __name__ == "__main__":
    unittest.main(verbosity=2)
