# SPDX-License-Identifier: GPL-2.0-or-later
"""Every pair of values of the options, in short scenes: a bond that breaks as its grains fly apart.

Pairs that do not go together are refused with their reason.  All others are in one scene at least of a covering array, which
keeps the energy balance and the momentum, goes on bitwise from a restart file, and is the same on two ranks until something fails.
Which pairs those are the program declares with -options.
"""
import concurrent.futures
import functools
import itertools
import os
import random
import re

import numpy as np
from scenes import MOMENTA, MOMENTUM_COLUMNS, RADIUS, launch, pair, restarted, run, thermo
from test_option_table import declared

# Values of each option: arguments of its command, the first its default.
CREATE = {"film": ["inner auto film grid", "inner 1e-3 film joined"], "points": ["points now", "points later"]}
MPM = {
    "basis": ["basis quadratic", "basis linear", "basis cubic"],
    "mass_order": ["mass_order 1", "mass_order 2"],
    "edge": ["", "edge tied", "edge free"],
    "kinematics": ["kinematics total", "kinematics updated"],
    "reproject": ["", "reproject 1", "reproject 10", "reproject auto 0.01"],
    "transfer": ["", "transfer pic", "transfer flip 0.99", "transfer apic", "transfer xpic 2"],
    "axis": ["axis radial", "axis bond", "axis global 0 0 1"],
    "damage": ["damage none", "damage tensor B0 4e3 cutoff 0.9", "damage mazars kappa0 3e-4 At 1 Bt 3000"],
    "regularization": ["regularization none", "regularization crackband 5", "regularization nonlocal 4e-4", "regularization nonlocal 4e-4 energy 20"],
    "cracks": ["", "cracks bonds", "cracks split"],
    "unilateral": ["unilateral no", "unilateral yes"],
    "condense": ["condense no", "condense yes"],
    "subcycle": ["subcycle no", "subcycle 4", "subcycle auto"],
    "quasistatic": ["quasistatic 1 0", "quasistatic 10 0", "quasistatic 10 0.3"],
    "balance": ["balance no", "balance yes"],
    "skip": ["skip all yes", "skip all no"],
}
COUPLE = {
    "at": ["at surface", "at points"],
    "damping": ["damping 0", "damping 0.1"],
    "interface": ["interface penalty", "interface cohesive tn 2e7 tt 2e7 Gn 10 Gt 10"],
    "friction": ["", "friction 0.3"],
    "grains": ["grains rigid", "grains elastic 70e9 0.22"],
}
OPTIONS = {**CREATE, **MPM, **COUPLE}
PAIRS = [frozenset([(a, x), (b, y)]) for a, b in itertools.combinations(OPTIONS, 2) for x in OPTIONS[a] for y in OPTIONS[b]]


@functools.cache
def is_written(words, term):
    """Whether arguments of a script are written like a value of a page: `transfer flip 0.9` is `transfer flip`, `reproject 10` is `reproject N above 1`."""
    term, _, least = term.partition(" above ")
    first, *others = term.split()
    pattern = rf"\b{first}\b" + "".join(r" (-?[\d.]+(?:e[-+]?\d+)?)(?!\S)" if o[0].isupper() else rf"(?: \S+)*? {o}(?!\S)" for o in others)
    found = re.search(pattern, words)
    return bool(found) and (not least or float(found[found.lastindex]) > float(least))


def has(chosen, term):
    """Whether chosen options have a value, `cracks split with mass_order 2` for instance."""
    for joint, meant in (" with ", True), (" without ", False):
        if joint in term:
            first, second = term.split(joint)
            return has(chosen, first) and has(chosen, second) == meant
    return any(is_written(words, term) for words in chosen.values())


def with_default(chosen):
    """Options with the value of `cracks` that the program takes where a script has none, once the options that it depends on are chosen."""
    nonlocal_damage = "nonlocal" in chosen.get("regularization", "")
    keeps_reference = chosen.get("kinematics") == "kinematics total" and chosen.get("reproject") == ""
    splits = chosen.get("cracks") == "" and nonlocal_damage and chosen.get("condense") == "condense no" and keeps_reference
    return {**chosen, "cracks": "cracks split"} if splits else chosen


def exclusion(chosen, rules):
    """The first rule that options violate, once they have all options that the rule names with `without`."""
    chosen = with_default(chosen)
    for a, b, why in rules:
        left_out = [term.split(" without ")[1] for term in (a, b) if " without " in term]
        if all(term.split()[0] in chosen for term in left_out) and all(any(has(chosen, term) for term in side.split(" | ")) for side in (a, b)):
            return a, b, why
    return None


def completed(chosen, rules, wanted, dice):
    """The options with a value of every other one, which cover many of the wanted pairs; None if none go together."""
    missing = [name for name in OPTIONS if name not in chosen]
    if not missing:
        return chosen
    # the option first that has the fewest values left
    free = {name: [v for v in OPTIONS[name] if not exclusion({**chosen, name: v}, rules)] for name in missing}
    fewest = min(len(values) for values in free.values())
    name = dice.choice([n for n in missing if len(free[n]) == fewest])
    values = free[name]
    dice.shuffle(values)
    values.sort(key=lambda v: -sum(frozenset([(name, v), other]) in wanted for other in chosen.items()))
    for value in values:
        whole = completed({**chosen, name: value}, rules, wanted, dice)
        if whole:
            return whole
    return None


def covering(rules, seed=1):
    """Scenes that have all pairs that go together, and the pairs that do not."""
    dice, wanted, scenes, refused = random.Random(seed), set(PAIRS), [], []
    for these in PAIRS:
        if these not in wanted:
            continue
        first = dict(sorted(these))  # the order of a set differs from run to run, and the scenes with it
        whole = None if exclusion(first, rules) else completed(first, rules, wanted, dice)
        if whole:
            scenes.append(whole)
            wanted -= {frozenset(p) for p in itertools.combinations(whole.items(), 2)}
        else:
            refused.append(first)
            wanted.discard(these)
    return scenes, refused


SPEED = 0.15
HALF, EVERY = 60, 4  # steps
BOOKS = ["f_cem[5]", "f_cem[6]", "f_cem[7]", "f_cem[8]", "f_cem[9]"]  # kinetic, elastic, coupling, dissipated, released
FAILED, IMBALANCE, SEPARATED = "f_cem[2]", "f_cem[12]", "f_cem[19]"
FORCES = ["f_bond[7]", "f_bond[9]"]
COLUMNS = [FAILED, IMBALANCE, SEPARATED, *BOOKS, *MOMENTUM_COLUMNS, *FORCES]


def scene(chosen, file=""):
    """Grains that touch, with a ring of cement, fly apart and sideways.  file: restart file that it goes on from."""

    def words(options):
        return " ".join(chosen.get(name, "") for name in options)

    start = f"""\
variable     vz atom "{SPEED / 5e-3}*z"
variable     vx atom "{0.3 * SPEED / 5e-3}*z"
velocity     all set v_vx 0 v_vz
"""
    step = "" if chosen.get("subcycle") == "subcycle auto" else "timestep auto 0.4"
    return (
        (restarted(file, processors="1 1 *") if file else pair(2e-4, cement=f"outer 2e-3 {words(CREATE)}", processors="1 1 *"))
        + f"""\
timestep     1e-7
fix          cem calcite mpm cell 4e-4 elastic vti 60e9 40e9 0.25 0.2 18e9 {step} check 20 kinetic_share no {words(MPM)}
fix          bond grains mpm/couple cem {words(COUPLE)}
{"" if file else start}fix          motion grains nve/sphere
"""
        + MOMENTA
        + thermo(EVERY, COLUMNS)
    )


def found_in(look, cases):
    """What `look` finds wrong with number and case, two at a time."""
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        return [trouble for trouble in pool.map(look, *zip(*enumerate(cases))) if trouble]


def test_pairs_that_do_not_go_together_are_refused(tmp_path):
    """With the reason that the program declares for them, both options, and what to use in place of either."""
    rules = declared()[1]
    refused = covering(rules)[1]
    assert len(refused) > 60
    others = {"damage": MPM["damage"][1]}

    def trouble(number, pair_of_words):
        chosen = {**others, **({"condense": "condense yes"} if "points later" in pair_of_words.values() else {}), **pair_of_words}
        result = launch(scene(chosen) + "run 0\n", tmp_path / str(number))
        rule = exclusion(pair_of_words, rules)
        needed = ["does not go with", "; use ", *([f": {rule[2]};"] if rule else [])]
        said = result.errors()
        fine = result.status != 0 and len(said) == 1 and all(word in said[0] for word in needed)
        return "" if fine else f"{pair_of_words}: {said}, not '{needed[-1]}'"

    found = found_in(trouble, refused)
    assert not found, "\n".join(found)


SEED = int(os.environ.get("MPDEM_PAIRS_SEED", 1))  # another one has the same pairs in other scenes


def scale_of(name, table):
    """What differences in a column are small beside."""
    mass = 2500 * 4 / 3 * np.pi * RADIUS**3
    if name in MOMENTUM_COLUMNS:
        return mass * SPEED * (RADIUS if "L" in name else 1.0)
    alike = BOOKS if name in BOOKS else FORCES
    return max(abs(table[n]).max() for n in alike) or 1.0


def trouble_of(chosen, folder):
    """What is wrong with a scene of these options; empty if nothing is."""
    text = scene(chosen) + f"run {HALF}\nwrite_restart half\nrun {HALF}\n"
    one = run(text, folder).table()
    two = run(text, folder / "two", 2).table()
    again = run(scene(chosen, "half") + f"run {HALF}\n", folder, name="in.again").table()
    found = []
    # Transfers of velocity lose energy. With `condense yes` up to 1.6e-4 is off in a struck pair before a point fails, and up to 1.3e-2 with
    # damping; 6e-4 where the faces of a film soften within some steps. The causes of the first two are not known.
    keeps_energy = not any(is_written(words, kind) for words in chosen.values() for kind in ("kinematics updated", "reproject"))
    imbalance = max(abs(t[IMBALANCE]).max() for t in (one, two))
    limit = 3e-4 if chosen["condense"] == "condense yes" else 1e-4
    if "joined" in chosen["film"] and any("cohesive" in words for words in chosen.values()):
        limit = 1e-3
    if chosen["condense"] == "condense yes" and any(re.search(r"damping 0*\.?0*[1-9]|quasistatic \S+ 0*\.?0*[1-9]", words) for words in chosen.values()):
        limit = 2e-2
    if keeps_energy and imbalance > limit:
        found.append(f"imbalance of the energy {imbalance:.1e}")
    for name in ("v_Px", "v_Py", "v_Pz"):
        off = abs(one[name] - one[name][0]).max() / scale_of(name, one)
        # 1.2e-8 of the momentum is lost where a bond with a film and cohesive links softens under `kinematics updated transfer flip`, and up to
        # 1e-6 where a run is divided while closed cracks slide and the inertia is scaled; all others keep it to rounding.
        limit = 1e-7 if {"kinematics updated", "transfer flip 0.99"} <= set(chosen.values()) and "joined" in chosen["film"] else 1e-12
        if {"friction 0.3", "unilateral yes"} <= set(chosen.values()) and any(re.match(r"quasistatic [1-9]\d", words) for words in chosen.values()):
            limit = 2e-6
        if off > limit:
            found.append(f"{name} off by {off:.1e}")
    for name in COLUMNS:
        if not np.array_equal(again[name], one[name][-len(again[name]) :]):
            found.append(f"{name} not bitwise the same after a restart")
    whole = (one[FAILED] == 0) & (two[FAILED] == 0)
    # Condensed bonds that are whole on a rank are solved by a factor, others by an iteration; a cohesive interface softens from there.
    alike = 1e-5 if chosen["condense"] == "condense yes" and any("cohesive" in words for words in chosen.values()) else 1e-8
    for name in BOOKS + FORCES + MOMENTUM_COLUMNS:
        off = abs(one[name] - two[name])[whole].max() / scale_of(name, one)
        if off > alike:
            found.append(f"{name} off by {off:.1e} on two ranks")
    if abs(one[FAILED][-1] - two[FAILED][-1]) > 0.05 * one[FAILED][-1]:
        found.append(f"{one[FAILED][-1]:g} points failed, {two[FAILED][-1]:g} on two ranks")
    return f"{'; '.join(found)}: {' '.join(chosen.values())}" if found else ""


def test_pairs_that_go_together(tmp_path):
    def of(number, chosen):
        try:
            return trouble_of(chosen, tmp_path / str(number))
        except AssertionError as error:  # it did not run
            return f"{' '.join(chosen.values())}: {str(error)[-1500:]}"

    found = found_in(of, covering(declared()[1], SEED)[0])
    assert not found, "\n".join(found)
