"""Renders a volume with VTK's rays and compares the picture with the viewer's: a part of paper.sh.

    xvfb-run -a /usr/bin/python3 raycast.py VOLUME.nrrd VIEWER.png --eye X Y Z --target X Y Z -o PICTURE.png

Both have the camera, size and transfer function below. Prints JSON: how much of the two silhouettes' union is in both, and the rank
correlation of brightness within both (VTK blends colors as stored, the viewer as light, so brightness itself differs).
"""
import argparse
import json
import urllib.parse

import numpy
import vtk
from PIL import Image
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

OPACITIES = ((-250, 0), (-100, 0.03), (100, 0.05), (300, 0.15), (1000, 0.7))  # Of one voxel, by value.
LEVEL, WINDOW = 250, 1500
FIELD_OF_VIEW = 35  # The viewer's, in degrees.


def address(dataset, eye, target):
    """The viewer's address after #."""
    numbers = {"volume": "on", "opacities": ",".join(f"{value}:{opacity}" for value, opacity in OPACITIES), "level": LEVEL,
               "window_width": WINDOW, "eye": ",".join(map(str, eye)), "target": ",".join(map(str, target))}
    return urllib.parse.urlencode({"dataset": dataset, "visible": "false", "axes": "false", "theme": "dark", **numbers}, safe=":,-")


def image_of(path):
    """Of raw NRRD files as averaged.py writes them, with samples one unit apart."""
    with open(path, "rb") as file:
        header, samples = file.read().split(b"\n\n", 1)
    fields = dict(line.split(b": ", 1) for line in header.split(b"\n") if b": " in line)
    image = vtk.vtkImageData()
    image.SetDimensions([int(word) for word in fields[b"sizes"].split()])
    image.GetPointData().SetScalars(numpy_to_vtk(numpy.frombuffer(samples, "<i2"), deep=True))
    return image


def volume_of(image):
    opacity = vtk.vtkPiecewiseFunction()
    for value, at in OPACITIES:
        opacity.AddPoint(value, at)
    color = vtk.vtkColorTransferFunction()
    color.AddRGBPoint(LEVEL - WINDOW / 2, 0, 0, 0)
    color.AddRGBPoint(LEVEL + WINDOW / 2, 1, 1, 1)
    look = vtk.vtkVolumeProperty()
    look.SetColor(color)
    look.SetScalarOpacity(opacity)
    look.SetScalarOpacityUnitDistance(1)
    look.SetInterpolationTypeToLinear()
    look.ShadeOn()
    look.SetAmbient(0.3)
    look.SetDiffuse(0.75)
    look.SetSpecular(0.18)
    look.SetSpecularPower(24)
    mapper = vtk.vtkGPUVolumeRayCastMapper()
    mapper.SetInputData(image)
    mapper.AutoAdjustSampleDistancesOff()
    mapper.SetSampleDistance(0.25)
    volume = vtk.vtkVolume()
    volume.SetMapper(mapper)
    volume.SetProperty(look)
    return volume


def rendered(image, eye, target, size):
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(0, 0, 0)
    renderer.AddVolume(volume_of(image))
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetMultiSamples(0)
    window.SetSize(*size)
    window.AddRenderer(renderer)
    camera = renderer.GetActiveCamera()
    camera.SetViewAngle(FIELD_OF_VIEW)
    camera.SetViewUp(0, 0, 1)
    camera.SetPosition(*eye)
    camera.SetFocalPoint(*target)
    renderer.ResetCameraClippingRange()
    window.Render()
    grabbed = vtk.vtkWindowToImageFilter()
    grabbed.SetInput(window)
    grabbed.ReadFrontBufferOff()
    grabbed.Update()
    pixels = vtk_to_numpy(grabbed.GetOutput().GetPointData().GetScalars())
    return pixels.reshape(size[1], size[0], -1)[::-1, :, :3]


def ranks(values):
    return numpy.argsort(numpy.argsort(values)).astype(float)


def compared(ours, theirs):
    """Brightness of two pictures, in whose upper corners is nothing; the viewer's legend lies at the bottom."""
    ours, theirs = (picture[: picture.shape[0] * 7 // 8] for picture in (ours, theirs))
    differs = [numpy.abs(picture - picture[0, 0]) > 20 for picture in (ours, theirs)]
    both = differs[0] & differs[1]
    correlation = numpy.corrcoef(ranks(ours[both]), ranks(theirs[both]))[0, 1]
    return {"silhouettes_in_common": float(both.sum() / (differs[0] | differs[1]).sum()), "rank_correlation": float(correlation)}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("volume")
    parser.add_argument("viewer", nargs="?", help="the viewer's picture; without it, its address is printed")
    parser.add_argument("--dataset", default="volume", help="the name in the address")
    parser.add_argument("--eye", type=float, nargs=3, required=True)
    parser.add_argument("--target", type=float, nargs=3, required=True)
    parser.add_argument("-o", "--output")
    arguments = parser.parse_args()
    if not arguments.viewer:
        return print(address(arguments.dataset, arguments.eye, arguments.target))
    ours = numpy.asarray(Image.open(arguments.viewer).convert("L"), dtype=float)
    picture = rendered(image_of(arguments.volume), arguments.eye, arguments.target, ours.shape[::-1])
    Image.fromarray(picture).save(arguments.output)
    theirs = numpy.asarray(Image.fromarray(picture).convert("L"), dtype=float)
    report = compared(ours, theirs)
    print(json.dumps({**report, "renderer": "VTK " + vtk.vtkVersion.GetVTKVersion()}))


if __name__ == "__main__":
    main()
