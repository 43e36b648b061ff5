# SPDX-License-Identifier: GPL-2.0-or-later
"""The Python package mpdem: what it reads of a pair and of a specimen is what their files have, with units; plain errors; figures; installation."""
import csv
import os
import re
import shutil
import subprocess
import sys
from math import gamma
from pathlib import Path

import numpy as np
import pytest
from scenes import launch

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tools"))
sys.dont_write_bytecode = True
matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")
pytest.importorskip("pandas")
import mpdem  # noqa: E402
from mpdem import plots, response, tables, units  # noqa: E402

SPECIMEN = ROOT / "examples" / "specimen"
FAST = {"cell": 5e-4, "speed": 0.2, "ramp": 2e-5, "record": 20, "frames": 5, "strain": 0.003, "beyond": 1.5, "pictures": 25}


def go(script, folder, **variables):
    words = [w for k, v in variables.items() for w in ("-var", k, str(v))]
    result = launch((ROOT / "examples" / script).read_text(), folder, name=Path(script).name, arguments=words)
    assert result.status == 0 and not result.errors(), result.output[-3000:]
    return result.output


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pair")
    go("pair_table/in.pair_table", folder, content=0.01, spacing=1.6e-4, inner="auto", frames=100)
    return folder


@pytest.fixture(scope="module")
def specimen(tmp_path_factory):
    folder = tmp_path_factory.mktemp("specimen")
    go("specimen/in.pour", folder, here=SPECIMEN, beads=40, settle=0.08, press=0.03)
    go("specimen/in.cement", folder, here=SPECIMEN, spacing=2.5e-4)
    go("specimen/in.load", folder, here=SPECIMEN, weibull=6, **FAST)
    return folder


def rows(path):
    with open(path, newline="") as f:
        return list(csv.DictReader(f))


def test_pair(pair):
    """Bonds, events, points and curves have every row and number of the files, and each column a unit."""
    run = mpdem.load(pair)
    bonds, events, load = (rows(pair / f"{n}_run.csv") for n in ("bond", "events", "load"))
    assert run.name == "run" and len(run.bonds) == len(bonds) > 50 and len(run.events) == len(events) > 100
    for table, lines in ((run.bonds, bonds), (run.events, events), (run.curves["load"], load)):
        assert list(table) == list(lines[0])
        for column in table:
            values = [r[column] for r in lines]
            assert list(table[column]) == (values if column == "mode" else [float(v) for v in values]), column
            assert mpdem.unit(table, column) or column == "mode", column
    assert (mpdem.unit(run.bonds, "tension"), mpdem.unit(run.bonds, "mx1"), mpdem.label(run.bonds, "gap")) == ("N", "N m", "gap (m)")
    assert mpdem.unit(run.curve, "load") == "N" and mpdem.unit(run.events, "theta") == "rad"
    assert run.result["mode"] == run.last_bonds["mode"].iloc[0] and run.result["steps"] == run.curve["step"].iloc[-1] == run.thermo["Step"].iloc[-1]
    assert run.thermo["Step"].is_monotonic_increasing and len(run.thermo) > 5
    last = run.points
    assert last.attrs["step"] == run.point_steps[-1] and len(last) == run.bonds["points"].iloc[-1]
    assert last["c_failed"].sum() == run.bonds["failed"][run.bonds["step"] == last.attrs["step"]].iloc[0] > 0
    assert list(run.points_at(0)["id"]) == list(last["id"]) and set(last.attrs["units"].values()) == {"1", "m"}
    assert run.bond(1).attrs["units"] == run.bonds.attrs["units"]


def test_specimen(specimen):
    """The tables of bonds go with the dumps and the curve: broken bonds, failed points, joined grains, contents."""
    run = mpdem.load(specimen)
    curve, last = run.curves["curve"], run.last_bonds
    assert len(curve) == len(rows(specimen / "curve.csv")) and mpdem.unit(curve, "force") == "N" and mpdem.unit(run.curves["response"], "q") == "Pa"
    at = run.grain_steps[-1]
    broken = curve["broken"][curve["step"] <= at].iloc[-1]
    assert 3 < (run.bonds_at(at)["separated"] > 0).sum() == pytest.approx(broken, abs=1)
    held = run.bonds_at(at)
    pieces = run.groups_at(at)
    for a, b in held[held["separated"] == 0][["grain1", "grain2"]].to_numpy():
        assert pieces[a] == pieces[b]
    assert (pieces.value_counts().sort_index().diff().dropna() <= 0).all() and len(pieces) == 40
    content = run.content()
    assert len(content) == len(last) and content.to_numpy() == pytest.approx(0.006, rel=1e-3)
    assert mpdem.unit(run.points, "c_stress") == "Pa" and mpdem.unit(run.points, "radius") == "m" and mpdem.unit(run.contacts_at(), "fx") == "N"
    assert run.result["test"] == "compression" and run.result["peak"] == pytest.approx(curve["force"][curve["stage"] == 1].max(), rel=1e-12)
    r = response.response({c: curve[c].to_numpy() for c in curve})
    assert np.array_equal(run.curves["response"]["q"], r["q"])


def test_scatter_of_a_specimen(specimen, figures):
    """`-var weibull 6` draws a factor on the strength for each bond: its mean and its scatter are those of the distribution."""
    factor = mpdem.load(specimen).last_bonds["strength_factor"].to_numpy()
    assert len(np.unique(factor)) == len(factor) > 40
    mean, square = gamma(1 + 1 / 6), gamma(1 + 2 / 6)
    spread = np.sqrt(square / mean**2 - 1)
    figures.below("strength factors of a specimen: mean off 1, over its standard error", abs(factor.mean() - 1) / (spread / np.sqrt(len(factor))), 3)
    figures.below("strength factors of a specimen: coefficient of variation off that of Weibull, over it", abs(factor.std() / spread - 1), 0.35)


def test_goes_on_from_checkpoints(tmp_path):
    """Rows after a checkpoint from which a loading went on are left out, as is the first mean after it."""
    head = "step,time,stage,way\n"
    (tmp_path / "curve.csv").write_text(head + "10,1,0,0\n20,2,1,1\n30,3,1,2\n")
    (tmp_path / "curve_from_20.csv").write_text(head + "25,9,1,9\n30,4,1,3\n40,5,1,4\n5")
    (tmp_path / "curve_from_40.csv").write_text(head)
    assert list(tables.whole(str(tmp_path), "curve")["way"]) == [0, 1, 3, 4]


def test_partly_written(pair, specimen, tmp_path):
    """A folder in which a run still writes is read up to the last whole line and the last whole dump, at any place where it may be cut."""
    whole = mpdem.load(pair)
    for share in (0.0, 0.02, 0.3, 0.7001, 0.999):
        folder = tmp_path / str(share)
        folder.mkdir()
        for path in pair.iterdir():
            data = path.read_bytes()
            if path.suffix in (".csv", ".txt", ".liggghts") and path.name != "points_run.0.txt":
                data = data[: int(share * len(data))]
            (folder / path.name).write_bytes(data)
        run = mpdem.load(folder)
        if share == 0.0:
            with pytest.raises(mpdem.Trouble, match=r"bond_run.csv: empty; let the run get past its setup"):
                run.bonds
            continue
        for name in ("bonds", "events"):
            table, all_rows = getattr(run, name), getattr(whole, name)
            assert len(table) <= len(all_rows) and table.equals(all_rows.iloc[: len(table)].astype(dict(table.dtypes))), (share, name)
        assert run.points.attrs["step"] == 0 and list(run.curve) == list(whole.curve) and len(run.thermo) <= len(whole.thermo)


def test_driver(pair, tmp_path):
    """The folder of a driver has its table, and its runs by their labels."""
    (tmp_path / "flat,tension,0.01").mkdir()
    for path in pair.glob("*.csv"):
        shutil.copy(path, tmp_path / "flat,tension,0.01")
    shutil.copy(ROOT / "doc" / "data" / "study_strength.csv", tmp_path / "table.csv")
    (tmp_path / "flat,tension,0.01" / "begun.json").write_text("{}")
    out = mpdem.load(tmp_path)
    assert list(out.runs) == ["flat,tension,0.01"] and len(out.runs["flat,tension,0.01"].bonds) > 50
    table = out.summaries["table"]
    assert len(table) == 48 and mpdem.unit(table, "peak") == "N" and table["shape"].iloc[0] == "flat"


@pytest.mark.parametrize(
    "files, ask, message",
    [
        ({}, None, "has no bond.*name the folder"),
        ({"bond_a.csv": "step\n", "bond_b.csv": "step\n"}, None, r"holds several runs \(a, b\); choose one with name="),
        ({"events.csv": "step,mode\n"}, "bonds", "no bond.csv; write it with 'fix mpm/couple ... csv"),
        ({"bond.csv": "step,bond\n1,2\n3\n"}, "bonds", "line 3 is not a row of 2 values; delete that line"),
        ({"bond.csv": "step,bond\n1,x\n"}, "bonds", "line 2 is not a row of numbers: bond is 'x'"),
        ({"bond.csv": "step,bond\n"}, "points", "no dumps of the cement; there are none"),
        ({"points.0.txt": "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: ATOMS id x\n1 2\n"}, "points", "points.0.txt: cut short, 2 lines announced"),
        ({"points.0.txt": "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS id x\n1 b\n"}, "points", "points.0.txt: cut short"),
        ({"log.liggghts": "nothing\n"}, "curve", "no load.*curve.csv or thermo output"),
        ({"log.liggghts": "nothing\n"}, "cement", "no point file; write one with write_cement"),
    ],
)
def test_what_is_wrong_is_said(files, ask, message, tmp_path):
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    with pytest.raises(mpdem.Trouble, match=message) as trouble:
        getattr(mpdem.load(tmp_path), ask)
    assert "\n" not in str(trouble.value)


def test_no_folder(tmp_path):
    with pytest.raises(mpdem.Trouble, match="no such folder; name the folder of the run's output"):
        mpdem.load(tmp_path / "none")


def test_units_of_the_pages():
    """Units are those of the pages: columns of the table of bonds, of events, of the curve of a specimen."""
    page = (ROOT / "doc" / "fix_mpm_couple.md").read_text()
    names = dict(re.findall(r"^\| (\d+) \| `(\w+)` \|", page, re.M))
    units_of = {}
    for numbers, unit in re.findall(r"^\| ([\d, -]+) \| (N m|N|m|J) \|$", page, re.M):
        for part in numbers.split(","):
            low, _, high = part.strip().partition("-")
            units_of.update({names[str(n)]: unit for n in range(int(low), int(high or low) + 1)})
    assert len(names) == 43 and len(units_of) == 23
    known = {n: u for u, of in units.UNITS["bonds"].items() for n in of.split()}
    assert {n: units_of.get(n, "1") for n in names.values()} == {n: known[n] for n in names.values()}


def test_another_unit_style(tmp_path):
    """Of a script in other units only numbers have a unit that is known."""
    (tmp_path / "log.liggghts").write_text("units  cgs\n")
    (tmp_path / "bond.csv").write_text("step,bond,tension\n1,1,2\n")
    table = mpdem.load(tmp_path).bonds
    assert table.attrs["unit_style"] == "cgs" and (mpdem.unit(table, "tension"), mpdem.unit(table, "step")) == ("", "1")


def words_of(fig):
    texts = [t.get_text() for t in fig.findobj(matplotlib.text.Text)]
    legends = [t.get_text() for ax in fig.axes if ax.get_legend() for t in ax.get_legend().get_texts()]
    return texts + legends + [t.get_text() for legend in fig.legends for t in legend.get_texts()]


@pytest.mark.parametrize(
    "draw, of, expected",
    [
        (lambda r: plots.force_displacement(r), "pair", ["force (N)", "displacement (µm)"]),
        (lambda r: plots.damage_cut(r), "pair", ["largest damage (–)", "failed points"]),
        (lambda r: plots.interface(r), "pair", ["time of debonding (µs)", "x (mm)"]),
        (lambda r: plots.curve(r), "pair", ["way (m)", "load (N)"]),
        (lambda r: plots.compare({"one": r, "another": r}), "pair", ["one", "another", "load (N)"]),
        (lambda r: plots.curve(r), "specimen", ["axial strain (%)", "volume strain, dilation upward (%)", "broken bonds, by where they broke"]),
        (lambda r: plots.packing(r), "specimen", ["bond content (%)", "bonds"]),
        (lambda r: plots.packing(r, "strength_factor"), "specimen", ["factor on the strength"]),
        (lambda r: plots.packing(r, "material"), "specimen", ["number of the material, 0: that of fix mpm"]),
        (lambda r: plots.packing(r, "tension", r.grain_steps[len(r.grain_steps) // 2]), "specimen", ["force along the line of centres, tension positive (N)"]),
        (lambda r: plots.force_chains(r, r.grain_steps[2]), "specimen", ["tension", "compression", "forces of the contacts"]),
        (lambda r: plots.fragments(r), "specimen", ["bonds separated", "grains"]),
    ],
)
def test_figures(draw, of, expected, request, tmp_path):
    """Each figure is one of matplotlib, has its legend in words and units, and leaves the caller's style as it was."""
    before = dict(matplotlib.rcParams)
    fig = draw(mpdem.load(request.getfixturevalue(of)))
    assert dict(matplotlib.rcParams) == before
    words = words_of(fig)
    assert all(any(e in w for w in words) for e in expected), words
    assert not [w for w in words if "_" in w and "$" not in w], words
    fig.savefig(tmp_path / "x.png", dpi=80)
    assert (tmp_path / "x.png").stat().st_size > 5000
    matplotlib.pyplot.close(fig)


@pytest.mark.parametrize(
    "draw, message",
    [
        (lambda r: plots.force_displacement(r, 7), "no bond 7"),
        (lambda r: plots.interface(r, grain=9), "grain 9 is none of bond 1; take 1 or 2"),
        (lambda r: plots.curve(r, "way", "force"), "no column 'force' of the curve; there are step, time, way, load"),
        (lambda r: plots.packing(r), "no dumps of the grains"),
    ],
)
def test_figures_that_cannot_be(draw, message, pair):
    with pytest.raises(mpdem.Trouble, match=message):
        draw(mpdem.load(pair))


def test_picture_tool(specimen, tmp_path):
    """tools/mpdem_picture.py draws each figure by its name; what is wrong is one line."""
    tool = ["/usr/bin/python3", ROOT / "tools" / "mpdem_picture.py", specimen]
    for words in (["packing", "a.png", "--column", "tension", "--step", "peak"], ["curve", "b.svg"], ["fragments", "c.pdf"]):
        done = subprocess.run([*tool, *words], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0 and (tmp_path / words[1]).stat().st_size > 5000, done.stderr
    for words, message in ((["interface", "d.png"], "no column"), (["packing", "d.png", "--column", "x"], "no column 'x' of the bonds")):
        done = subprocess.run([*tool, *words], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 1 and message in done.stderr and len(done.stderr.splitlines()) == 1, done.stderr


def frames_of(path):
    """Number of frames, width and height of a film."""
    words = ["ffprobe", "-v", "error", "-count_frames", "-select_streams", "v:0", "-show_entries", "stream=nb_read_frames,width,height", "-of", "csv=p=0"]
    wide, high, count = subprocess.run([*words, path], capture_output=True, text=True, check=True).stdout.strip().split(",")[:3]
    return int(count), int(wide), int(high)


@pytest.mark.parametrize("name, least", [("a.gif", 8), ("a.mp4", 8), ("a.webm", 8)])
def test_movie_of_a_bond(name, least, pair, tmp_path):
    """From the dumps of all points of examples/pair_table, by one command, as GIF or film."""
    if not name.endswith("gif") and not shutil.which("ffmpeg"):
        pytest.skip("needs ffmpeg")
    done = subprocess.run(["/usr/bin/python3", ROOT / "tools" / "mpdem_movie.py", pair, "--out", tmp_path / name], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    told = int(re.search(r"(\d+) frames", done.stdout)[1])
    assert told >= least and (tmp_path / name).stat().st_size > 10000
    if not name.endswith("gif"):
        count, wide, high = frames_of(tmp_path / name)
        assert count >= told and wide == 792 and high == 302


@pytest.mark.skipif(not shutil.which("xvfb-run") or not shutil.which("ffmpeg"), reason="needs xvfb and ffmpeg")
def test_movie_and_picture_of_a_specimen(specimen, tmp_path):
    """Without a screen, by one command each: frames beside the curve; panels. What is missing is said in one line."""
    environment = {k: v for k, v in os.environ.items() if k != "DISPLAY"}

    def tool(name, *words):
        return subprocess.run(["/usr/bin/python3", ROOT / "tools" / name, *words], capture_output=True, text=True, env=environment)

    done = tool("mpdem_movie.py", specimen, "--out", tmp_path / "a.mp4", "--frames", "3")
    assert done.returncode == 0, done.stderr
    count, wide, high = frames_of(tmp_path / "a.mp4")
    assert count >= 3 and (wide, high) == (792, 450)
    done = tool("vtk_picture.py", specimen, tmp_path / "a.png", "--dpi", "80", "--column", "c_stress")
    assert done.returncode == 0 and (tmp_path / "a.png").stat().st_size > 30000, done.stderr
    from PIL import Image

    colours = Image.open(tmp_path / "a.png").convert("RGB").getcolors(10**6)
    assert sum(n for n, c in colours if c[0] > 150 and c[1] < 90 and c[2] < 90) > 200, "failed points are red"
    for words, message in ((["--steps", "1"], "no files of step 1"), (["--column", "c_x"], "no array c_x")):
        done = tool("vtk_picture.py", specimen, tmp_path / "b.png", *words)
        assert done.returncode == 1 and message in done.stderr and "Traceback" not in done.stderr, done.stderr


def test_gallery():
    """Each picture of doc/gallery.md is one that tools/gallery.py makes, and small."""
    page, script = (ROOT / "doc" / "gallery.md").read_text(), (ROOT / "tools" / "gallery.py").read_text()
    shown = re.findall(r"\(data/(gallery_(\w+)\.\w+)\)", page)
    assert 6 <= len(shown) <= 8
    for name, word in shown:
        assert (ROOT / "doc" / "data" / name).stat().st_size <= 150_000
        assert name in script or f'("{word}", lambda' in script, name
    assert {n for n, _ in shown} == {p.name for p in (ROOT / "doc" / "data").glob("gallery_*")}


def test_installed(pair, tmp_path):
    """`pip install .` makes a package that works away from the repository, with its types and the program's version."""
    source, place = tmp_path / "source", tmp_path / "place"
    source.mkdir()
    for name in ("pyproject.toml", "setup.py", "src/USER-MPDEM/version.h"):
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, source / name)
    shutil.copytree(ROOT / "tools" / "mpdem", source / "tools" / "mpdem")
    words = ["-m", "pip", "install", "--quiet", "--no-index", "--no-deps", "--no-build-isolation", "--target", str(place), str(source)]
    done = subprocess.run(["/usr/bin/python3", *words], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (place / "mpdem" / "py.typed").exists()
    script = "import mpdem, sys; from mpdem import plots, specimen; from importlib.metadata import version; r = mpdem.load(sys.argv[1])\n"
    script += "print(mpdem.__file__, len(r.bonds), mpdem.unit(r.bonds, 'tension'), version('mpdem'))"
    told = subprocess.run(["/usr/bin/python3", "-B", "-c", script, pair], capture_output=True, text=True, env={"PYTHONPATH": str(place)}, check=True).stdout
    version = re.search(r'kVersion = "(.*?)(?:-(dev))?"', (ROOT / "src/USER-MPDEM/version.h").read_text())
    assert told.split() == [str(place / "mpdem" / "__init__.py"), str(len(mpdem.load(pair).bonds)), "N", version[1] + (".dev0" if version[2] else "")]
