"""The viewer in a notebook's cell, with settings that go both ways.

    viewer = multitetra.Viewer("http://127.0.0.1:7480", dataset="head", isovalue=500.5)
    viewer                                   # Shows it.
    viewer.set(isovalue=300.5, error=1.0)    # Turns what is shown.
    viewer.isovalue                          # The current one, also after it was dragged.
    viewer.picks                             # Places that were clicked.
    viewer.observe(lambda change: ..., "picks")

It is the server's own page in a frame, so that the notebook's address has to be allowed there: multitetra-server serve
--allow-origin http://localhost:8888. It needs ipywidgets (6 or later). Where a front end has no widgets, viewer.frame() shows
the same page with what was set before, and nothing comes back.
"""

import html
import json
import pathlib
import re
from urllib.parse import quote, urlencode, urlsplit, urlunsplit

import ipywidgets
import traitlets
from IPython.display import HTML, Javascript, display

from .addresses import page_address

# Documented in client/web/src/state/settings.ts.
SETTINGS = frozenset(
    "dataset isovalue error bound topologyRule topologyTolerance region followView pixels maxTriangles simplify surfaces color opacity "
    "visible minComponent shading wireframe coloring clip clipAt clipNormal clipFlipped crop filled slice sliceAt sliceColors level hiddenParts "
    "windowWidth axes projection occlusion colorBy colors fieldLevel fieldWindow fieldLog noValueColor samplesLog logScale "
    "theme eye target up t playing speed loop places samplesOf transparentAir volume opacities volumeShading layout cross material labels labelNames gestures".split()
)
MODULE = "multitetra_viewer"


class Viewer(ipywidgets.DOMWidget):
    """One dataset of a server: `server` is the address of its page, other names are settings."""

    _view_name = traitlets.Unicode("ViewerView").tag(sync=True)
    _view_module = traitlets.Unicode(MODULE).tag(sync=True)
    page = traitlets.Unicode(help="The address of the frame.").tag(sync=True)
    height = traitlets.Int(480, help="Height of the cell, in pixels.").tag(sync=True)
    wanted = traitlets.Dict(help="Settings changed in Python.").tag(sync=True)
    settings = traitlets.Dict(help="All settings, as the viewer has them; empty before it is shown.").tag(sync=True)
    shown = traitlets.Dict(help="Properties of the step that was last shown: triangles, errorWorld (None: a preview, see spacing), topology, ...").tag(sync=True)
    picks = traitlets.List(help="Places that were clicked: world, index, isovalue.").tag(sync=True)
    ignored = traitlets.List(help="Names of settings that are unknown or whose values are invalid.").tag(sync=True)

    def __init__(self, server="http://127.0.0.1:7480", *, height=480, **settings):
        checked(settings)
        super().__init__(page=page_of(server, settings), height=height, wanted=settings)

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

    def _ipython_display_(self, **options):
        display(Javascript(module_of_notebook()))
        super()._ipython_display_(**options)


def checked(settings):
    unknown = sorted(set(settings) - SETTINGS)
    if unknown:
        raise ValueError(f"The viewer has no setting named {', '.join(unknown)}; the settings are {', '.join(sorted(SETTINGS))}.")
    json.dumps(settings, allow_nan=False)  # Raises here, at the caller, for values that are not JSON.


def page_of(server, settings):
    """The address of the page without its panel. What the address can say of the settings is in it."""
    parts = urlsplit(page_address(server))
    simple = {snake(name): in_address(value) for name, value in settings.items() if isinstance(value, (bool, int, float, str))}
    query = urlencode(simple, quote_via=quote)
    return urlunsplit((parts.scheme, parts.netloc, parts.path, "embed", query))


def snake(name):
    """clipAt as an address has it: clip_at."""
    return re.sub("[A-Z]", lambda letter: "_" + letter[0].lower(), name)


def in_address(value):
    if isinstance(value, bool):
        return str(value).lower()
    return value.removeprefix("#") if isinstance(value, str) else value


def frame_of(page, height):
    return f'<iframe src="{html.escape(page)}" title="Multi-Tetra viewer" width="100%" height="{height}" style="border: 0" allow="fullscreen"></iframe>'


def module_of_notebook():
    """The view as the classic notebook's loader wants it. Elsewhere it does nothing."""
    base = "jupyter-js-widgets" if ipywidgets.version_info[0] < 7 else "@jupyter-widgets/base"
    render = pathlib.Path(__file__).with_name("viewer_widget.js").read_text()
    return f"""
if (typeof define === "function" && define.amd) {{
  require.undef("{MODULE}");
  define("{MODULE}", ["{base}"], (widgets) => {{
    {render}
    return {{
      ViewerView: widgets.DOMWidgetView.extend({{
        render() {{
          this.end = render({{ model: this.model, el: this.el }});
        }},
        remove() {{
          this.end();
          return widgets.DOMWidgetView.prototype.remove.apply(this, arguments);
        }},
      }}),
    }};
  }});
}}
"""
