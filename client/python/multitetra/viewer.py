"""The viewer in a notebook's cell, with settings that go both ways.

    viewer = multitetra.view(volume, isovalue=300.5)     # A Volume, an array, a file, or the address of a server.
    viewer                                   # Shows it.
    viewer.set(isovalue=300.5, error=1.0)    # Turns what is shown.
    viewer.isovalue                          # The current one, also after it was dragged.
    viewer.picks                             # Places that were clicked.
    viewer.observe(lambda change: ..., "picks")

The viewer talks to its server through the kernel, by messages of the widget: the browser reaches nothing but the notebook. It needs
ipywidgets (6 or later; 8 in JupyterLab and Notebook 7), and in VS Code and Colab anywidget. Where a front end has no widgets,
viewer.frame() shows the page of a server, and nothing comes back. A notebook without a kernel shows the last picture.
"""

import base64
import html
import json
import pathlib
import re
from urllib.parse import quote, urlencode, urlsplit, urlunsplit

import ipywidgets
import traitlets
from IPython.display import HTML, Javascript, display

from . import _client
from .addresses import page_address, stream_address
from .programs import shared_file

try:
    from anywidget import AnyWidget as _Widget  # Has a part in every front end.
except ImportError:
    _Widget = ipywidgets.DOMWidget

WIDGETS = int(ipywidgets.__version__.split(".")[0])

# Documented in client/web/src/state/settings.ts.
SETTINGS = frozenset(
    "dataset isovalue error bound topologyRule topologyTolerance region followView pixels maxTriangles drawableTriangles simplify surfaces color opacity "
    "visible minComponent shading wireframe coloring clip clipAt clipNormal clipFlipped crop filled slice sliceAt sliceColors level hiddenParts "
    "windowWidth axes projection occlusion colorBy colors fieldLevel fieldWindow fieldLog noValueColor samplesLog logScale "
    "theme eye target up t playing speed loop places samplesOf transparentAir volume opacities volumeShading volumeLabels layout cross material labels labelNames gestures".split()
)
MODULE = "multitetra_viewer"


class Viewer(_Widget):
    """One dataset: `volume` is a Volume, what one is made of, or the address of a server; other names are settings.

    `token` and `ca` are those of `multitetra.connect`.
    """

    if _Widget is ipywidgets.DOMWidget:
        _view_name = traitlets.Unicode("ViewerView").tag(sync=True)
        _view_module = traitlets.Unicode(MODULE).tag(sync=True)
    else:
        _esm = pathlib.Path(__file__).with_name("viewer_widget.js").read_text() + "export default { render };\n"
    page = traitlets.Unicode(help="The address of the server's page; empty if it has none.")
    height = traitlets.Int(480, help="Height of the cell, in pixels.").tag(sync=True)
    wanted = traitlets.Dict(help="Settings changed in Python.").tag(sync=True)
    settings = traitlets.Dict(help="All settings, as the viewer has them; empty before it is shown.").tag(sync=True)
    shown = traitlets.Dict(help="Properties of the step that was last shown: triangles, errorWorld (None: a preview, see spacing), topology, ...").tag(sync=True)
    picks = traitlets.List(help="Places that were clicked: world, index, isovalue.").tag(sync=True)
    ignored = traitlets.List(help="Names of settings that are unknown or whose values are invalid.").tag(sync=True)

    def __init__(self, volume="http://127.0.0.1:7480", /, *, height=480, token="", ca=None, **settings):
        self._server, self._channels = None, {}
        checked(settings)
        if is_server(volume):
            address, page = stream_address(volume), page_of(volume, settings) if volume.startswith(("http", "ws")) else ""
        else:
            from .local_server import LocalServer

            self._server = LocalServer(volume)
            address, token, page = self._server.address, self._server.token, page_of(self._server.page, settings)
            settings.setdefault("dataset", self._server.dataset)
        self._address, self._token, self._ca = address, token, ca
        self._picture, self._shown_at = None, []
        super().__init__(page=page, height=height, wanted=settings)
        self.on_msg(lambda _, content, buffers: self._heard(content, buffers))

    # What the page and the server say to each other, as client/web/src/notebook/kernel_channel.ts describes it.
    def _heard(self, content, buffers):
        number, kind = content.get("channel"), content["kind"]
        if kind == "code":
            code = b"" if content.get("isKnown") else shared_file("widget/widget.js").read_bytes()
            self.send({"kind": "code", "token": self._token}, [code])
        elif kind == "picture":
            self._picture = bytes(buffers[0])
            for shown in self._shown_at:
                shown.update(self._last_picture(), raw=True)
        elif kind == "open":
            self._channels = {other: channel for other, channel in self._channels.items() if channel.is_open}
            self._channels[number] = _client.Channel(
                self._address, self._ca or "", False,
                lambda message: self.send({"channel": number, "kind": "message"}, [message]),
                lambda reason: self.send({"channel": number, "kind": "closed", "reason": reason}),
            )  # fmt: skip
        elif number in self._channels:
            channel = self._channels[number]
            if kind == "message":
                channel.send(buffers[0])
            elif kind == "taken":
                channel.taken(content["bytes"])
            elif kind == "close":
                del self._channels[number]
                channel.close()

    def close(self):
        """Ends its connections, and the server of its volume."""
        for channel in self._channels.values():
            channel.close()
        self._channels = {}
        if self._server is not None:
            self._server.close()
        super().close()

    def set(self, **settings):
        """Changes some settings of what is shown; the others are unchanged."""
        checked(settings)
        self.wanted = {**self.wanted, **self.settings, **settings}

    def get(self, name):
        """The current value of a setting; None for its default."""
        checked({name: None})
        return self.settings.get(name, self.wanted.get(name))

    @property
    def isovalue(self):
        return self.get("isovalue")

    @isovalue.setter
    def isovalue(self, isovalue):
        self.set(isovalue=isovalue)

    @property
    def error(self):
        """Largest distance from the full-resolution surface, in voxels."""
        return self.get("error")

    @error.setter
    def error(self, error):
        self.set(error=error)

    @property
    def time(self):
        """The displayed time of a series, in its unit; None: that of the given dataset."""
        return self.get("t")

    @time.setter
    def time(self, time):
        self.set(t=None if time is None else float(time), playing=False)

    @property
    def surfaces(self):
        """The further surfaces, each a dict of isovalue, error, color, opacity, visible, and optionally minComponent, dataset."""
        return self.get("surfaces") or []

    @surfaces.setter
    def surfaces(self, surfaces):
        usual = {"error": None, "color": "#d9775f", "opacity": 1, "visible": True}
        self.set(surfaces=[{**usual, **surface} for surface in surfaces])

    @property
    def camera(self):
        """The eye and what it looks at, in world coordinates; None until the view was turned."""
        eye, target = self.get("eye"), self.get("target")
        return (eye, target) if eye and target else None

    @camera.setter
    def camera(self, eye_and_target):
        eye, target = eye_and_target
        self.set(eye=[float(x) for x in eye], target=[float(x) for x in target])

    def forget_picks(self):
        self.picks = []

    def frame(self):
        """The viewer without widgets, for front ends without them and for exported pages: changes in it are not reported to Python."""
        return HTML(frame_of(self.page, self.height))

    def _last_picture(self):
        """An output beside the widget, which hides it: what a notebook shows without a kernel."""
        picture = {"text/plain": f"<Viewer of {self.wanted.get('dataset', 'a server')}>", "text/html": '<div class="multitetra-picture"></div>'}
        if self._picture:
            png = base64.b64encode(self._picture).decode()
            picture |= {"text/html": f'<img class="multitetra-picture" src="data:image/png;base64,{png}">', "image/png": png}
        return picture

    def _ipython_display_(self, **options):
        if _Widget is ipywidgets.DOMWidget:
            display(Javascript(module_of_notebook()))
        if WIDGETS < 7:  # It takes a front end that was there before the kernel for a missing one, and says so.
            self._send({"method": "display"})
        elif hasattr(super(), "_ipython_display_"):  # Before ipywidgets 8.
            super()._ipython_display_(**options)
        else:
            display(self._repr_mimebundle_(), raw=True)
        self._shown_at = [*self._shown_at[-1:], display(self._last_picture(), raw=True, display_id=True)]


def view(volume, /, **settings):
    """Shows a volume: in a notebook as a Viewer, elsewhere in the browser, while the returned server lives.

    Parameters
    ----------
    volume : Volume, array_like, path, or address of a server
    **settings
        As of `Viewer.set`: isovalue, error, surfaces and so on.
    """
    if is_in_notebook():
        return Viewer(volume, **settings)
    import webbrowser

    from .local_server import LocalServer

    checked(settings)
    if unsaid := [name for name, value in settings.items() if value is not None and in_address(value) is None]:
        raise ValueError(f"Outside of notebooks the address of the page has the settings, and cannot have {', '.join(unsaid)}; choose it in the page.")
    server = None if is_server(volume) else LocalServer(volume)
    page = page_of(volume if server is None else server.page, settings).replace("?embed", "", 1)
    if server is not None:
        page += f"&token={server.token}" if urlsplit(page).fragment else f"#token={server.token}"
    webbrowser.open(page)
    return server


def is_server(volume):
    """Whether this is the address of a server, and not of a volume or dataset, whose name has a suffix."""
    if not isinstance(volume, str):
        return False
    parts = urlsplit(volume)
    last = parts.path.rsplit("/", 1)[-1]
    return parts.scheme in ("ws", "wss", "tcp", "tls") or (parts.scheme in ("http", "https") and "." not in last)


def is_in_notebook():
    try:
        return get_ipython().kernel is not None  # noqa: F821: IPython defines it.
    except (NameError, AttributeError):
        return False


def checked(settings):
    unknown = sorted(set(settings) - SETTINGS)
    if unknown:
        raise ValueError(f"The viewer has no setting named {', '.join(unknown)}; the settings are {', '.join(sorted(SETTINGS))}.")
    volume = settings.get("volume")
    if volume is not None and not (isinstance(volume, str) and volume in ("off", "on", "maximum")):
        raise ValueError('The setting volume is "off", "on" or "maximum"; what is to be shown comes first, without a name.')
    json.dumps(settings, allow_nan=False)  # Raises here, at the caller, for values that are not JSON.


def page_of(server, settings):
    """The address of the page without its panel. What the address can say of the settings is in it."""
    parts = urlsplit(page_address(server))
    said = {snake(name): in_address(value) for name, value in settings.items()}
    simple = {name: value for name, value in said.items() if value is not None}
    query = urlencode(simple, quote_via=quote)
    return urlunsplit((parts.scheme, parts.netloc, parts.path, "embed", query))


def snake(name):
    """clipAt as an address has it: clip_at."""
    return re.sub("[A-Z]", lambda letter: "_" + letter[0].lower(), name)


def in_address(value):
    """As an address has it: numbers, texts, places; None for what an address cannot say."""
    if hasattr(value, "tolist"):  # Of NumPy.
        value = value.tolist()
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (list, tuple)):
        are_numbers = value and all(isinstance(one, (int, float)) for one in value)
        return ",".join(map(str, value)) if are_numbers else None
    if isinstance(value, str):
        return value.removeprefix("#")
    return value if isinstance(value, (int, float)) else None


def frame_of(page, height):
    return f'<iframe src="{html.escape(page)}" title="Multi-Tetra viewer" width="100%" height="{height}" style="border: 0" allow="fullscreen"></iframe>'


def module_of_notebook():
    """The view as the classic notebook's loader wants it. Elsewhere it does nothing: JupyterLab and Notebook 7 load viewer_lab.js."""
    base = "jupyter-js-widgets" if WIDGETS < 7 else "@jupyter-widgets/base"
    render = pathlib.Path(__file__).with_name("viewer_widget.js").read_text()
    return f"""
if (typeof define === "function" && define.amd) {{
  require.undef("{MODULE}");
  define("{MODULE}", ["{base}"], (widgets) => {{
    {render}
    return {{
      ViewerView: class extends widgets.DOMWidgetView {{
        render() {{
          const {{ model }} = this;
          const send = model.send;
          // Before ipywidgets 7 custom messages count as pending for ever, and state waits for pending ones.
          model.send = (...message) => {{
            const pending = model.pending_msgs;
            send.apply(model, message);
            model.pending_msgs = pending;
          }};
          this.end = render({{ model, el: this.el }});
        }}
        remove() {{
          this.end();
          return super.remove();
        }}
      }},
    }};
  }});
}}
"""
