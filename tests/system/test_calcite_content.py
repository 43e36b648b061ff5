# SPDX-License-Identifier: GPL-2.0-or-later
"""Contents over contacts: calcite content and shares of patterns from the points and grains themselves, draws, refusals, ranks, restart."""
import re

import numpy as np
import pytest
from scenes import NEIGHBOURS, host, launch, run

R, SMALL, RHO = 1e-3, 0.85e-3, 2500.0
TOUCH, GAP = 5e-5, 4e-4
SPACING = 1e-4
MPM = "timestep 1e-8\nfix cem calcite mpm cell 2e-4 elastic isotropic 6e10 0.2 coupling none\nfix m grains freeze\n"


def packing(seed):
    """48 grains of two sizes near the places of a cubic lattice: large ones touch or nearly so, small ones leave gaps."""
    random = np.random.default_rng(seed)
    places = np.array([(i, j, k) for i in range(4) for j in range(4) for k in range(3)], float) - (1.5, 1.5, 1)
    radii = random.permutation(np.where(np.arange(48) < 24, R, SMALL))
    return 2 * R * places + random.uniform(-0.02, 0.02, (48, 3)) * R, radii


def scene(seed, words, ranks=1):
    centres, radii = packing(seed)
    text = host(processors=f"{ranks} 1 1") + "region box block -6e-3 6e-3 -6e-3 6e-3 -5e-3 5e-3 units box\ncreate_box 2 box\n"
    for x in centres:
        text += "create_atoms 1 single " + " ".join(f"{c:.17g}" for c in x) + " units box\n"
    text += "group grains type 1\n" + "".join(f"set atom {n + 1} diameter {2 * r:.17g} density {RHO}\n" for n, r in enumerate(radii))
    return text + NEIGHBOURS + f"create_cement calcite contacts grains gap {GAP} shape flat spacing {SPACING} overlap skip {words}\n"


DUMP = """\
dump         g grains custom 1 grains.*.txt id mass radius
dump_modify  g sort id format "%d %.17g %.17g"
dump         points calcite custom 1 points.*.txt id x y z mass
dump_modify  points sort id format "%d %.17g %.17g %.17g %.17g"
"""


def bonds(seed, result):
    """Mass and gap of each bond by its pair of grains: a point belongs to the pair whose middle of the gap is nearest."""
    centres, radii = packing(seed)
    i, j = np.triu_indices(len(radii), 1)
    apart = centres[j] - centres[i]
    distance = np.linalg.norm(apart, axis=1)
    gap = distance - radii[i] - radii[j]
    near = gap <= GAP
    i, j, gap, n = i[near], j[near], gap[near], (apart / distance[:, None])[near]
    middles = centres[i] + (radii[i] + 0.5 * gap)[:, None] * n
    p = result.points(0)
    x = np.column_stack([p["x"], p["y"], p["z"]])
    owner = np.concatenate([np.linalg.norm(part[:, None] - middles, axis=2).argmin(axis=1) for part in np.array_split(x, max(1, len(x) // 2000))])
    mass = np.bincount(owner, p["mass"], len(i))
    return {(a + 1, b + 1): (m, g) for a, b, m, g in zip(i, j, mass, gap)}


PATTERNS = {"contact": 0.5, "bridging": 0.2, "coating": 0.2, "filling": 0.1}
ASKED = f"calcite 0.03 touch {TOUCH} pattern " + " ".join(f"{p} {s}" for p, s in PATTERNS.items())


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_patterns(seed, tmp_path, figures):
    """Three packings of two sizes of grains: the masses of points and of grains against what was asked."""
    result = run(scene(seed, ASKED) + MPM + DUMP + "run 0\n", tmp_path)
    _, radii = packing(seed)
    grains = RHO * 4 / 3 * np.pi * (radii**3).sum()
    made = bonds(seed, result)
    at = result.points(0, "grains")
    found = {
        "contact": sum(m for m, g in made.values() if g <= TOUCH),
        "bridging": sum(m for m, g in made.values() if g > TOUCH),
        "coating": at["mass"].sum() - grains,
    }
    for name, mass in found.items():
        figures.below(f"packing {seed}: calcite of '{name}' off what was asked", abs(mass / grains / (0.03 * PATTERNS[name]) - 1), 0.01)
        said = float(re.search(rf"^    {name}: asked \S+, reached (\S+), share", result.output, re.M)[1])
        figures.below(f"packing {seed}: calcite of '{name}' off what the command says", abs(mass / grains / said - 1), 1e-5)
    thickness = at["radius"] - radii
    figures.below(f"packing {seed}: thickness of the coats, difference over it", np.ptp(thickness) / thickness[0], 1e-9)
    volume = 4 / 3 * np.pi * ((radii + thickness) ** 3 - radii**3)
    figures.below(f"packing {seed}: mass of the coats off their volume", abs(2710 * volume.sum() / found["coating"] - 1), 1e-9)
    contents = [m / (RHO * 4 / 3 * np.pi * (radii[a - 1] ** 3 + radii[b - 1] ** 3)) for (a, b), (m, g) in made.items() if g <= TOUCH]
    figures.below(f"packing {seed}: contents of contacts, difference over the mean", np.ptp(contents) / np.mean(contents), 1e-6)


def contents_of(seed, words, directory, ranks=1):
    made = bonds(seed, run(scene(seed, words, ranks) + MPM + DUMP + "run 0\n", directory, ranks))
    _, radii = packing(seed)
    return {p: m / (RHO * 4 / 3 * np.pi * (radii[p[0] - 1] ** 3 + radii[p[1] - 1] ** 3)) for p, (m, g) in made.items()}, made


DRAWN = {
    "lognormal": "content lognormal 0.008 0.4 seed 3",
    "uniform": "content uniform 0.004 0.012 seed 8",
    "calcite": f"content lognormal 1 0.4 seed 9 {ASKED}",
    "share": "content 0.01 cement 0.6 seed 5",
}


@pytest.mark.parametrize("name", DRAWN)
def test_draws_on_any_ranks(name, tmp_path):
    """Points, and so contents and pairs, are bitwise identical on 1, 2 and 4 ranks."""
    text = [run(scene(1, DRAWN[name], n) + MPM + DUMP + "run 0\n", tmp_path / str(n), n) for n in (1, 2, 4)]
    files = [{f: (r.directory / f).read_bytes().split(b"ITEM: ATOMS", 1)[1] for f in ("points.0.txt", "grains.0.txt")} for r in text]
    assert files[0] == files[1] == files[2]


def test_distributions(tmp_path, figures):
    """Contents scatter as asked, do not depend on other pairs, and a share of the pairs is exact."""
    contents, made = contents_of(1, DRAWN["lognormal"], tmp_path / "lognormal")
    c = np.array(list(contents.values()))
    figures.below("lognormal contents: mean off 0.008, in standard errors", abs(c.mean() - 0.008) / (0.4 * 0.008 / np.sqrt(len(c))), 4)
    figures.below("lognormal contents: coefficient of variation off 0.4", abs(c.std() / c.mean() / 0.4 - 1), 0.35)
    fewer, _ = contents_of(1, DRAWN["lognormal"] + " cement 0.5 nearest", tmp_path / "fewer")
    kept = {p: x for p, x in fewer.items() if x > 0}
    assert len(kept) in (len(contents) // 2, len(contents) // 2 + 1)
    figures.below("lognormal contents of half of the pairs: off those of all", max(abs(x / contents[p] - 1) for p, x in kept.items()), 1e-9)
    shared, made = contents_of(1, DRAWN["share"], tmp_path / "share")
    assert abs(sum(x > 0 for x in shared.values()) - 0.6 * len(shared)) <= 1
    uniform, _ = contents_of(1, DRAWN["uniform"], tmp_path / "uniform")
    u = np.array(list(uniform.values()))
    assert 0.004 <= u.min() * (1 + 1e-9) and u.max() <= 0.012 * (1 + 1e-9) and u.min() < 0.005 and u.max() > 0.011


def test_contents_of_a_file(tmp_path, figures):
    """Pairs of a file get its contents, others no cement; with `calcite` the contents are ratios."""
    pairs = sorted(bonds(1, run(scene(1, "content 0.01") + MPM + DUMP + "run 0\n", tmp_path)))[::2]
    asked = {p: 0.005 + 0.001 * (n % 7) for n, p in enumerate(pairs)}
    (tmp_path / "contents.txt").write_text("# pairs\n" + "".join(f"{b} {a} {c}\n" for (a, b), c in asked.items()))
    contents, _ = contents_of(1, "content file contents.txt", tmp_path)
    figures.below("contents of a file: off what it says", max(abs(contents[p] / asked[p] - 1) for p in pairs), 1e-6)
    assert all(c == 0 for p, c in contents.items() if p not in asked)


def test_restart(tmp_path):
    """Coats and bonds of a restart file are those that were made, and a second command knows them."""
    again = host() + "read_restart made.restart\n" + NEIGHBOURS + MPM + DUMP
    made = run(scene(1, ASKED) + "write_restart made.restart\n" + MPM + DUMP + "run 0\n", tmp_path).points(0, "grains")
    back = run(again + "run 0\n", tmp_path).points(0, "grains")
    assert all((made[c] == back[c]).all() for c in made)
    refused = launch(again + "create_cement calcite coat grains thickness 1e-6\n", tmp_path)
    assert "has a coat already" in refused.output


BAD = {
    "too much": (f"calcite 0.6 touch {TOUCH} pattern contact 1", r"asks for 0.6 of the mass of the grains at \d+ contacts, which take 0 to 0\.\d+"),
    "no gaps": ("calcite 0.01 touch 1e-3 pattern bridging 1", "at 0 gaps between grains, which take 0 to 0; use a wider 'gap'"),
    "thick coats": ("calcite 0.9 pattern contact 0.01 coating 0.99", "give at most"),
    "shares": ("calcite 0.03 pattern contact 0.6 coating 0.5", r"add up to 1.1, they must to 1"),
    "share above 1": ("calcite 0.03 pattern contact 1.5", r"share of the calcite, must lie in \[0, 1\]"),
    "no pattern": ("calcite 0.03", "keyword 'pattern' is missing"),
    "no calcite": ("content 0.01 pattern contact 1", "belong to 'calcite'"),
    "coats alone": ("calcite 0.03 pattern coating 1", "neither contacts nor gaps"),
    "two sizes": ("content 0.01 calcite 0.03 pattern contact 1", "both give the size"),
    "no variation": ("content lognormal 0.01 seed 1", "V is missing, 'seed' is not a finite number"),
    "no seed": ("content lognormal 0.01 0.5", "keyword 'seed' is missing"),
    "seed of nothing": ("content 0.01 seed 5", "nothing is drawn"),
    "seed": ("content lognormal 0.01 0.5 seed 0", "seed"),
    "variation": ("content lognormal 0.01 9 seed 1", "coefficient of variation"),
    "order": ("content uniform 0.02 0.01 seed 1", "the first must be below the second"),
    "cement": ("content 0.01 cement 1.2 seed 1", "cement"),
    "no file": ("content file none.txt", "cannot be read"),
    "walls": ("content 0.01 walls bare", "belong to 'calcite'"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_input(name, tmp_path):
    words, message = BAD[name]
    result = launch(scene(1, words), tmp_path)
    assert result.status != 0 and re.search(message, result.output), result.output[-1500:]


@pytest.mark.parametrize("line, message", [("1 1 0.01", "no pair"), ("1 2", "two IDs"), ("1 2 -1", "above 0"), ("1 48 0.01", "no pair"), ("", "has no pair")])
def test_bad_files(line, message, tmp_path):
    (tmp_path / "c.txt").write_text(line + "\n")
    result = launch(scene(1, "content file c.txt"), tmp_path)
    assert result.status != 0 and message in result.output, result.output[-1500:]
