#!/usr/bin/env pvpython
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Opens beads and cement of a specimen in ParaView, as doc/howto_pictures.md tells by hand: a picture, and a state file for the program.

    pvpython tools/paraview_picture.py RUN_DIR PICTURE.png [--step N] [--column c_damage] [--state STATE.pvsm]

Reads beads_*.vtk (radius) and cement_*.vtk (radius, c_failed, the column). Needs ParaView, Debian's python3-paraview
for instance, and, without a screen, xvfb: xvfb-run --auto-servernum pvpython ...
"""
import argparse
import glob
import os
import re
import sys

try:
    from paraview import simple as pv
except ImportError as missing:
    sys.exit(f"paraview_picture.py: {missing}; apt-get install python3-paraview, run with pvpython")

WORDS = {"c_damage": "largest damage of a point", "c_stress": "largest principal stress (Pa)", "c_bond": "number of the bond"}


def series(folder, name):
    """The files of a group, by step."""
    found = {int(m[1]): p for p in glob.glob(os.path.join(glob.escape(folder), f"{name}_*.vtk")) if (m := re.search(rf"{name}_(\d+)\.vtk$", p))}
    return dict(sorted(found.items()))


def balls(source, colour, opacity, sides):
    glyph = pv.Glyph(Input=source, GlyphType="Sphere", GlyphMode="All Points")
    glyph.OrientationArray = ["POINTS", "No orientation array"]
    glyph.ScaleArray = ["POINTS", "radius"]
    glyph.ScaleFactor = 2.0  # ParaView's sphere has the radius 0.5
    glyph.GlyphType.ThetaResolution = glyph.GlyphType.PhiResolution = sides
    shown = pv.Show(glyph)
    shown.ColorArrayName = [None, ""]
    shown.AmbientColor = shown.DiffuseColor = colour
    shown.Opacity = opacity
    return shown


def part(source, low, high):
    threshold = pv.Threshold(Input=source, Scalars=["POINTS", "c_failed"])
    threshold.LowerThreshold, threshold.UpperThreshold = low, high
    return threshold


def main():
    p = argparse.ArgumentParser(description="Beads and cement of a specimen in ParaView.")
    p.add_argument("folder", metavar="RUN_DIR")
    p.add_argument("picture", metavar="PICTURE.png")
    p.add_argument("--step", metavar="N", type=int, help="default: the last")
    p.add_argument("--column", metavar="C", default="c_damage", help="array that colours the cement (c_damage)")
    p.add_argument("--state", metavar="FILE.pvsm", help="state file to write: File, Load State in ParaView")
    args = p.parse_args()
    groups = {name: series(args.folder, name) for name in ("beads", "cement")}
    steps = list(groups["beads"])
    if not steps or steps != list(groups["cement"]):
        sys.exit(f"paraview_picture.py: {args.folder}: no beads_*.vtk with a cement_*.vtk for each; write them with dump custom/vtk")
    step = steps[-1] if args.step is None else args.step
    if step not in steps:
        sys.exit(f"paraview_picture.py: {args.folder}: no files of step {step}; there are {steps[0]} to {steps[-1]}")
    view = pv.GetActiveViewOrCreate("RenderView")
    view.ViewSize = [900, 1000]
    view.OrientationAxesVisibility = 0
    pv.LoadPalette("WhiteBackground")
    sources = {name: pv.LegacyVTKReader(FileNames=[os.path.abspath(f) for f in files.values()]) for name, files in groups.items()}
    pv.GetAnimationScene().UpdateAnimationUsingDataTimeSteps()
    pv.GetAnimationScene().AnimationTime = steps.index(step)
    balls(sources["beads"], [0.53, 0.58, 0.64], 0.2, 24)
    sound = balls(part(sources["cement"], 0.0, 0.5), [1.0, 1.0, 1.0], 1.0, 6)
    pv.ColorBy(sound, ("POINTS", args.column))
    shades = pv.GetColorTransferFunction(args.column)
    shades.ApplyPreset("Viridis (matplotlib)", True)
    if args.column == "c_damage":
        shades.RescaleTransferFunction(0.0, 1.0)
    bar = pv.GetScalarBar(shades, view)
    bar.Title, bar.ComponentTitle = f"{WORDS.get(args.column, args.column)}; red: failed points", ""
    bar.RangeLabelFormat = bar.LabelFormat = "%.2g"
    bar.Orientation, bar.WindowLocation = "Horizontal", "Lower Center"
    sound.SetScalarBarVisibility(view, True)
    balls(part(sources["cement"], 0.5, 1.5), [0.91, 0.09, 0.17], 1.0, 6)
    view.ResetCamera()
    camera = view.GetActiveCamera()
    middle = camera.GetFocalPoint()
    camera.SetPosition(middle[0] + 0.25, middle[1] - 1.0, middle[2] + 0.12)
    camera.SetViewUp(0.0, 0.0, 1.0)
    view.CameraParallelProjection = 1
    view.ResetCamera()
    pv.Render()
    pv.SaveScreenshot(args.picture, view)
    print(f"written: {args.picture}, step {step}, ParaView {pv.GetParaViewVersion()}")
    if args.state:
        pv.SaveState(args.state)
        print(f"written: {args.state}")


if __name__ == "__main__":
    main()
