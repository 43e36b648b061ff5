// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "cement_checks.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "../fracture/neighbours.h"
#include "../numerics/eigen3.h"
#include "arguments.h"
#include "atom.h"
#include "bonded_atoms.h"
#include "comm.h"
#include "domain.h"
#include "error.h"
#include "fix_gravity.h"
#include "group.h"
#include "modify.h"
#include "private_access.h"
#include "scene_checks.h"
#include "update.h"

namespace mpdem {

using namespace LAMMPS_NS;

namespace {
constexpr double kMostSpacings = 4.0;  // largest cell without a warning, in spacings
}

std::string axis_name(AxisRule rule, const double* direction) {
  if (rule == AxisRule::global) return text_of("global ", direction[0], " ", direction[1], " ", direction[2]);
  return rule == AxisRule::bond ? "bond" : "radial";
}

namespace {

void check_other_fixes(LAMMPS* lmp, const std::string& who, const Fix* fix) {
  for (int i = 0; i < lmp->modify->nfix; ++i) {
    const Fix* other = lmp->modify->fix[i];
    if (other != fix && std::string(other->style) == "mpm")
      stop_all(lmp, who + text_of("fix '", other->id, "' is a fix mpm too; one moves all cement, unfix the other"));
    if (std::string(other->style).compare(0, 11, "multisphere") == 0)
      stop_all(lmp, who + text_of("fix '", other->id, "' (", other->style, ") deletes atoms that belong to no clump, and so would delete the material points; use spheres, or unfix it before create_cement"));
  }
}

// Bonds and points know grains and themselves by ID.
std::string trouble_with_ids(LAMMPS* lmp, const AtomVecMpdem& avec) {
  const char* const cure = ", and with them those of bonded grains; use 'delete_atoms ... compress no' for other grains, and no 'replicate' of cement; "
                           "a grain with cement cannot be deleted";
  std::unordered_set<int> bonded;
  for (const Body& b : avec.bonds.table)
    for (int s = 0; s < 2; ++s)
      if (b.has_grain(s)) bonded.insert(b.grain[s]);
  for (int i = 0; i < lmp->atom->nlocal; ++i) {
    const int tag = lmp->atom->tag[i], slot = avec.is_point(i) ? avec.slot_of(i) : 0;
    const GrainState* grain = avec.grain(i);
    if (avec.is_point(i) && avec.points_of(i).tag(slot) != tag)
      return text_of("the IDs of atoms were changed (material point ", tag, ")", cure);
    if (grain && bonded.count(grain->tag) > 0 && grain->tag != tag)
      return text_of("the IDs of atoms were changed (bonded grain ", grain->tag, " is ", tag, " now)", cure);
  }
  return "";
}

std::string trouble_with_diameter(const std::string& who, const Atom& atom, const AtomVecMpdem& avec, int i) {
  const double r = atom.radius[i], volume = avec.points_of(i).blocks[avec.slot_of(i) / kLanes].volume[avec.slot_of(i) % kLanes];
  if (std::fabs(4.0 / 3.0 * M_PI * r * r * r - volume) <= 1e-9 * volume) return "";
  return who + text_of("a command changed the diameter of material point ", atom.tag[i], " to ", 2.0 * r, "; its volume is ", volume,
                       " by create_cement, and stays so; for other volumes create the cement with another spacing or content");
}

}  // namespace

CementPoints check_scene(LAMMPS* lmp, const std::string& who, const Fix* fix, const AtomVecMpdem& avec, bool may_leave) {
  if (lmp->domain->triclinic || lmp->domain->dimension != 3)
    stop_all(lmp, who + "needs a three-dimensional orthogonal box");
  for (const std::string& trouble : {trouble_with_units(lmp), trouble_with_types(lmp, avec, 0)})
    if (!trouble.empty()) stop_all(lmp, who + trouble);
  check_other_fixes(lmp, who, fix);

  // Checks that all points are in the group, that nothing else moves them, and that they have a common density.
  std::string trouble = trouble_with_ids(lmp, avec);
  if (!trouble.empty()) trouble = who + trouble;
  double least = 1e300, most = 0.0;
  bigint mine = 0;
  for (int i = 0; i < lmp->atom->nlocal; ++i) {
    if (!avec.is_point(i)) {
      if ((lmp->atom->mask[i] & fix->groupbit) && trouble.empty())
        trouble = who + text_of("atom ", lmp->atom->tag[i], " of group '", lmp->group->names[fix->igroup],
                                "' is not a material point; the group must hold what create_cement made, nothing else");
      continue;
    }
    ++mine;
    if (!(lmp->atom->mask[i] & fix->groupbit) && trouble.empty())
      trouble = who + text_of("material point ", lmp->atom->tag[i], " is not in group '", lmp->group->names[fix->igroup],
                              "'; use the group named in create_cement");
    if (trouble.empty()) trouble = trouble_with_diameter(who, *lmp->atom, avec, i);
    least = std::min(least, lmp->atom->density[i]);
    most = std::max(most, lmp->atom->density[i]);
    for (int k = 0; k < lmp->modify->nfix && trouble.empty(); ++k) {
      const Fix* other = lmp->modify->fix[k];
      if (other != fix && other->time_integrate && (lmp->atom->mask[i] & other->groupbit))
        trouble = who + text_of("fix '", other->id, "' (", other->style, ") moves material point ", lmp->atom->tag[i],
                                " too; give it a group without cement");
    }
  }
  for (const Body& b : avec.bonds.table) {
    if (b.pattern == 0) continue;
    const PatternHead& head = avec.bonds.patterns[b.pattern - 1].head;
    if (!(head.mask & fix->groupbit) && trouble.empty())
      trouble = who + text_of("the cement of grains ", b.grain[0], " and ", b.grain[1], ", whose points are made later, is not in group '", lmp->group->names[fix->igroup],
                              "'; use the group named in create_cement");
    least = std::min(least, head.density);
    most = std::max(most, head.density);
    for (int k = 0; k < lmp->modify->nfix && trouble.empty(); ++k) {
      const Fix* other = lmp->modify->fix[k];
      if (other != fix && other->time_integrate && (head.mask & other->groupbit))
        trouble = who + text_of("fix '", other->id, "' (", other->style, ") would move points of the cement of grains ", b.grain[0], " and ", b.grain[1],
                                " too, which are made later; give it a group without cement");
    }
  }
  stop_if_any(lmp, trouble);
  double low, high;
  bigint total;
  MPI_Allreduce(&least, &low, 1, MPI_DOUBLE, MPI_MIN, lmp->world);
  MPI_Allreduce(&most, &high, 1, MPI_DOUBLE, MPI_MAX, lmp->world);
  MPI_Allreduce(&mine, &total, 1, MPI_LMP_BIGINT, MPI_SUM, lmp->world);
  if (total == 0 && avec.bonds.table.empty()) stop_all(lmp, who + "there are no material points; use create_cement before the run");
  bigint expected = 0;
  for (const Body& b : avec.bonds.table)
    if (b.pattern == 0) expected += static_cast<bigint>(b.points);
  if (total < expected && !may_leave)
    stop_all(lmp, who + text_of(expected - total, " of ", expected,
                                       " material points were deleted or left the box; use 'run 0' before, which takes crumbs and the cement of separated bonds out of the scene; other cement cannot be deleted by points"));
  if (total > expected)
    stop_all(lmp, who + text_of("there are ", total - expected, " more material points than the ", expected,
                                       " that were made; cement cannot be copied by 'replicate', make each bond by create_cement"));
  if (high > low * (1.0 + 1e-12))
    stop_all(lmp, who + text_of("material points differ in density, ", low, " to ", high, "; one density is needed"));
  return {expected, low < 1e300 ? low : 0.0};
}

// Bonds across a boundary are as long as the box was when they were made. In a deformed box, the image of a grain moves
// on with a velocity that LIGGGHTS does not give it.
void check_box(LAMMPS* lmp, const std::string& who, const std::vector<Body>& table) {
  for (int k = 0; k < lmp->modify->nfix; ++k) {
    const Fix* fix = lmp->modify->fix[k];
    if (fix->box_change_size || fix->box_change_shape)
      stop_all(lmp, text_of(who, "fix '", fix->id, "' (", fix->style, ") changes the simulation box, which cement "
                                   "does not follow; deform the scene by walls or grains that move, and the box before create_cement"));
  }
  const std::string trouble = changed_box(lmp, who, table);
  if (!trouble.empty()) stop_all(lmp, trouble);
}

// Checks the cell against the cement of each bond. Warnings name the worst of all.
void check_cell(LAMMPS* lmp, const std::string& who, const std::vector<Body>& table, double cell) {
  double widest = 0.0, finest = 1e300;
  for (const Body& b : table) {
    if (b.thickness == 0.0) continue;  // all film
    if (b.thickness < cell)
      stop_all(lmp, who + text_of("'cell ", cell, "' is larger than the cement between grains ", b.grain[0], " and ",
                                         b.grain[1], " is thick (", b.thickness, "); use a smaller cell and spacing"));
    if (b.spacing > 1.5 * cell)
      stop_all(lmp, who + text_of("'cell ", cell, "' leaves cells without points between those of spacing ", b.spacing, " between grains ",
                                         b.grain[0], " and ", b.grain[1], ", which would not hold together; use a cell of at least ",
                                         b.spacing, ", better two spacings, or create the cement with a smaller spacing"));
    if (cell > (kMostAcross + 0.5) * b.spacing * (1.0 - 1e-9))
      stop_all(lmp, who + text_of("'cell ", cell, "' is ", cell / b.spacing, " spacings of the cement between grains ", b.grain[0], " and ", b.grain[1], " wide, at most ",
                                  kMostAcross, " are allowed; use a cell of two spacings, ", 2.0 * b.spacing));
    widest = std::max(widest, b.spacing);
    finest = std::min(finest, b.spacing);
  }
  if (lmp->comm->me != 0) return;
  if (widest > 0.75 * cell)
    lmp->error->warning("fix mpm", 0,
                   text_of("one point a cell: spacing ", widest, " with cell ", cell,
                           " makes the cement far too soft; use a cell of at least two spacings")
                       .c_str());
  if (cell > kMostSpacings * finest * (1.0 + 1e-9))
    lmp->error->warning("fix mpm", 0,
                   text_of("'cell ", cell, "' is ", cell / finest, " spacings of ", finest, " wide. More than ", kMostSpacings,
                           " cost time for nothing: the cell limits what is resolved. Use a cell of two spacings, or create the cement with "
                           "spacing ", 0.5 * cell)
                       .c_str());
}

// Frames stay those of the first run, even if a fix that is defined again says something else.
void check_axis(LAMMPS* lmp, const std::string& who, const std::vector<Body>& table, const CementOptions& o) {
  for (const Body& b : table) {
    double along = 0.0;
    for (int d = 0; d < 3; ++d) along += b.axis[d] * o.axis_direction[d];
    if (b.axis_rule == AxisRule::none || (b.axis_rule == o.axis && (o.axis != AxisRule::global || std::fabs(along) > 1.0 - 1e-12))) continue;
    stop_all(lmp, text_of(who, "'axis ", axis_name(o.axis, o.axis_direction), "' but the axes of the cement of grains ",
                                 b.grain[0], " and ", b.grain[1], " were set in its first run, by 'axis ", axis_name(b.axis_rule, b.axis),
                                 "'; use that, or create the cement anew"));
  }
}

std::vector<double> motion_shown(LAMMPS* lmp, const AtomVecMpdem& avec) {
  const Atom& atom = *lmp->atom;
  std::vector<double> shown;
  for (int i = 0; i < atom.nlocal; ++i)
    if (avec.is_point(i))
      for (int d = 0; d < 3; ++d) {
        shown.push_back(atom.x[i][d]);
        shown.push_back(atom.v[i][d]);
      }
  return shown;
}

void check_points_left_alone(LAMMPS* lmp, const std::string& who, const AtomVecMpdem& avec, const std::vector<double>& shown, double way, double change) {
  const Atom& atom = *lmp->atom;
  const std::vector<double> now = motion_shown(lmp, avec);
  std::string trouble;
  std::size_t at = 0;
  for (int i = 0; i < atom.nlocal && trouble.empty(); ++i) {
    if (!avec.is_point(i)) continue;
    for (int d = 0; d < 3; ++d, at += 2)
      if (trouble.empty() && (std::fabs(shown[at] - now[at]) > way || std::fabs(shown[at + 1] - now[at + 1]) > change))
        trouble = text_of(who, "a command changed position or velocity of material point ", atom.tag[i],
                          " after the cement was set in motion; do so before the first run");
  }
  stop_if_any(lmp, trouble);
}

// Before their first run, points and their grid are where create_cement put them.
void check_created_positions(LAMMPS* lmp, const std::string& who, const AtomVecMpdem& avec, double cell, int started) {
  std::string trouble;
  for (int i = 0; i < lmp->atom->nlocal && trouble.empty(); ++i) {
    if (!avec.is_point(i)) continue;
    const int b = avec.slot_of(i) / kLanes, l = avec.slot_of(i) % kLanes;
    if (avec.bond[i] < started) continue;
    const Body& body = avec.bonds.table[avec.bond[i]];
    if (body.in_motion)
      trouble = text_of(who, "the cement of grains ", body.grain[0], " and ", body.grain[1], " has been in motion, which "
                        "the nodes of another fix mpm had: it was deleted by 'unfix', or was not defined with the ID it has in the restart "
                        "file before the first run; keep that fix, or after read_restart define it with that ID at once. For other "
                        "parameters create the cement in a new scene (write_cement, create_cement ... file)");
    if (!trouble.empty()) continue;
    double X[3], most = 0.0;
    for (int d = 0; d < 3; ++d) X[d] = avec.points_of(i).blocks[b].X[d][l];
    std::array<double, 3> x = place_in_box(body, axes_of(body), X);
    lmp->domain->remap(x.data());
    for (int d = 0; d < 3; ++d) most = std::max(most, std::fabs(x[d] - lmp->atom->x[i][d]));
    if (most > 1e-9 * cell)
      trouble = text_of(who, "a command changed the position of material point ", lmp->atom->tag[i], " by ", most,
                        "; move grains before their cement is made by create_cement");
  }
  stop_if_any(lmp, trouble);
}

// Looks at bonded and other grains of this rank.
std::string grain_that_is_not_finite(LAMMPS* lmp, const std::string& who, const AtomVecMpdem& avec, bool forces_known) {
  for (int i = 0; i < lmp->atom->nlocal; ++i) {
    if (avec.is_point(i)) continue;
    double sum[5] = {0, 0, 0, 0, 0};
    for (int d = 0; d < 3; ++d) {
      sum[0] += lmp->atom->x[i][d];
      sum[1] += lmp->atom->v[i][d];
      sum[2] += lmp->atom->omega[i][d];
      sum[3] += lmp->atom->f[i][d];
      sum[4] += lmp->atom->torque[i][d];
    }
    const char* const names[] = {"position", "velocity", "angular velocity", "force", "torque"};
    for (int q = 0; q < (forces_known ? 5 : 3); ++q)
      if (!std::isfinite(sum[q]))
        return text_of(who, "the ", names[q], " of grain ", lmp->atom->tag[i], " is not finite at step ",
                       lmp->update->ntimestep, "; check the fixes that move and load it, the time step and the contact model");
  }
  return "";
}

void count_points(LAMMPS* lmp, const std::string& who, const AtomVecMpdem& avec, bigint expected) {
  bigint mine = 0, total;
  for (int i = 0; i < lmp->atom->nlocal; ++i) mine += avec.is_point(i);
  MPI_Allreduce(&mine, &total, 1, MPI_LMP_BIGINT, MPI_SUM, lmp->world);
  if (total != expected)
    stop_all(lmp, text_of(who, expected - total,
                                 " material points left the simulation box, or were deleted, at step ", lmp->update->ntimestep,
                                 "; use a larger or periodic box"));
}

void check_links(LAMMPS* lmp, const std::string& who, const AtomVecMpdem& avec, const TractionLaw& law) {
  std::string trouble;
  if (law.fields() > 0) return;
  for (const Bond& bond : avec.bonds)
    for (const Link& k : bond.points.links) {
      const bool skin = k.attached && bond.points.has_failed(k.slot);
      if ((k.state[0] == 0.0 && !skin) || !trouble.empty()) continue;
      const Body& body = avec.bonds.body(bond);
      trouble = text_of(who, "a link of the cement of grains ", body.grain[0], " and ", body.grain[1], skin ? " holds a point that failed" : text_of(" has the damage ", k.state[0]),
                        ", of which 'interface ", law.name(), "' does not know; use 'interface cohesive', or leave the columns 'damage_i damage_j' out of the file");
    }
  stop_if_any(lmp, trouble);
}

namespace {

// Returns whether the group of a fix has some points of the cement, and whether it leaves some out, those that are made
// later with them.
struct PointsOfGroup {
  bool some, others;
};
PointsOfGroup points_of_group(LAMMPS* lmp, const Fix* fix, const AtomVecMpdem& avec) {
  int found[2] = {0, 0};  // points in the group, and points beside it
  for (int i = 0; i < lmp->atom->nlocal; ++i)
    if (avec.is_point(i)) found[!(lmp->atom->mask[i] & fix->groupbit)] = 1;
  for (const Body& b : avec.bonds.table)
    if (b.pattern > 0) found[!(avec.bonds.patterns[b.pattern - 1].head.mask & fix->groupbit)] = 1;
  MPI_Allreduce(MPI_IN_PLACE, found, 2, MPI_INT, MPI_MAX, lmp->world);
  return {found[0] != 0, found[1] != 0};
}

}  // namespace

std::vector<FixGravity*> gravities(LAMMPS* lmp, const std::string& who, const Fix* fix, const AtomVecMpdem& avec) {
  std::vector<FixGravity*> found;
  bool comes_later = false;
  for (int k = 0; k < lmp->modify->nfix; ++k) {
    Fix* other = lmp->modify->fix[k];
    comes_later = comes_later || other == fix;
    const PointsOfGroup points = points_of_group(lmp, other, avec);
    if (!points.some || other == fix) continue;
    if (FixGravity* g = dynamic_cast<FixGravity*>(other)) {
      if (points.others)
        stop_all(lmp, who + text_of("fix '", g->id, "' (gravity) has a part of the material points in its group '", lmp->group->names[g->igroup],
                                    "', and cement has weight as a whole or not at all; use a group that holds all of them, 'all' for instance, or none"));
      if (comes_later && is_variable(g))
        stop_all(lmp, who + text_of("fix '", g->id, "' (gravity) has a variable and was defined after this fix, so that cement would have the gravity of the step before; define it before fix mpm"));
      found.push_back(g);
    } else if ((lmp->modify->fmask[k] & FixConst::POST_FORCE) && std::string(other->style) != "store/force" && lmp->comm->me == 0)
      lmp->error->warning("fix mpm", 0,
                          text_of("fix '", other->id, "' (", other->style, ") acts on material points, on which it has no effect; "
                                  "give it the group of the grains")
                              .c_str());
  }
  return found;
}

}  // namespace mpdem
