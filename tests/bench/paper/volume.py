"""Renders the tetrahedra of a model (.vtu) as a volume: a part of paper.sh.

    xvfb-run -a /usr/bin/python3 paper_volume.py MODEL.vtu --isovalue 500.5 -o PICTURE.png

VTK casts rays through the tetrahedra, on one thread and without a graphics card. Values above the isovalue are opaque and luminous,
others transparent: a model approximates the field only at the isosurface. Prints JSON: the number of tetrahedra and the shortest of
three frame times.
"""
import argparse
import json
import time

import numpy
import vtk
from vtk.util.numpy_support import vtk_to_numpy


def volume_of(grid, isovalue, thickness):
    """`thickness`: the approximate depth of visibility, in the units of the points."""
    low, high = grid.GetPointData().GetScalars().GetRange()
    ramp = 0.005 * (high - low)
    opacity = vtk.vtkPiecewiseFunction()
    opacity.AddPoint(isovalue - ramp, 0)
    opacity.AddPoint(isovalue + ramp, 1)
    color = vtk.vtkColorTransferFunction()
    color.AddRGBPoint(isovalue - ramp, 0.95, 0.75, 0.55)
    color.AddRGBPoint(isovalue + ramp, 1.0, 0.95, 0.85)
    look = vtk.vtkVolumeProperty()
    look.SetColor(color)
    look.SetScalarOpacity(opacity)
    look.SetScalarOpacityUnitDistance(thickness)
    look.SetInterpolationTypeToLinear()
    look.ShadeOff()
    mapper = vtk.vtkUnstructuredGridVolumeRayCastMapper()
    mapper.SetRayIntegrator(vtk.vtkUnstructuredGridPreIntegration())
    mapper.AutoAdjustSampleDistancesOff()
    mapper.SetImageSampleDistance(1)
    mapper.SetNumberOfThreads(1)
    mapper.SetInputData(grid)
    volume = vtk.vtkVolume()
    volume.SetMapper(mapper)
    volume.SetProperty(look)
    return volume


def rendered(window):
    """The shortest of three frame times, each from a slightly different view, so that nothing is cached."""
    camera = window.GetRenderers().GetFirstRenderer().GetActiveCamera()
    least = None
    for turn in (1, 1, -2):
        camera.Azimuth(turn)
        begin = time.perf_counter()
        window.Render()
        window.WaitForCompletion()
        seconds = time.perf_counter() - begin
        least = seconds if least is None else min(least, seconds)
    return least


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("model")
    parser.add_argument("--isovalue", type=float, required=True)
    parser.add_argument("--side", type=int, default=420, help="pixels")
    parser.add_argument("--azimuth", type=float, default=30)
    parser.add_argument("--elevation", type=float, default=15)
    parser.add_argument("-o", "--output", required=True)
    arguments = parser.parse_args()

    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(arguments.model)
    reader.Update()
    grid = reader.GetOutput()

    renderer = vtk.vtkRenderer()
    renderer.SetBackground(0, 0, 0)
    renderer.AddVolume(volume_of(grid, arguments.isovalue, 0.12 * grid.GetLength()))
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetMultiSamples(0)
    window.SetSize(arguments.side, arguments.side)
    window.AddRenderer(renderer)

    # The view of `snapshot`, azimuth 0 along +y, of the box around the visible values; slightly off its center, because
    # VTK fails for rays within a plane of the grid between tetrahedra.
    glows = vtk_to_numpy(grid.GetPointData().GetScalars()) > arguments.isovalue
    points = vtk_to_numpy(grid.GetPoints().GetData())[glows]
    low, high = points.min(axis=0), points.max(axis=0)
    x, y, z = (low + high) / 2 + 0.137
    distance = 1.45 * numpy.linalg.norm(high - low)
    camera = renderer.GetActiveCamera()
    camera.SetViewUp(0, 0, 1)
    camera.SetFocalPoint(x, y, z)
    camera.SetPosition(x, y - distance, z)
    camera.Azimuth(arguments.azimuth)
    camera.Elevation(arguments.elevation)
    renderer.ResetCameraClippingRange()
    seconds = rendered(window)

    image = vtk.vtkWindowToImageFilter()
    image.SetInput(window)
    image.ReadFrontBufferOff()
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(arguments.output)
    writer.SetInputConnection(image.GetOutputPort())
    writer.Write()
    print(json.dumps({"tetrahedra": grid.GetNumberOfCells(), "points": grid.GetNumberOfPoints(),
                      "seconds": seconds, "renderer": "VTK " + vtk.vtkVersion.GetVTKVersion()}))


if __name__ == "__main__":
    main()
