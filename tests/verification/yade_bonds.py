# SPDX-License-Identifier: GPL-2.0-or-later
"""Beads with cohesive frictional contacts of Yade, pulled, sheared, bent or compressed. Runs inside Yade:

    yade -n -x -j1 tests/verification/yade_bonds.py CASE.json

tests/verification/beside_yade.py writes the case and reads what this leaves in the file that the case names. SI units.
A bond is a contact of Law2_ScGeom6D_CohFrictPhys_CohesionMoment with its own stiffness and adhesion.
"""
import json
import math
import sys
import time

from yade import (
    Bo1_Sphere_Aabb,
    Bo1_Wall_Aabb,
    CohFrictMat,
    ForceResetter,
    FrictMat,
    Ig2_Sphere_Sphere_ScGeom6D,
    Ig2_Wall_Sphere_ScGeom,
    InsertionSortCollider,
    InteractionLoop,
    Ip2_CohFrictMat_CohFrictMat_CohFrictPhys,
    Ip2_FrictMat_FrictMat_MindlinPhys,
    Law2_ScGeom6D_CohFrictPhys_CohesionMoment,
    Law2_ScGeom_MindlinPhys_Mindlin,
    NewtonIntegrator,
    Omega,
    RotationEngine,
    utils,
)

O = Omega()


def make(case):
    """Beads and bonds of the case; the contacts of the bonds."""
    grain = O.materials.append(
        CohFrictMat(
            young=65e9,
            poisson=0.25,
            density=2500,
            frictionAngle=math.atan(0.3),
            isCohesive=True,
            momentRotationLaw=True,
            alphaKr=1,
            alphaKtw=1,
            etaRoll=-1,
            etaTwist=-1,
            normalCohesion=0,
            shearCohesion=0,
        )
    )
    # Yade takes a wall for the mirror image of the bead, which halves the radius in Hertz' law. This modulus makes up for it.
    O.materials.append(FrictMat(young=65e9 / (math.sqrt(2.0) - 1.0), poisson=0.25, density=2500, frictionAngle=0, label="wall"))
    ids = {}
    for number, x, y, z, radius in case["beads"]:
        ids[number] = O.bodies.append(utils.sphere((x, y, z), radius, material=grain))
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()]),
        InteractionLoop(
            [Ig2_Sphere_Sphere_ScGeom6D(), Ig2_Wall_Sphere_ScGeom()],
            [Ip2_CohFrictMat_CohFrictMat_CohFrictPhys(), Ip2_FrictMat_FrictMat_MindlinPhys(en=0.3, es=0.3)],
            [Law2_ScGeom6D_CohFrictPhys_CohesionMoment(useIncrementalForm=True, always_use_moment_law=True), Law2_ScGeom_MindlinPhys_Mindlin()],
        ),
        NewtonIntegrator(damping=case["damping"]),
    ]
    bonds = []
    for one, other, tension, shear, torsion, bending, strength, shear_strength in case["bonds"]:
        contact = utils.createInteraction(ids[one], ids[other])
        p = contact.phys
        p.kn, p.ks, p.ktw, p.kr = tension, shear, torsion, bending
        p.unp = contact.geom.penetrationDepth  # no force as the beads stand
        p.normalAdhesion, p.shearAdhesion, p.fragile, p.cohesionBroken = strength, shear_strength, True, False
        bonds.append((ids[one], ids[other]))
    return ids, bonds


def broken(bonds):
    count = 0
    for pair in bonds:
        try:
            contact = O.interactions[pair]
        except IndexError:
            count += 1
            continue
        count += not contact.isReal or contact.phys.cohesionBroken
    return count


def pair(case):
    """The lower bead is held, the upper one moves at a constant rate, as in examples/pair_table."""
    ids, bonds = make(case)
    lower, upper = ids[1], ids[2]
    for body in (lower, upper):
        O.bodies[body].state.blockedDOFs = "xyzXYZ"
    speed, load = case["speed"], case["load"]
    middle = 0.5 * (O.bodies[lower].state.pos + O.bodies[upper].state.pos)  # the beads are equal
    if load == "bending":
        O.engines = O.engines[:-1] + [RotationEngine(ids=[upper], rotationAxis=(0, 1, 0), angularVelocity=speed, rotateAroundZero=True, zeroPoint=middle)]
        O.engines = O.engines + [NewtonIntegrator(damping=0)]
    else:
        O.bodies[upper].state.vel = (0, 0, speed) if load == "tension" else (speed, 0, 0)
    O.dt = case["step"]
    rows = []
    spent = time.process_time()
    for _ in range(case["rows"]):
        O.run(case["every"], True)
        force, moment = O.forces.f(upper), O.forces.t(upper)
        if load == "bending":
            arm = O.bodies[upper].state.pos - middle
            value = -(moment + arm.cross(force))[1]
        else:
            value = -force[2] if load == "tension" else -force[0]
        rows.append((speed * O.dt * O.iter, value, broken(bonds)))
    return {"curve": rows, "steps": O.iter, "step": O.dt, "cpu": time.process_time() - spent}


def compression(case):
    """Smooth walls compress the beads, the upper one with the speed of examples/specimen/in.load."""
    ids, bonds = make(case)
    floor = O.bodies.append(utils.wall(0.0, axis=2, material="wall"))
    plate = O.bodies.append(utils.wall(case["height"], axis=2, material="wall"))
    section, height, ramp, full = case["side"] ** 2, case["height"], case["ramp"], case["speed"]
    stiffest = {}
    for one, other, tension, shear, *_ in case["bonds"]:
        for number in (one, other):
            stiffest[number] = stiffest.get(number, 0.0) + 2.0 * tension  # translations; rotations are slower
    O.dt = case["safety"] * min(math.sqrt(O.bodies[ids[n]].state.mass / k) for n, k in stiffest.items())
    rows, peak, way = [], 0.0, 0.0
    spent = time.process_time()
    while O.iter < case["limit"]:
        x = O.time / ramp
        O.bodies[plate].state.vel = (0, 0, -full * 0.5 * (1.0 - math.cos(math.pi * min(x, 1.0))))
        O.run(case["every"], True)
        way = height - O.bodies[plate].state.pos[2]
        force = O.forces.f(plate)[2]
        below = -O.forces.f(floor)[2]
        rows.append((way / height, force / section, below / section, broken(bonds)))
        peak = max(peak, force)
        if way / height > case["strain"] or (rows[-1][3] > 5 and force < 0.1 * peak):
            break
    kinetic = utils.kineticEnergy()
    return {"curve": rows, "steps": O.iter, "step": O.dt, "cpu": time.process_time() - spent, "kinetic": kinetic, "bonds": len(bonds)}


with open(sys.argv[-1], encoding="utf-8") as f:
    given = json.load(f)
found = pair(given) if given["load"] != "compression" else compression(given)
with open(given["results"], "w", encoding="utf-8") as f:
    json.dump(found, f)
