# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Beads and cement in space, drawn by VTK from the files of `dump custom/vtk`, as ParaView would draw them: pictures as arrays of pixels.

Needs Debian's python3-vtk9, and a screen: `on_a_screen` makes one of Debian's xvfb where there is none."""
import glob
import os
import re
import shutil
import sys
from typing import Any, Dict, List, Optional, Sequence, Tuple

import numpy as np
from matplotlib.colors import to_rgb
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkLookupTable
from vtkmodules.vtkFiltersCore import vtkGlyph3D, vtkThreshold
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.vtkFiltersSources import vtkCubeSource, vtkSphereSource
from vtkmodules.vtkIOLegacy import vtkDataSetReader
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkRenderer, vtkRenderWindow, vtkWindowToImageFilter
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401

from . import figures
from .tables import Trouble

BEAD, PLATE = "#8793a3", "#d5d5d5"
DAMAGE = "c_damage"


def on_a_screen() -> None:
    """Starts the program again under xvfb-run if there is no screen."""
    if os.environ.get("DISPLAY") or sys.platform != "linux":
        return
    if not shutil.which("xvfb-run"):
        raise Trouble("no screen (DISPLAY is not set), and no xvfb-run; apt-get install xvfb xauth")
    sys.stdout.flush()
    os.execvp("xvfb-run", ["xvfb-run", "--auto-servernum", sys.executable, *sys.argv])


def steps(folder: str) -> List[int]:
    """Steps of which there are files of beads and of cement."""
    found = [
        {int(m[1]) for p in glob.glob(os.path.join(glob.escape(folder), f"{name}_*.vtk")) if (m := re.search(rf"{name}_(\d+)\.vtk$", p))}
        for name in ("beads", "cement")
    ]
    if not found[0] & found[1]:
        path = os.path.join(folder, "beads_*.vtk")
        raise Trouble(f"{path}: no such files with cement_*.vtk beside them; write them with 'dump ID group custom/vtk N beads_*.vtk id radius'")
    return sorted(found[0] & found[1])


def read(folder: str, name: str, step: int, arrays: Sequence[str]) -> Any:
    """The points of a file with all their arrays, of which `arrays` must be there."""
    path = os.path.join(folder, f"{name}_{step}.vtk")
    if not os.path.isfile(path):
        raise Trouble(f"{path}: no such file; write it with 'dump ID group custom/vtk N {name}_*.vtk id radius ...'")
    reader = vtkDataSetReader()
    reader.SetFileName(path)
    reader.ReadAllScalarsOn()
    reader.ReadAllFieldsOn()
    reader.Update()
    data = reader.GetOutput()
    lacking = [a for a in arrays if data.GetPointData().GetArray(a) is None]
    if lacking:
        raise Trouble(f"{path}: no array {', '.join(lacking)}; add it to the dump, c_NAME is a compute mpm/atom of that ID")
    return data


def spheres(data: Any, sides: int) -> Any:
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


def part(data: Any, array: str, low: float, high: float) -> Any:
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


def actor(data: Any, colour: str, opacity: float = 1.0) -> Any:
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(data)
    mapper.ScalarVisibilityOff()
    shown = vtkActor()
    shown.SetMapper(mapper)
    shown.GetProperty().SetColor(*to_rgb(colour))
    shown.GetProperty().SetOpacity(opacity)
    shown.GetProperty().SetAmbient(0.3)
    shown.GetProperty().SetDiffuse(0.8)
    return shown


def lookup(low: float, high: float) -> Any:
    """The colours of the figures."""
    shades = figures.plt.get_cmap(figures.MAP)
    table = vtkLookupTable()
    table.SetNumberOfTableValues(256)
    table.SetTableRange(low, high)
    table.Build()
    for i in range(256):
        table.SetTableValue(i, *shades(i / 255))
    return table


def span(folder: str, at: Sequence[int], column: str) -> Tuple[float, float]:
    """Least and largest value of a column of the points that have not failed; of damage 0 and 1."""
    if column == DAMAGE:
        return 0.0, 1.0
    values = []
    for step in at:
        data = read(folder, "cement", step, ["c_failed", column]).GetPointData()
        found = vtk_to_numpy(data.GetArray(column))
        values.append(found[vtk_to_numpy(data.GetArray("c_failed")) < 0.5])
    every = np.concatenate(values) if values else np.zeros(1)
    return (float(every.min()), float(every.max())) if every.size else (0.0, 1.0)


class Scene:
    """Draws steps of one run from one direction. bounds: of the beads, which fill the height."""

    def __init__(self, folder: str, column: str = DAMAGE, limits: Tuple[float, float] = (0.0, 1.0), size: Tuple[int, int] = (640, 800)):
        self.folder, self.column, self.limits, self.size = folder, column, limits, size
        self.bounds: Optional[Tuple[float, ...]] = None
        self.window = vtkRenderWindow()
        self.window.SetOffScreenRendering(1)
        self.window.SetAlphaBitPlanes(1)
        self.window.SetMultiSamples(0)
        self.window.SetSize(*size)

    def draw(self, step: int) -> np.ndarray:
        """Pixels (height, width, 3) of a step. The view is that of the first one that is drawn."""
        renderer = vtkRenderer()
        renderer.SetBackground(1.0, 1.0, 1.0)
        renderer.SetUseDepthPeeling(1)
        renderer.SetMaximumNumberOfPeels(12)
        beads = read(self.folder, "beads", step, ["radius"])
        cement = read(self.folder, "cement", step, ["radius", "c_failed", self.column])
        renderer.AddActor(actor(spheres(beads, 24), BEAD, 0.10))
        sound = spheres(part(cement, "c_failed", -0.5, 0.5), 6)
        if sound.GetNumberOfPoints():
            shown = actor(sound, "white")
            sound.GetPointData().SetActiveScalars(self.column)
            shown.GetMapper().ScalarVisibilityOn()
            shown.GetMapper().SetLookupTable(lookup(*self.limits))
            shown.GetMapper().SetScalarRange(*self.limits)
            renderer.AddActor(shown)
        renderer.AddActor(actor(spheres(part(cement, "c_failed", 0.5, 1.5), 6), figures.BROKEN))
        self.bounds = self.bounds or spheres(beads, 12).GetBounds()
        if os.path.isfile(os.path.join(self.folder, f"plate_{step}.vtk")):
            renderer.AddActor(actor(self._plate(step), PLATE, 0.6))
        self._view(renderer)
        self.window.AddRenderer(renderer)
        self.window.Render()
        image = vtkWindowToImageFilter()
        image.SetInput(self.window)
        image.ReadFrontBufferOff()
        image.Update()
        found = image.GetOutput()
        wide, high, _ = found.GetDimensions()
        pixels = vtk_to_numpy(found.GetPointData().GetScalars()).reshape(high, wide, -1)[::-1, :, :3].copy()
        self.window.RemoveRenderer(renderer)
        return pixels

    def _plate(self, step: int) -> Any:
        """As wide as the beads: the mesh of the wall is much larger."""
        assert self.bounds
        z = read(self.folder, "plate", step, []).GetBounds()[5]
        cube = vtkCubeSource()
        cube.SetBounds(*self.bounds[:4], z, z + 0.015 * (self.bounds[5] - self.bounds[4]))
        cube.Update()
        return cube.GetOutput()

    def _view(self, renderer: Any) -> None:
        """From the side, a little from above."""
        assert self.bounds
        low, high = np.array(self.bounds[::2]), np.array(self.bounds[1::2])
        middle = 0.5 * (low + high)
        camera = renderer.GetActiveCamera()
        camera.ParallelProjectionOn()
        camera.SetFocalPoint(*middle)
        camera.SetPosition(middle[0] + 0.25, middle[1] - 1.0, middle[2] + 0.12)
        camera.SetViewUp(0.0, 0.0, 1.0)
        camera.SetParallelScale(0.58 * (high[2] - low[2]))
        renderer.ResetCameraClippingRange()


def key(fig: Any, place: Tuple[float, float], words: str, limits: Tuple[float, float], wide: float = 0.4, plate: bool = True) -> None:
    """Colour bar and legend below pictures. place: of the middle of both, as shares of the figure."""
    high = fig.get_figheight()
    bar = fig.add_axes([place[0] - 0.5 * wide, place[1], wide, 0.09 / high])
    shades = figures.plt.cm.ScalarMappable(figures.plt.Normalize(*limits), figures.MAP)
    fig.colorbar(shades, cax=bar, orientation="horizontal")
    bar.set_xlabel(words, labelpad=1)
    patches: Dict[str, Tuple[str, float]] = {"failed points": (figures.BROKEN, 1.0), "beads": (BEAD, 0.35)}
    if plate:
        patches["plate"] = (PLATE, 1.0)
    handles = [figures.Patch(fc=(*to_rgb(c), a), ec="0.6", lw=0.4, label=name) for name, (c, a) in patches.items()]
    fig.legend(handles=handles, loc="lower center", bbox_to_anchor=(place[0], 0.0), ncol=3, frameon=False)


WORDS = {
    "c_damage": "largest damage of a point (–)",
    "c_stress": "largest principal stress (Pa)",
    "c_bond": "number of the bond",
    "c_material": "number of the material",
}


@figures.styled
def panels(folder: str, at: Sequence[int], titles: Sequence[str], column: str = DAMAGE, words: str = "") -> Any:
    """A figure with a panel for each step."""
    limits = span(folder, at, column)
    drawn = Scene(folder, column, limits)
    wide, high, foot = 3.2, 4.0, 0.75
    fig = figures.plt.figure(figsize=(wide * len(at), high + 0.3 + foot))
    for i, (step, title) in enumerate(zip(at, titles)):
        ax = fig.add_axes([i / len(at), foot / fig.get_figheight(), 1 / len(at), high / fig.get_figheight()])
        ax.imshow(drawn.draw(step), interpolation="lanczos")
        ax.set_title(title, pad=3)
        ax.axis("off")
    plate = all(os.path.isfile(os.path.join(folder, f"plate_{s}.vtk")) for s in at)
    key(fig, (0.5, 0.55 / fig.get_figheight()), words or WORDS.get(column, column[2:].replace("_", " ")), limits, min(0.7, 2.4 / fig.get_figwidth()), plate)
    return fig
