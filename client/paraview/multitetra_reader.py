"""A source for ParaView: an isosurface of a Multi-Tetra server, refined while one looks at it.

Load it with Tools > Manage Plugins > Load New, or with pvpython's LoadPlugin(); then it is under Sources. It needs the
package `multitetra` beside it on PYTHONPATH, as the build puts it together (client/python/README.md):

    PYTHONPATH=build/release/python paraview

Server, dataset, isovalue and error are properties; Refinement says how many of the stream's steps are taken, so that a coarse
surface is there at once and "Refine" gets the next one. What comes was checked by the package before it is shown.
"""

import numpy as np
from paraview.util.vtkAlgorithm import smdomain, smhint, smproperty, smproxy
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

import multitetra


def poly_data(mesh):
    """A Mesh of the package as vtkPolyData, with its normals where it has some."""
    points = vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(mesh.vertices, dtype=np.float32), deep=1))
    offsets = np.arange(0, 3 * len(mesh.faces) + 1, 3, dtype=np.int64)
    cells = vtkCellArray()
    cells.SetData(
        numpy_to_vtkIdTypeArray(offsets, deep=1),
        numpy_to_vtkIdTypeArray(np.ascontiguousarray(mesh.faces.ravel(), dtype=np.int64), deep=1),
    )
    data = vtkPolyData()
    data.SetPoints(points)
    data.SetPolys(cells)
    return data


def field_value(name, value):
    """A number that goes with the data, as ParaView's information panel shows it."""
    array = numpy_to_vtk(np.array([value], dtype=np.float64), deep=1)
    array.SetName(name)
    return array


@smproxy.source(name="MultiTetraIsosurface", label="Multi-Tetra Isosurface")
@smhint.xml('<ShowInMenu category="Multi-Tetra"/>')
class MultiTetraIsosurface(VTKPythonAlgorithmBase):
    """The isosurface of a dataset, by its server."""

    def __init__(self):
        super().__init__(nInputPorts=0, nOutputPorts=1, outputType="vtkPolyData")
        self._server = "ws://127.0.0.1:7480"
        self._token = ""
        self._dataset = ""
        self._isovalue = 0.0
        self._error = 0.25
        self._steps = 1
        self._stream = None  # The stream of steps.
        self._taken = 0  # The number of steps taken from the stream.
        self._latest = None  # The last step taken.
        self._connection = None

    # ---- properties

    @smproperty.stringvector(name="Server", default_values="ws://127.0.0.1:7480")
    def SetServer(self, value):
        self._set("_server", value)

    @smproperty.stringvector(name="Token", default_values="")
    def SetToken(self, value):
        self._set("_token", value)

    @smproperty.stringvector(name="Dataset", default_values="")
    def SetDataset(self, value):
        self._set("_dataset", value)

    @smproperty.doublevector(name="Isovalue", default_values=0.0)
    def SetIsovalue(self, value):
        self._set("_isovalue", value)

    @smproperty.doublevector(name="Error", default_values=0.25)
    @smdomain.doublerange(min=0.0, max=64.0)
    def SetError(self, value):
        """Voxels."""
        self._set("_error", value)

    @smproperty.intvector(name="Refinement", default_values=1)
    @smdomain.intrange(min=1, max=20)
    def SetRefinement(self, value):
        """How many steps of the stream are used; the last step is the requested surface."""
        if value != self._steps:
            if value < self._taken:
                self._restart()
            self._steps = value
            self.Modified()

    @smproperty.xml('<Property name="Refine" command="Refine" panel_widget="command_button"/>')
    def Refine(self):
        """Uses the next step, unless the last step has been received."""
        if self._latest is None or not self._latest.is_final:
            self._steps = self._taken + 1
            self.Modified()

    # ---- the stream

    def _set(self, name, value):
        if getattr(self, name) == value:
            return
        setattr(self, name, value)
        if name in ("_server", "_token"):
            self._disconnect()
        self._restart()
        self.Modified()

    def _restart(self):
        self._stream = None
        self._taken = 0
        self._latest = None

    def _disconnect(self):
        if self._connection is not None:
            self._connection.close()
            self._connection = None

    def _open(self):
        if self._connection is None:
            self._connection = multitetra.connect(self._server, token=self._token)
        return self._connection.steps(self._dataset, self._isovalue, error=self._error)

    def _take(self):
        """Steps up to the one that is wanted; the connection is made again where it was lost."""
        try:
            if self._stream is None:
                self._stream = self._open()
            while self._taken < self._steps and (self._latest is None or not self._latest.is_final):
                self._latest = next(self._stream)
                self._taken += 1
        except Exception:
            self._disconnect()
            self._restart()
            raise

    def RequestData(self, request, inInfo, outInfo):
        output = vtkPolyData.GetData(outInfo, 0)
        if not self._dataset:
            return 1
        try:
            self._take()
        except Exception as failure:  # ParaView shows printed text; an exception would end its pipeline.
            print(f"Multi-Tetra: {failure}")
            return 0
        output.ShallowCopy(poly_data(self._latest.mesh))
        fields = output.GetFieldData()
        fields.AddArray(field_value("step", self._latest.number))
        fields.AddArray(field_value("is final", float(self._latest.is_final)))
        bound = self._latest.mesh.error_bound
        fields.AddArray(field_value("largest error", float("nan") if bound is None else bound))
        return 1
