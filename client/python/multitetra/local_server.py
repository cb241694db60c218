"""A server of one volume, on this machine, as long as this process lives."""

import atexit
import os
import pathlib
import re
import subprocess
import tempfile
import time

from . import _engine
from .programs import server_program
from .volume import Volume, VolumeError


class LocalServer:
    """Serves a Volume, or what one is made of, to owners of its token; `page` is the address of its viewer.

    It is a process of `multitetra-server`, which reads the samples from a file in a folder of its own and computes errors behind.
    """

    _is_closed = False

    def __init__(self, volume):
        program = server_program()
        if program is None:
            raise VolumeError("Volumes are shown by multitetra-server, which this package lacks: build multitetra_server_program.")
        volume = volume if isinstance(volume, Volume) else Volume(volume)
        self.dataset = volume.info.name
        self._folder = tempfile.TemporaryDirectory(prefix="multitetra-")
        folder = pathlib.Path(self._folder.name)
        place = getattr(volume, "_place", None)
        if place is None:
            place = folder / "volume.mtd"
            _engine.write(volume._volume, str(place))
        tokens = folder / "tokens"
        words = [program, "token", "notebook", "--file", tokens]
        self.token = subprocess.run(words, check=True, capture_output=True, text=True).stdout.strip().splitlines()[-1]
        log = folder / "log"
        with open(log, "w") as errors:
            self._process = subprocess.Popen(
                [program, "serve", place, "--tokens", tokens, "--tcp", "127.0.0.1:0", "--http", "127.0.0.1:0"],
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=errors,
            )  # fmt: skip
        atexit.register(self.close)
        found = self._addresses(log)
        self.address, self.page = "tcp://" + found["tcp"], "http://" + found["http"] + "/"

    def _addresses(self, log):
        for _ in range(1200):
            text = log.read_text()
            found = dict(re.findall(r"listening on (tcp|http)://([0-9.]+:[0-9]+)", text))
            if len(found) == 2:
                return found
            if self._process.poll() is not None:
                raise VolumeError(f"The server of the volume has ended: {text.strip().splitlines()[-1] if text.strip() else 'without a reason'}")
            time.sleep(0.05)
        self.close()
        raise VolumeError("The server of the volume did not begin to listen within a minute.")

    def close(self):
        """Ends the server."""
        self._is_closed = True
        if atexit is not None:  # At the end of the interpreter modules go first.
            atexit.unregister(self.close)
        if self._process.poll() is None:
            self._process.terminate()
            self._process.wait()
        if os.path.isdir(self._folder.name):
            self._folder.cleanup()

    def __del__(self):
        if hasattr(self, "_process") and not self._is_closed:
            self.close()
