#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Picture of beads and cement from the files of `dump custom/vtk`, with VTK, as ParaView would draw them.

    tools/vtk_picture.py RUN_DIR PICTURE.png --steps 352000,355000 --titles 'before the peak,past the peak'

For each step it reads beads_STEP.vtk (radius), cement_STEP.vtk (radius, c_damage, c_failed) and, if it is there,
plate_STEP.vtk, see doc/howto_pictures.md. Needs Debian's python3-vtk9 and, without a screen, xvfb:
xvfb-run --auto-servernum tools/vtk_picture.py ...
"""
import argparse
import os
import sys

try:
    from vtkmodules.vtkCommonColor import vtkNamedColors
    from vtkmodules.vtkCommonCore import vtkLookupTable
    from vtkmodules.vtkFiltersCore import vtkGlyph3D, vtkThreshold
    from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
    from vtkmodules.vtkFiltersSources import vtkSphereSource
    from vtkmodules.vtkIOImage import vtkPNGWriter
    from vtkmodules.vtkIOLegacy import vtkDataSetReader
    from vtkmodules.vtkRenderingAnnotation import vtkScalarBarActor
    from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkRenderer, vtkRenderWindow, vtkTextActor, vtkWindowToImageFilter
    import vtkmodules.vtkRenderingFreeType  # noqa: F401
    import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
except ImportError as missing:
    sys.exit(f"vtk_picture.py: {missing}; apt-get install python3-vtk9, run with /usr/bin/python3")

WIDTH, HEIGHT, BAR = 800, 1000, 150  # pixels of a panel, and of the strip with the colour bar
COLOURS = vtkNamedColors()


def read(folder, name, step, arrays):
    """The points of a file with all their arrays, of which `arrays` must be there."""
    path = os.path.join(folder, f"{name}_{step}.vtk")
    if not os.path.isfile(path):
        sys.exit(f"vtk_picture.py: {path}: no such file; write it with 'dump ID group custom/vtk N {name}_*.vtk id radius ...'")
    reader = vtkDataSetReader()
    reader.SetFileName(path)
    reader.ReadAllScalarsOn()
    reader.ReadAllFieldsOn()
    reader.Update()
    data = reader.GetOutput()
    lacking = [a for a in arrays if data.GetPointData().GetArray(a) is None]
    if lacking:
        sys.exit(f"vtk_picture.py: {path}: no array {', '.join(lacking)}; add it to the dump, c_NAME is a compute mpm/atom of that ID")
    return data


def spheres(data, sides):
    """A sphere of its radius at each point: ParaView's filter Glyph."""
    source = vtkSphereSource()
    source.SetRadius(1.0)
    source.SetThetaResolution(sides)
    source.SetPhiResolution(sides)
    data.GetPointData().SetActiveScalars("radius")
    glyph = vtkGlyph3D()
    glyph.SetInputData(data)
    glyph.SetSourceConnection(source.GetOutputPort())
    glyph.SetScaleModeToScaleByScalar()
    glyph.SetScaleFactor(1.0)
    glyph.Update()
    return glyph.GetOutput()


def part(data, array, low, high):
    """The points whose array lies between two values: ParaView's filter Threshold."""
    threshold = vtkThreshold()
    threshold.SetInputData(data)
    threshold.SetInputArrayToProcess(0, 0, 0, 0, array)
    threshold.SetLowerThreshold(low)
    threshold.SetUpperThreshold(high)
    surface = vtkGeometryFilter()
    surface.SetInputConnection(threshold.GetOutputPort())
    surface.Update()
    return surface.GetOutput()


def actor(data, colour, opacity=1.0):
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(data)
    mapper.ScalarVisibilityOff()
    shown = vtkActor()
    shown.SetMapper(mapper)
    shown.GetProperty().SetColor(COLOURS.GetColor3d(colour))
    shown.GetProperty().SetOpacity(opacity)
    return shown


def map_of_damage():
    """From blue, sound, over yellow."""
    table = vtkLookupTable()
    table.SetHueRange(0.62, 0.10)
    table.SetSaturationRange(0.75, 1.0)
    table.SetValueRange(0.75, 1.0)
    table.SetTableRange(0.0, 1.0)
    table.Build()
    return table


def panel(renderer, folder, step, title, table):
    beads = read(folder, "beads", step, ["radius"])
    cement = read(folder, "cement", step, ["radius", "c_damage", "c_failed"])
    renderer.SetBackground(1.0, 1.0, 1.0)
    renderer.AddActor(actor(spheres(beads, 40), "LightSlateGray", 0.16))
    sound = spheres(part(cement, "c_failed", -0.5, 0.5), 6)
    shown = actor(sound, "White")
    sound.GetPointData().SetActiveScalars("c_damage")
    shown.GetMapper().ScalarVisibilityOn()
    shown.GetMapper().SetLookupTable(table)
    shown.GetMapper().SetScalarRange(0.0, 1.0)
    renderer.AddActor(shown)
    renderer.AddActor(actor(spheres(part(cement, "c_failed", 0.5, 1.5), 6), "Crimson"))
    if os.path.isfile(os.path.join(folder, f"plate_{step}.vtk")):
        renderer.AddActor(actor(read_plate(folder, step), "DarkGray", 0.35))
    words = vtkTextActor()
    words.SetInput(title)
    words.SetPosition(20, 20)
    words.GetTextProperty().SetColor(0.0, 0.0, 0.0)
    words.GetTextProperty().SetFontSize(26)
    renderer.AddActor(words)
    view(renderer, beads.GetBounds())


def read_plate(folder, step):
    surface = vtkGeometryFilter()
    surface.SetInputData(read(folder, "plate", step, []))
    surface.Update()
    return surface.GetOutput()


def view(renderer, bounds):
    """From the side, a little from above; the beads fill the height."""
    middle = [0.5 * (bounds[2 * i] + bounds[2 * i + 1]) for i in range(3)]
    high = bounds[5] - bounds[4]
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    camera.SetFocalPoint(*middle)
    camera.SetPosition(middle[0] + 0.25, middle[1] - 1.0, middle[2] + 0.12)
    camera.SetViewUp(0.0, 0.0, 1.0)
    camera.SetParallelScale(0.66 * high)
    renderer.ResetCameraClippingRange()


def legend(renderer, table):
    renderer.SetBackground(1.0, 1.0, 1.0)
    bar = vtkScalarBarActor()
    bar.SetLookupTable(table)
    bar.SetNumberOfLabels(6)
    bar.SetLabelFormat("%.1f")
    bar.SetVerticalTitleSeparation(12)
    bar.SetBarRatio(0.25)
    bar.SetTitle("largest damage of a point of the cement (–); crimson: failed points; grey: beads")
    bar.SetOrientationToHorizontal()
    bar.SetPosition(0.1, 0.02)
    bar.SetPosition2(0.8, 0.9)
    bar.UnconstrainedFontSizeOn()
    for text in (bar.GetTitleTextProperty(), bar.GetLabelTextProperty()):
        text.SetColor(0.0, 0.0, 0.0)
        text.SetFontSize(22)
        text.ItalicOff()
        text.BoldOff()
        text.ShadowOff()
    renderer.AddActor(bar)


def main():
    p = argparse.ArgumentParser(description="Picture of beads and cement from the files of dump custom/vtk.")
    p.add_argument("folder", metavar="RUN_DIR")
    p.add_argument("picture", metavar="PICTURE.png")
    p.add_argument("--steps", metavar="N,M", required=True, help="steps, a panel each")
    p.add_argument("--titles", metavar="A,B", help="of the panels (default: the steps)")
    args = p.parse_args()
    steps = args.steps.split(",")
    titles = args.titles.split(",") if args.titles else [f"step {s}" for s in steps]
    if len(titles) != len(steps):
        sys.exit(f"vtk_picture.py: {len(titles)} titles for {len(steps)} steps; give as many")
    table, window = map_of_damage(), vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetAlphaBitPlanes(1)
    window.SetMultiSamples(0)
    window.SetSize(WIDTH * len(steps), HEIGHT + BAR)
    foot = BAR / (HEIGHT + BAR)
    for i, (step, title) in enumerate(zip(steps, titles)):
        renderer = vtkRenderer()
        renderer.SetViewport(i / len(steps), foot, (i + 1) / len(steps), 1.0)
        renderer.SetUseDepthPeeling(1)
        renderer.SetMaximumNumberOfPeels(30)
        window.AddRenderer(renderer)
        panel(renderer, args.folder, step, title, table)
    renderer = vtkRenderer()
    renderer.SetViewport(0.0, 0.0, 1.0, foot)
    window.AddRenderer(renderer)
    legend(renderer, table)
    window.Render()
    image = vtkWindowToImageFilter()
    image.SetInput(window)
    image.ReadFrontBufferOff()
    image.Update()
    writer = vtkPNGWriter()
    writer.SetFileName(args.picture)
    writer.SetInputConnection(image.GetOutputPort())
    writer.Write()
    print(f"written: {args.picture}")


if __name__ == "__main__":
    main()
