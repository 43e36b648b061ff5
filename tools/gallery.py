#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-or-later
# Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
"""Makes the pictures of doc/gallery.md: runs a pair and a specimen, and draws them.

    tools/gallery.py OUT

Runs examples/pair_table once, and the scripts of examples/specimen once each, in OUT/pair and OUT/specimen: some minutes. What is finished is not
run again. Pictures are OUT/gallery_*.png, .jpg and .gif, of less than 150 kB each. Needs Debian's python3-numpy, python3-pandas,
python3-matplotlib, python3-pil, python3-vtk9 and, without a screen, xvfb.
"""
import argparse
import io
import os
import subprocess
import sys

sys.dont_write_bytecode = True  # leave the source tree as it is

try:
    import mpdem
    from PIL import Image
    from mpdem import figures, interface, movie, plots, run, runner, scene
except ImportError as missing:
    sys.exit(
        f"gallery.py: {missing}; apt-get install python3-numpy python3-pandas python3-matplotlib python3-pil python3-vtk9, "
        "run with /usr/bin/python3 and keep the folder tools/mpdem next to this script"
    )

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SPECIMEN = os.path.join(ROOT, "examples", "specimen")
SCRIPTS = (  # folder, script, variables
    ("pair", "pair_table/in.pair_table", {"content": "0.02", "spacing": "1.4e-4", "inner": "auto", "frames": "50"}),
    ("specimen", "specimen/in.pour", {"beads": "80"}),
    ("specimen", "specimen/in.cement", {"scatter": "0.5", "draw": "7"}),
    ("specimen", "specimen/in.load", {"speed": "0.05", "pictures": "5", "frames": "5", "weibull": "6", "draw": "7"}),
)
LARGEST = 150_000  # bytes of a picture
COLOURS = 160


def make(out, exe, ranks):
    for folder, script, variables in SCRIPTS:
        path, told = os.path.join(out, folder), os.path.join(out, folder, f"{os.path.basename(script)}.out")
        run.make_folder(path)
        if os.path.isfile(told) and "\nRESULT " in open(told, errors="replace").read():
            continue
        print(f"runs {script} in {path}", flush=True)
        words = {"here": SPECIMEN, **variables} if folder == "specimen" else variables
        environment = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", **os.environ}
        with open(told, "w") as f:
            command = runner.command(exe, os.path.join(ROOT, "examples", script), ranks, words)
            subprocess.run(command, cwd=path, stdout=f, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, env=environment)
        text = open(told, errors="replace").read()
        if "\nRESULT " not in text:
            raise run.Trouble(f"{told}: {runner.error_of(text) or 'the run did not end'}")


def write(fig, path, dpi=110):
    """A PNG of few colours, or a JPEG."""
    data = io.BytesIO()
    fig.savefig(data, dpi=dpi)
    figures.plt.close(fig)
    image = Image.open(data).convert("RGB")
    if path.endswith(".png"):
        image.quantize(COLOURS, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(path, optimize=True)
    else:
        image.save(path, quality=82, optimize=True)
    tell(path)


def tell(path):
    size = os.path.getsize(path)
    print(f"  written: {path}, {size / 1e3:.0f} kB", flush=True)
    if size > LARGEST:
        raise run.Trouble(f"{path}: larger than {LARGEST / 1e3:.0f} kB; draw it smaller")


def draw(out):
    pair, specimen = (mpdem.load(os.path.join(out, name)) for name in ("pair", "specimen"))
    curve = specimen.curves["curve"]
    peak = int(curve.loc[curve["force"].idxmax(), "step"])
    for name, fig in (
        ("interface", lambda: plots.interface(pair)),
        ("curve", lambda: plots.curve(specimen)),
        ("content", lambda: plots.packing(specimen)),
        ("strength", lambda: plots.packing(specimen, "strength_factor")),
        ("chains", lambda: plots.force_chains(specimen, peak)),
        ("fragments", lambda: plots.fragments(specimen)),
    ):
        write(fig(), os.path.join(out, f"gallery_{name}.png"))
    shots = scene.steps(specimen.folder)
    shown = [min(shots, key=lambda s: abs(s - peak)), shots[-1]]
    write(scene.panels(specimen.folder, shown, ["at the peak", "past the peak"]), os.path.join(out, "gallery_specimen.jpg"), 120)
    bond = run.read_bonds(run.find_bond_file(pair.folder, None))[0]
    interface.follow_load(pair.folder, bond)
    dumps = run.find_dumps(pair.folder, None, bond)
    steps = movie.choose(bond, sorted(dumps), 14, 1.1)
    path = os.path.join(out, "gallery_bond.gif")
    movie.write(movie.draw(bond, {s: dumps[s] for s in steps}, 0.005, 40.0), path, 120, 2500)
    tell(path)


def main():
    p = argparse.ArgumentParser(description="Makes the pictures of doc/gallery.md.")
    p.add_argument("out", metavar="OUT", help="folder of the runs and pictures")
    p.add_argument("--ranks", metavar="N", type=runner.at_least_one, default=1, help="ranks of a run (1)")
    p.add_argument("--exe", metavar="FILE", default=os.path.join(ROOT, "build", "liggghts-mpdem"), help="the executable")
    args = p.parse_args()
    runner.check_executable(args)
    scene.on_a_screen()
    make(os.path.abspath(args.out), os.path.abspath(args.exe), args.ranks)
    draw(args.out)


if __name__ == "__main__":
    run.end_with_message("gallery.py", main)
