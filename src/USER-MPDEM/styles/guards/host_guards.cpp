// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "host_guards.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <limits>

#include "../../numerics/length.h"
#include "../words/arguments.h"
#include "comm.h"
#include "domain.h"
#include "fix_gravity.h"
#include "../../cement/engine/cement.h"
#include "fix_setforce.h"
#include "group.h"
#include "modify.h"
#include "neighbor.h"
#include "../atoms/private_access.h"
#include "update.h"

namespace mpdem {

using namespace LAMMPS_NS;

namespace {

using View = const HostView&;
using Found = std::string;  // empty if nothing is wrong

constexpr int kNeighborMulti = 2, kMinimize = 2;  // values of Neighbor::style and Update::whichflag

const Atom& atoms(View v) { return *v.lmp->atom; }
int tag(View v, int i) { return atoms(v).tag[i]; }
bool is_point(View v, int i) { return v.cement->is_point(i); }
bool is_bonded(View v, int i) { return v.radius_at_creation(tag(v, i)) > 0.0; }  // i: a grain
const BondRecord& record_of(View v, int i) { return v.cement->bonds.table[v.cement->bond[i]]; }
// Before their first run, points and their grid are where create_cement put them.
bool is_new_point(View v, int i) { return is_point(v, i) && v.cement->bond[i] >= v.engine->rows_started(); }

const Fix& fix_at(View v, int k) { return *v.lmp->modify->fix[k]; }
bool is(const Fix& fix, std::initializer_list<const char*> styles) {
  return std::any_of(styles.begin(), styles.end(), [&](const char* s) { return std::strcmp(fix.style, s) == 0; });
}
Found named(const Fix& fix) { return text_of("fix '", fix.id, "' (", fix.style, ")"); }
Found group_of(View v, const Fix& fix) { return text_of("group '", v.lmp->group->names[fix.igroup], "'"); }
bool has_cement(View v, const Fix& fix) { return &fix != v.mpm && (v.groups().some & fix.groupbit); }
// Names cement whose points are made later, by its grains, and will be in one of these groups (`in`), or in none of them.
// Returns else_what if there is none.
std::string cement_in(View v, int groups, bool in, const std::string& else_what) {
  for (int row : v.cement->bonds.rows_without_points())
    if (((v.cement->bonds.template_of(row).head.mask & groups) != 0) == in) {
      const BondRecord& b = v.cement->bonds.table[row];
      return text_of("the cement of grains ", b.grain[0], " and ", b.grain[1], ", made later,");
    }
  return else_what;
}
bool comes_before_mpm(View v, const Fix& fix) { return v.lmp->modify->find_fix(fix.id) < v.lmp->modify->find_fix(v.mpm->id); }
const FixGravity* gravity_at(View v, int k) {
  return has_cement(v, fix_at(v, k)) ? dynamic_cast<const FixGravity*>(&fix_at(v, k)) : nullptr;
}

Found type_of_both(View v, int) {
  const int types = atoms(v).ntypes + 1;
  std::vector<int> grain(types, MAXSMALLINT), cement(types, 1);  // lowest ID of a grain of the type; 0 where there is cement of it
  for (int i = 0; i < atoms(v).nlocal; ++i) {
    const int type = atoms(v).type[i];
    if (is_point(v, i)) cement[type] = 0;
    else grain[type] = std::min(grain[type], tag(v, i));
  }
  for (const PointTemplate& p : v.cement->bonds.templates) cement[p.head.type] = 0;
  for (std::vector<int>* of_types : {&grain, &cement}) MPI_Allreduce(MPI_IN_PLACE, of_types->data(), types, MPI_INT, MPI_MIN, v.lmp->world);
  for (int t = 1; t < types; ++t)
    if ((cement[t] == 0 || t == v.new_type) && grain[t] != MAXSMALLINT) return text_of("type ", t, " is that of grain ", grain[t], " too,");
  return "";
}

Found changed_box(View v, int) {
  const Domain& domain = *v.lmp->domain;
  for (const BondRecord& b : v.cement->bonds.table)
    for (int d = 0; d < 3; ++d) {
      const double now = domain.prd[d];
      if (b.box[d] == 0.0 ||
          (domain.periodicity[d] ? std::fabs(now - b.box[d]) <= 1e-12 * now : b.shift[0][d] == 0.0 && b.shift[1][d] == 0.0))
        continue;
      return text_of("the box is ", domain.periodicity[d] ? "periodic in " : "not periodic in ", "xyz"[d], " with length ", now,
                     " at step ", v.lmp->update->ntimestep, ", but was periodic with length ", b.box[d], " when the cement of grains ",
                     b.grain[0], " and ", b.grain[1], " was made,");
    }
  return "";
}

// With points in these lists a scene of 50 000 points would need seconds to set up, and time that grows with their
// square.
Found points_in_lists(View v, int) {
  const Atom& atom = atoms(v);
  if (!atom.firstgroupname) return "'atom_modify first' is not set,";
  const int first = v.lmp->group->find(atom.firstgroupname), ghosts = ghost_group(v.lmp->comm), lists = v.lmp->neighbor->includegroup;
  if (ghosts == 0) return "'communicate ... group' is not set,";
  if (lists == 0) return "'neigh_modify include' is not set,";
  if (ghosts != first || lists != first) return "the three groups differ,";
  if (!v.lmp->comm->ghost_velocity) return "'communicate ... vel yes' is not set,";
  if (atom.map_style == 0) return "'atom_modify map array' is not set,";
  for (int i = 0; i < atom.nlocal; ++i)
    if (is_point(v, i) == ((atom.mask[i] & v.lmp->group->bitmask[first]) != 0))
      return text_of(is_point(v, i) ? "material point " : "grain ", atom.tag[i], is_point(v, i) ? " is" : " is not", " in group '",
                     atom.firstgroupname, "',");
  return "";
}

Found other_number_of_points(View v, int) {
  bigint found = 0;
  const bigint made = points_made(*v.cement);
  for (int i = 0; i < atoms(v).nlocal; ++i) found += is_point(v, i);
  MPI_Allreduce(MPI_IN_PLACE, &found, 1, MPI_LMP_BIGINT, MPI_SUM, v.lmp->world);
  if (v.may_leave && found < made) return "";
  return found == made ? ""
                       : text_of(found, " of ", made, " material points are there at step ", v.lmp->update->ntimestep,
                                 "; others were deleted, left the box or are copies,");
}

Found changed_id(View v, int i) {
  const char* const what = "the IDs of atoms were changed (";
  if (is_point(v, i))
    return v.cement->points_of(i).tag(v.cement->slot_of(i)) == tag(v, i) ? "" : text_of(what, "material point ", tag(v, i), "),");
  const GrainState* grain = v.cement->grain(i);
  return grain && grain->tag != tag(v, i) && v.radius_at_creation(grain->tag) > 0.0
             ? text_of(what, "bonded grain ", grain->tag, " is ", tag(v, i), " now),")
             : "";
}

Found changed_diameter(View v, int i) {
  if (!is_point(v, i)) return "";
  const int slot = v.cement->slot_of(i);
  const double r = atoms(v).radius[i], volume = v.cement->points_of(i).blocks[slot / kLanes].volume[slot % kLanes];
  if (std::fabs(4.0 / 3.0 * M_PI * r * r * r - volume) <= 1e-9 * volume) return "";
  return text_of("a command changed the diameter of material point ", tag(v, i), " to ", 2.0 * r, "; its volume is ", volume);
}

Found moved_new_point(View v, int i) {
  if (!is_new_point(v, i)) return "";
  const int slot = v.cement->slot_of(i);
  double X[3], most = 0.0;
  for (int d = 0; d < 3; ++d) X[d] = v.cement->points_of(i).blocks[slot / kLanes].X[d][slot % kLanes];
  std::array<double, 3> x = position_in_box(record_of(v, i), axes_of(record_of(v, i)), X);
  v.lmp->domain->remap(x.data());
  for (int d = 0; d < 3; ++d) most = std::max(most, std::fabs(x[d] - atoms(v).x[i][d]));
  return most > 1e-9 * v.engine->options().cell ? text_of("a command changed the position of material point ", tag(v, i), " by ", most, ",")
                                                : "";
}

// The state is in the points. Atoms only display it.
Found moved_point(View v, int i) {
  // Rounding gives a smaller displacement and a smaller change of velocity.
  const double way = 1e-9 * v.engine->options().cell, change = 1e-9 * v.engine->law().elasticity().fastest_wave(v.engine->density());
  const double* const before = &(*v.shown)[6 * static_cast<std::size_t>(i)];
  bool moved = false;
  for (int d = 0; d < 3; ++d)
    moved = moved || std::fabs(before[d] - atoms(v).x[i][d]) > way || std::fabs(before[3 + d] - atoms(v).v[i][d]) > change;
  return moved && is_point(v, i)
             ? text_of("a command changed position or velocity of material point ", tag(v, i), " after the cement was set in motion,")
             : "";
}

Found moved_grain(View v, int i) {
  const GrainState* g = v.cement->grain(i);
  if (!g || !g->position_known || !is_bonded(v, i)) return "";
  double x[3], moved[3];
  v.lmp->domain->unmap(atoms(v).x[i], atoms(v).image[i], x);
  bool far = false;
  for (int d = 0; d < 3; ++d) {
    moved[d] = x[d] - g->x[d];
    // Wrapping into the box rounds positions by this much.
    const double rounding = 16 * std::numeric_limits<double>::epsilon() * (std::fabs(x[d]) + v.lmp->domain->prd[d]);
    far = far || std::fabs(moved[d]) > 1e-9 * v.engine->options().cell + rounding;
  }
  return far ? text_of("a command moved bonded grain ", tag(v, i), " by ", length(moved),
                       g->velocities_known ? " since the last run," : " since its cement was made,")
             : "";
}

Found changed_radius(View v, int i) {
  const double made = v.cement->coats.outer_radius(tag(v, i), v.radius_at_creation(tag(v, i))), now = atoms(v).radius[i];
  if (made == 0.0 || std::fabs(now - made) <= 1e-12 * made) return "";
  return text_of("bonded grain ", tag(v, i), " has radius ", now, " at step ", v.lmp->update->ntimestep, ", but its cement was made for ",
                 made);
}

Found not_finite(View v, int i) {
  const char* const names[] = {"position", "velocity", "angular velocity", "force", "torque"};
  double** const values[] = {atoms(v).x, atoms(v).v, atoms(v).omega, atoms(v).f, atoms(v).torque};
  for (int q = 0; q < (v.forces_known ? 5 : 3); ++q)
    for (int d = 0; d < 3; ++d)
      if (!std::isfinite(values[q][i][d]))
        return text_of("the ", names[q], " of grain ", tag(v, i), " is not finite at step ", v.lmp->update->ntimestep, ",");
  return "";
}

// Fixes in whose group a bonded grain is, and for which the predicate is true.
template <class Holds>
std::vector<const Fix*> fixes_on(View v, int i, Holds holds) {
  std::vector<const Fix*> found;
  for (int k = 0; k < v.lmp->modify->nfix && is_bonded(v, i); ++k)
    if ((atoms(v).mask[i] & fix_at(v, k).groupbit) && holds(fix_at(v, k))) found.push_back(&fix_at(v, k));
  return found;
}
bool moves(const Fix& f) { return f.time_integrate != 0; }
bool freezes(const Fix& f) { return is(f, {"freeze"}); }
bool moves_by_forces(const Fix& f) { return moves(f) && !is(f, {"move", "nve/noforce"}); }

// Reports the first fix of fixes_on(). how: what it does to the grain.
template <class Holds>
Found acts(View v, int i, const char* how, Holds holds) {
  const std::vector<const Fix*> found = fixes_on(v, i, holds);
  return found.empty() ? "" : text_of("bonded grain ", tag(v, i), " is ", how, " ", named(*found[0]), ",");
}
template <class Holds>
Found acts_on_free(View v, int i, const char* how, Holds holds) {
  return fixes_on(v, i, moves_by_forces).empty() ? "" : acts(v, i, how, holds);
}

Found moved_twice(View v, int i) {
  const std::vector<const Fix*> m = fixes_on(v, i, moves);
  return m.size() < 2 ? ""
                      : text_of("bonded grain ", tag(v, i), " is moved by two fixes, '", m[0]->id, "' (", m[0]->style, ") and '", m[1]->id,
                                "' (", m[1]->style, "),");
}
Found moved_by_none(View v, int i) {
  const bool moved = !is_bonded(v, i) || !fixes_on(v, i, moves).empty() || !fixes_on(v, i, freezes).empty();
  return moved ? "" : text_of("bonded grain ", tag(v, i), " is moved by no fix,");
}
Found held_in_motion(View v, int i) {
  bool still = true;
  for (int d = 0; d < 3; ++d) still = still && atoms(v).v[i][d] == 0.0 && atoms(v).omega[i][d] == 0.0;
  return still || !fixes_on(v, i, moves).empty() ? "" : acts(v, i, "held with a velocity by", freezes);
}

// Compares IDs, since a fix may have the address of the one that it replaces.
Found changed_fixes(View v, int) {
  using Known = AtomVecMpdem::LastRun::Known;
  const std::vector<Known>& known = v.cement->last_run.fixes;
  Fix** const first = v.lmp->modify->fix;
  Fix** const end = first + v.lmp->modify->nfix;
  const auto changed = [](const std::string& style, const std::string& id, const char* how) {
    return text_of("fix ", style, " (id ", id, ") was ", how, " since the last run with fix mpm,");
  };
  for (Fix** f = first; f != end; ++f) {
    const auto before = std::find_if(known.begin(), known.end(), [&](const Known& k) { return k.id == (*f)->id; });
    if (before == known.end() || ((*f)->just_created && !before->created)) return changed((*f)->style, (*f)->id, "defined");
  }
  for (const Known& k : known)
    if (std::none_of(first, end, [&](const Fix* fix) { return k.id == fix->id; })) return changed(k.style, k.id, "removed");
  return "";
}

template <class Number>
Found counted(const char* what, Number now, Number before, const char* when) {
  return now == before ? "" : text_of("there are ", now, " ", what, " and were ", before, when);
}

enum Over { kScene, kFixes, kAtoms, kGrains };  // once, or for each fix, atom or grain of a rank

struct Guard {
  unsigned when;
  const char *thing, *why, *cure;  // thing: for doc/refused_settings.md; the message is WHAT WAS FOUND why; cure
  Over over;
  Found (*found)(View, int);  // what it finds in the fix or atom of this index
  bool warns = false;
};

constexpr unsigned kRun = kInit | kUnprepared, kBegin = kRun | kCreation;

// A row may rely on those above it.
const Guard kGuards[] = {
    {kNoFix | kUnprepared, "`run … pre no` after a fix was defined or removed", "which LIGGGHTS would call in the place of another",
     "leave 'pre no' out", kScene, changed_fixes},
    {kUnprepared, "`run … pre no every` with a command that initialises LIGGGHTS",
     "as 'write_restart' does, and what grains and contacts have of the last step is lost", "leave 'pre no' out", kScene,
     [](View v, int) {
       return Found(v.lmp->update->first_update == 0 ? "a command within 'run ... pre no every' initialised LIGGGHTS," : "");
     }},
    {kUnprepared, "`run … pre no` after `create_cement`", "of which LIGGGHTS tells nothing to fixes",
     "leave 'pre no' out after create_cement", kScene,
     [](View v, int) { return counted("bonds of cement", v.cement->bonds.table.size(), v.cement->last_run.bonds, " in the last run,"); }},
    {kUnprepared, "`run … pre no` after `timestep`", "of which LIGGGHTS tells nothing to fixes", "leave 'pre no' out after timestep",
     kScene,
     [](View v, int) {
       return v.lmp->update->dt == v.cement->last_run.dt
                  ? ""
                  : text_of("the time step is ", v.lmp->update->dt, " and was ", v.cement->last_run.dt, " in the last run,");
     }},
    {kUnprepared, "`run … pre no` after `fix_modify … points all`", "which asks for points that are yet to be made", "leave 'pre no' out",
     kScene, [](View v, int) { return Found(v.wants_points ? "fix_modify 'points all'," : ""); }},
    {kBegin, "a box that is triclinic or two-dimensional", "and cement needs a three-dimensional orthogonal one",
     "use 'dimension 3' and 'region ... block'", kScene,
     [](View v, int) {
       return Found(v.lmp->domain->triclinic || v.lmp->domain->dimension != 3 ? "the box is triclinic or two-dimensional," : "");
     }},
    {kBegin, "units other than `si`, `cgs` and `micro`",
     "are not consistent or have no dimension, and cement has moduli, densities and strengths", "use 'units si', 'cgs' or 'micro'", kScene,
     [](View v, int) {
       const std::string units = v.lmp->update->unit_style;
       return units == "si" || units == "cgs" || units == "micro" ? "" : text_of("units '", units, "'");
     }},
    {kRun | kPoints | kCheck, "grains and cement of one atom type",
     "and groups by type, contact laws and particle templates cannot tell them apart",
     "give cement an atom type of its own, by 'type' of create_cement and one type more in create_box, and grains another 'atom_type' of "
     "fix particletemplate",
     kScene, type_of_both},
    {kRun, "a second fix mpm", "is a fix mpm too, and one moves all cement", "unfix the other", kFixes,
     [](View v, int k) { return &fix_at(v, k) != v.mpm && is(fix_at(v, k), {"mpm"}) ? named(fix_at(v, k)) : ""; }},
    {kRun, "`fix multisphere`", "deletes atoms that belong to no clump, and so would delete the material points",
     "use spheres, or unfix it before create_cement", kFixes,
     [](View v, int k) { return std::strncmp(fix_at(v, k).style, "multisphere", 11) == 0 ? named(fix_at(v, k)) : ""; }},
    {kRun, "new IDs of atoms, by `delete_atoms` without `compress no` or `replicate`", "by which cement knows its points and grains",
     "use 'delete_atoms ... compress no' for other grains, and no 'replicate' of cement; a grain with cement cannot be deleted", kAtoms,
     changed_id},
    {kRun, "grains in the group of fix mpm", "and the group must hold what create_cement made, nothing else",
     "use the group named in create_cement", kAtoms,
     [](View v, int i) {
       return !is_point(v, i) && (atoms(v).mask[i] & v.mpm->groupbit)
                  ? text_of("atom ", tag(v, i), " of ", group_of(v, *v.mpm), " is not a material point,")
                  : "";
     }},
    {kRun, "cement outside of the group of fix mpm", "which would not move", "use the group named in create_cement", kScene,
     [](View v, int) {
       return v.groups().all & v.mpm->groupbit
                  ? ""
                  : cement_in(v, v.mpm->groupbit, false, "some cement") + " is not in " + group_of(v, *v.mpm) + ",";
     }},
    {kRun, "another diameter of material points, by `set`", "by create_cement, and stays so",
     "for other volumes create the cement with another spacing or content", kAtoms, changed_diameter},
    {kRun, "another fix that moves material points", "moves material points too", "give it a group without cement", kFixes,
     [](View v, int k) -> Found {
       if (!has_cement(v, fix_at(v, k)) || !moves(fix_at(v, k))) return "";
       const std::string later = cement_in(v, fix_at(v, k).groupbit, true, "");
       return named(fix_at(v, k)) + (later.empty() ? "" : ", whose group has " + later);
     }},
    {kRun, "fix mpm without cement", "and nothing to move", "use create_cement before the run", kScene,
     [](View v, int) { return Found(v.cement->bonds.table.empty() && v.cement->coats.empty() ? "there are no material points" : ""); }},
    {kRun | kExchanged, "material points that were deleted, left the box or were copied by `replicate`",
     "and cement cannot be deleted or copied by points",
     "use a larger or periodic box, 'run 0' before, which takes fragments and the cement of separated bonds out of the scene, and "
     "create_cement for each bond",
     kScene, other_number_of_points},
    {kRun, "cement of several densities", "and one density is needed",
     "give each create_cement the same 'density', and cements of unlike density a cement_material each", kScene,
     [](View v, int) -> Found {
       const Densities r = densities(v);
       if (r.changed) return "points of a material with a 'density' of its own have another density,";
       return r.high > r.low * (1.0 + 1e-12) ? text_of("material points differ in density, ", r.low, " to ", r.high, ",") : "";
     }},
    {kUnprepared, "`run … pre no` after atoms were made or deleted", "of which LIGGGHTS tells nothing to fixes",
     "leave 'pre no' out after commands that make or delete atoms", kScene,
     [](View v, int) { return counted("atoms", atoms(v).natoms, v.cement->last_run.atoms, " at the end of the last run,"); }},
    {kInit, "a fix that changes the box", "changes the simulation box, which cement does not follow",
     "deform the scene by walls or grains that move, and the box before create_cement", kFixes,
     [](View v, int k) { return fix_at(v, k).box_change_size || fix_at(v, k).box_change_shape ? named(fix_at(v, k)) : ""; }},
    {kInit | kStart, "another length of a periodic box across which there is cement", "which does not follow",
     "use 'change_box' before create_cement", kScene, changed_box},
    {kInit, "`neighbor … multi`", "finds no contacts of grains in LIGGGHTS", "use 'neighbor ... bin'", kScene,
     [](View v, int) { return Found(v.lmp->neighbor->style == kNeighborMulti ? "'neighbor ... multi'" : ""); }},
    {kInit, "`minimize`", "never calls fix mpm, so that cement would do nothing",
     "use 'run', and 'quasistatic' of fix mpm where the cement shall come to rest", kScene,
     [](View v, int) { return Found(v.lmp->update->whichflag == kMinimize ? "'minimize'" : ""); }},
    {kInit, "`run_style` other than `verlet`", "never calls fix mpm, so that cement would do nothing",
     "use 'run_style verlet', and 'subcycle' of fix mpm where the cement needs shorter steps", kScene,
     [](View v, int) {
       return std::strcmp(v.lmp->update->integrate_style, "verlet") == 0 ? "" : text_of("'run_style ", v.lmp->update->integrate_style, "'");
     }},
    {kInit, "material points in the lists of neighbours", "and material points would come into LIGGGHTS' lists of neighbours",
     "the script needs these three lines, with a group that holds all grains and no cement:\n"
     "    atom_modify  map array first grains      (before the box is created)\n    communicate  single vel yes group grains\n    "
     "neigh_modify include grains\n",
     kScene, points_in_lists},
    {kInit, "`fix gravity` of a part of the cement", "and cement has weight as a whole or not at all",
     "use a group that holds all of them, 'all' for instance, or none", kFixes,
     [](View v, int k) {
       return gravity_at(v, k) && !(v.groups().all & fix_at(v, k).groupbit)
                  ? named(fix_at(v, k)) + " has a part of the material points in its " + group_of(v, fix_at(v, k)) + ","
                  : "";
     }},
    {kInit, "`fix gravity` with a variable after fix mpm", "so that cement would have the gravity of the step before",
     "define it before fix mpm", kFixes,
     [](View v, int k) {
       return gravity_at(v, k) && is_variable(gravity_at(v, k)) && !comes_before_mpm(v, fix_at(v, k))
                  ? named(fix_at(v, k)) + " has a variable and was defined after fix mpm,"
                  : "";
     }},
    {kInit, "forces of other fixes on material points (a warning)", "acts on material points, on which it has no effect",
     "give it the group of the grains", kFixes,
     [](View v, int k) {
       const bool acts = (v.lmp->modify->fmask[k] & FixConst::POST_FORCE) && !is(fix_at(v, k), {"store/force"});
       return acts && has_cement(v, fix_at(v, k)) && !gravity_at(v, k) ? named(fix_at(v, k)) : "";
     },
     true},
    {kInit, "fix mpm/couple before fix mpm", "was defined before this fix and has to come after it", "unfix it and define it again", kFixes,
     [](View v, int k) {
       return is(fix_at(v, k), {"mpm/couple"}) && comes_before_mpm(v, fix_at(v, k)) ? text_of("fix mpm/couple (id ", fix_at(v, k).id, ")")
                                                                                    : "";
     }},
    {kStart | kCheck, "another diameter of bonded grains", "and does not follow",
     "set diameters before create_cement, and leave bonded grains out of 'set ... diameter' and 'fix adapt'", kGrains, changed_radius},
    {kStart, "bonded grains that a command moves", "which its cement does not follow",
     "use 'displace_atoms', 'set' and 'change_box' before create_cement, and move bonded grains by a fix or a velocity", kGrains,
     moved_grain},
    {kStart, "another fix mpm for cement that has been in motion",
     "which the nodes of another fix mpm had: it was deleted by 'unfix', or was not defined with the ID it has in the restart file before "
     "the first run",
     "keep that fix, or after read_restart define it with that ID at once. For other parameters create the cement in a new scene "
     "(write_cement, create_cement ... file)",
     kAtoms,
     [](View v, int i) {
       return is_new_point(v, i) && record_of(v, i).in_motion
                  ? text_of("the cement of grains ", record_of(v, i).grain[0], " and ", record_of(v, i).grain[1], " has been in motion,")
                  : "";
     }},
    {kStart, "material points that a command moves before their first run", "which its grid does not follow",
     "move grains before their cement is made by create_cement", kAtoms, moved_new_point},
    {kShown, "material points that a command moves later", "without any effect", "do so before the first run", kAtoms, moved_point},
    {kCoupling, "bonded grains outside of the group of fix mpm/couple", "is not in the group of this fix", "use the group of all grains",
     kGrains,
     [](View v, int i) { return is_bonded(v, i) && !(atoms(v).mask[i] & v.couple->groupbit) ? text_of("bonded grain ", tag(v, i)) : ""; }},
    {kSteps, "`fix momentum` on bonded grains", "which changes velocities behind the back of its cement",
     "take it out of that group, or unfix that fix", kGrains,
     [](View v, int i) { return acts(v, i, "in the group of", [](const Fix& f) { return is(f, {"momentum"}); }); }},
    {kSteps, "two integrators of a bonded grain", "twice as far as it should be", "take it out of the group of one, or unfix one", kGrains,
     moved_twice},
    {kSteps, "`fix rigid` of bonded grains", "which moves several as one body, and cement takes each of its grains for a body",
     "move it by 'fix nve/sphere' or 'fix move'", kGrains,
     [](View v, int i) { return acts(v, i, "moved by", [](const Fix& f) { return moves(f) && f.rigid_flag; }); }},
    {kSteps, "with `subcycle`, integrators other than `nve/sphere`, `nve`, `nve/noforce` and `move`",
     "and with 'subcycle' of fix mpm free grains are moved as by 'fix nve/sphere'", "use that, or 'subcycle no'", kGrains,
     [](View v, int i) {
       return v.engine->options().subcycle == 1 ? "" : acts(v, i, "moved by", [](const Fix& f) {
         return moves(f) && !is(f, {"nve/sphere", "nve", "nve/noforce", "move"});
       });
     }},
    {kSteps, "`fix aveforce`, `planeforce`, `lineforce` on free bonded grains", "which gives it another force than its cement knows of",
     "hold a direction by 'fix setforce' with 0 and NULL, or move it by 'fix move'", kGrains,
     [](View v, int i) {
       return acts_on_free(v, i, "in the group of", [](const Fix& f) { return is(f, {"aveforce", "planeforce", "lineforce"}); });
     }},
    {kSteps, "`fix setforce … region` on free bonded grains",
     "which sets forces in a region only, and its cement has to know whether it is held", "use a group of what is held, and no region",
     kGrains,
     [](View v, int i) {
       return acts_on_free(v, i, "in the group of", [](const Fix& f) {
         return dynamic_cast<const FixSetForce*>(&f) && members_of(dynamic_cast<const FixSetForce*>(&f)).in_region;
       });
     }},
    {kSteps, "`fix freeze` or `setforce` before fix mpm on free bonded grains",
     "which comes before fix mpm, whose forces it does not take away", "define it after fix mpm and fix mpm/couple", kGrains,
     [](View v, int i) {
       return acts_on_free(v, i, "held by",
                           [&](const Fix& f) { return (freezes(f) || dynamic_cast<const FixSetForce*>(&f)) && comes_before_mpm(v, f); });
     }},
    {kSteps, "bonded grains without an integrator", "so that its load would be lost",
     "give it to a 'fix nve/sphere' or 'fix move', or hold it with 'fix freeze' or 'fix move linear 0 0 0'", kGrains, moved_by_none},
    {kSteps, "bonded grains with a velocity that `fix freeze` holds", "which its cement would feel",
     "set it to 0 with 'velocity' and 'set'", kGrains, held_in_motion},
    {kCheck, "grains with motion or loads that are not finite", "and all cement would follow",
     "check the fixes that move and load it, the time step and the contact model", kGrains, not_finite},
    {kCheck, "inserted grains outside of the group of `atom_modify first`", "so that it touches neither grains nor walls",
     "give the fix particletemplate or fix insert that makes it this group", kGrains,
     [](View v, int i) {
       const int first = v.lmp->group->bitmask[v.lmp->group->find(atoms(v).firstgroupname)];
       return atoms(v).mask[i] & first ? "" : text_of("grain ", tag(v, i), " is not in group '", atoms(v).firstgroupname, "',");
     }},
};

}  // namespace

void check_host(unsigned when, const HostView& view) {
  for (const Guard& g : kGuards) {
    if (!(g.when & when)) continue;
    const int n = g.over == kScene ? 1 : g.over == kFixes ? view.lmp->modify->nfix : atoms(view).nlocal;
    const auto message = [&](const Found& found) { return found.empty() ? found : text_of(view.who, found, " ", g.why, "; ", g.cure); };
    Found mine;
    for (int i = 0; i < n && mine.empty(); ++i) {
      if (g.over == kGrains && is_point(view, i)) continue;
      const Found found = g.found(view, i);
      if (!g.warns) mine = found;
      else if (!found.empty()) warn(view.lmp, message(found));
    }
    stop_if_any(view.lmp, message(mine));
  }
}

const HostView::Groups& HostView::groups() const {
  if (groups_) return *groups_;
  int bits[2] = {0, 0};  // bits of groups that have some point, and of groups that lack some point
  const auto add = [&](int mask) { bits[0] |= mask, bits[1] |= ~mask; };
  for (int i = 0; i < lmp->atom->nlocal; ++i)
    if (cement->is_point(i)) add(lmp->atom->mask[i]);
  for (int row : cement->bonds.rows_without_points()) add(cement->bonds.template_of(row).head.mask);
  MPI_Allreduce(MPI_IN_PLACE, bits, 2, MPI_INT, MPI_BOR, lmp->world);
  return groups_.emplace(Groups{bits[0], ~bits[1]});
}

double HostView::radius_at_creation(int tag) const {
  if (radius_.empty())
    for (const BondRecord& b : cement->bonds.table)
      for (int s = 0; s < 2; ++s)
        if (b.has_grain(s)) radius_.emplace(b.grain[s], b.radius[s]);
  const auto found = radius_.find(tag);
  return found == radius_.end() ? 0.0 : found->second;
}

bigint points_made(const AtomVecMpdem& cement) {
  bigint made = 0;
  for (const BondRecord& b : cement.bonds.table) made += b.points;
  for (int row : cement.bonds.rows_without_points()) made -= cement.bonds.table[row].points;
  return made;
}

std::vector<FixGravity*> gravities(const HostView& view) {
  std::vector<FixGravity*> found;
  for (int k = 0; k < view.lmp->modify->nfix; ++k)
    if (gravity_at(view, k)) found.push_back(dynamic_cast<FixGravity*>(view.lmp->modify->fix[k]));
  return found;
}

std::vector<double> motion_shown(const Atom& atom) {
  std::vector<double> shown;
  for (int i = 0; i < atom.nlocal; ++i)
    for (double** of : {atom.x, atom.v}) shown.insert(shown.end(), of[i], of[i] + 3);
  return shown;
}

}  // namespace mpdem
