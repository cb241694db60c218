"""Opens a surface with the ParaView source, over TLS with a token. Usage: open_in_paraview.py PLUGIN SERVER TOKEN-FILE DATASET ISOVALUE PICTURE.png"""
import pathlib
import sys

from paraview.simple import (
    GetActiveViewOrCreate,
    LoadPlugin,
    Render,
    ResetCamera,
    SaveScreenshot,
    Show,
)

plugin, server, token_file, dataset, isovalue, picture = sys.argv[1:]
LoadPlugin(plugin, remote=False, ns=globals())
token = pathlib.Path(token_file).read_text().strip()
surface = MultiTetraIsosurface(  # noqa: F821  The plugin defines the name.
    Server=server, Token=token, Dataset=dataset, Isovalue=float(isovalue), Error=1.0, Refinement=20
)
surface.UpdatePipeline()
view = GetActiveViewOrCreate("RenderView")
view.ViewSize = [640, 480]
Show(surface, view)
ResetCamera(view)
Render(view)
SaveScreenshot(picture, view)
print("TRIANGLES", surface.GetDataInformation().GetNumberOfCells(), flush=True)
