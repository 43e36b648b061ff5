// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Words of the script, checks of the scene, what the parameters imply. The step is in
// fix_mpm_step.cpp, output and restart in fix_mpm_output.cpp.
#include "fix_mpm.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "arguments.h"
#include "atom.h"
#include "comm.h"
#include "domain.h"
#include "files_in_use.h"
#include "fix_gravity.h"
#include "group.h"
#include "host_recipe.h"
#include "modify.h"
#include "scene_checks.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::Arguments;
using mpdem::text_of;
using namespace FixConst;

namespace {
constexpr int kVectorSize = 22;
constexpr double kMostSpacings = 4.0;  // a cell
}  // namespace

FixMpm::FixMpm(LAMMPS* lmp, int narg, char** arg) : Fix(lmp, narg, arg) {
  time_integrate = 1;
  restart_global = 1;
  scalar_flag = vector_flag = 1;
  size_vector = kVectorSize;
  global_freq = 1;
  extscalar = extvector = 1;
  avec_ = AtomVecMpdem::of(lmp);
  parse(narg, arg);
}

FixMpm::~FixMpm() = default;

int FixMpm::setmask() {
  return PRE_INITIAL_INTEGRATE | POST_INTEGRATE | PRE_EXCHANGE | PRE_NEIGHBOR | POST_FORCE | END_OF_STEP | POST_RUN;
}

void FixMpm::init() {
  avec_ = AtomVecMpdem::of(lmp);
  check_scene();
  check_host_recipe(lmp, mpdem::text_of("fix mpm (id ", id, "): "), *avec_);
  find_other_forces();
  coupled_ = false;  // fix mpm/couple says so again in its own init
  mpdem::check_only_writer(lmp, text_of("fix mpm (id ", id, "): "), "events", events_name_, this);
  if (!coupling_follows()) set_time_step(this);
}

void FixMpm::check_scene() {
  const std::string who = text_of("fix mpm (id ", id, "): ");
  if (domain->triclinic || domain->dimension != 3)
    mpdem::stop_all(lmp, who + "needs a three-dimensional orthogonal box");
  for (const std::string& trouble : {mpdem::trouble_with_units(lmp), mpdem::trouble_with_types(lmp, *avec_, 0)})
    if (!trouble.empty()) mpdem::stop_all(lmp, who + trouble);
  for (int i = 0; i < modify->nfix; ++i)
    if (modify->fix[i] != this && std::string(modify->fix[i]->style) == "mpm")
      mpdem::stop_all(lmp, who + text_of("fix '", modify->fix[i]->id, "' is a fix mpm too; one moves all cement, unfix the other"));

  if (restored_cell_ != 0.0 && restored_cell_ != cell_)
    mpdem::stop_all(lmp, text_of("fix mpm (id ", id, "): 'cell ", cell_, "' but the restart file was written with cell ",
                                 restored_cell_, "; use that"));
  if (restored_cell_ != 0.0 && (restored_basis_ != basis_ || restored_updated_ != updated_)) {
    const char* const bases[] = {"linear", "quadratic", "cubic"};
    mpdem::stop_all(lmp, text_of("fix mpm (id ", id, "): 'basis ", bases[static_cast<int>(basis_)], "' and 'kinematics ",
                                 updated_ ? "updated" : "total", "' but the motion of the nodes in the restart file is that of basis ",
                                 bases[static_cast<int>(restored_basis_)], " and kinematics ",
                                 restored_updated_ ? "updated" : "total", "; use these"));
  }
  if (restored_cell_ != 0.0 && restored_tied_ != tied_)
    mpdem::stop_all(lmp, text_of("fix mpm (id ", id, "): nodes at the edge are ", tied_ ? "tied" : "free", " but were ",
                                 restored_tied_ ? "tied" : "free", " when the restart file was written; use 'edge ",
                                 restored_tied_ ? "tied" : "free", "' and the kinematics and re-projection of that run"));

  // All points in the group and moved by nothing else; a common density.
  std::string trouble;
  double least = 1e300, most = 0.0;
  bigint mine = 0;
  for (int i = 0; i < atom->nlocal; ++i) {
    if (!avec_->is_point(i)) {
      if ((atom->mask[i] & groupbit) && trouble.empty())
        trouble = who + text_of("atom ", atom->tag[i], " of group '", group->names[igroup],
                                "' is not a material point; the group must hold what create_cement made, nothing else");
      continue;
    }
    ++mine;
    if (!(atom->mask[i] & groupbit) && trouble.empty())
      trouble = who + text_of("material point ", atom->tag[i], " is not in group '", group->names[igroup],
                              "'; use the group named in create_cement");
    const int slot = avec_->slot[i];
    if (avec_->points.tags[slot / mpdem::kLanes][slot % mpdem::kLanes] != atom->tag[i] && trouble.empty())
      trouble = who + text_of("the IDs of atoms were changed (material point ", atom->tag[i],
                              "), and with them those of bonded grains; use 'delete_atoms ... compress no', and no 'replicate' of cement");
    least = std::min(least, atom->density[i]);
    most = std::max(most, atom->density[i]);
    for (int k = 0; k < modify->nfix && trouble.empty(); ++k) {
      const Fix* fix = modify->fix[k];
      if (fix != this && fix->time_integrate && (atom->mask[i] & fix->groupbit))
        trouble = who + text_of("fix '", fix->id, "' (", fix->style, ") moves material point ", atom->tag[i],
                                " too; give it a group without cement");
    }
  }
  mpdem::stop_if_any(lmp, trouble);
  double low, high;
  bigint total;
  MPI_Allreduce(&least, &low, 1, MPI_DOUBLE, MPI_MIN, world);
  MPI_Allreduce(&most, &high, 1, MPI_DOUBLE, MPI_MAX, world);
  MPI_Allreduce(&mine, &total, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (total == 0 && avec_->bodies.empty()) mpdem::stop_all(lmp, who + "there are no material points; use create_cement before the run");
  bigint expected = 0;
  for (const mpdem::Body& b : avec_->bodies) expected += static_cast<bigint>(b.points);
  points_expected_ = expected;
  if (total < expected)
    mpdem::stop_all(lmp, who + text_of(expected - total, " of ", expected,
                                       " material points were deleted or left the box; cement cannot be deleted by points"));
  if (total > expected)
    mpdem::stop_all(lmp, who + text_of("there are ", total - expected, " more material points than the ", expected,
                                       " that were made; cement cannot be copied by 'replicate', make each bond by create_cement"));
  if (high > low * (1.0 + 1e-12))
    mpdem::stop_all(lmp, who + text_of("material points differ in density, ", low, " to ", high, "; one density is needed"));
  density_ = low;
  inertia_ = mass_scale_ * density_;
  check_box();
  check_axis();
  check_initial_damage();
  check_cell();
}

// Against the cement of each bond. Warnings name the worst of all.
void FixMpm::check_cell() const {
  const std::string who = text_of("fix mpm (id ", id, "): ");
  double widest = 0.0, finest = 1e300;
  for (const mpdem::Body& b : avec_->bodies) {
    if (b.thickness < cell_)
      mpdem::stop_all(lmp, who + text_of("'cell ", cell_, "' is larger than the cement between grains ", b.grain[0], " and ",
                                         b.grain[1], " is thick (", b.thickness, "); use a smaller cell and spacing"));
    if (b.spacing > 1.5 * cell_)
      mpdem::stop_all(lmp, who + text_of("'cell ", cell_, "' leaves cells without points between those of spacing ", b.spacing, " between grains ",
                                         b.grain[0], " and ", b.grain[1], ", which would not hold together; use a cell of at least ",
                                         b.spacing, ", better two spacings, or create the cement with a smaller spacing"));
    widest = std::max(widest, b.spacing);
    finest = std::min(finest, b.spacing);
  }
  if (comm->me != 0) return;
  if (widest > 0.75 * cell_)
    error->warning("fix mpm", 0,
                   text_of("one point a cell: spacing ", widest, " with cell ", cell_,
                           " makes the cement far too soft; use a cell of at least two spacings")
                       .c_str());
  if (cell_ > kMostSpacings * finest * (1.0 + 1e-9))
    error->warning("fix mpm", 0,
                   text_of("'cell ", cell_, "' is ", cell_ / finest, " spacings of ", finest, " wide. More than ", kMostSpacings,
                           " cost time for nothing: the cell limits what is resolved. Use a cell of two spacings, or create the cement with "
                           "spacing ", 0.5 * cell_)
                       .c_str());
}

// Cement from a file may come damaged; law and cut-off are not known there.
void FixMpm::check_initial_damage() {
  const std::string trouble = mpdem::take_up_states(avec_->points, law_);
  mpdem::stop_if_any(lmp, trouble.empty() ? trouble : text_of("fix mpm (id ", id, "): ", trouble));
}

// Gravity acts on the cement as on the grains. Any other force on material points would be
// without effect, which has to be said.
void FixMpm::find_other_forces() {
  gravity_ = nullptr;
  for (int k = 0; k < modify->nfix; ++k) {
    Fix* fix = modify->fix[k];
    int mine = 0, acts;
    for (int i = 0; i < atom->nlocal && !mine; ++i) mine = avec_->is_point(i) && (atom->mask[i] & fix->groupbit);
    MPI_Allreduce(&mine, &acts, 1, MPI_INT, MPI_MAX, world);
    if (!acts || fix == this) continue;
    if (FixGravity* g = dynamic_cast<FixGravity*>(fix)) gravity_ = g;
    else if ((modify->fmask[k] & POST_FORCE) && comm->me == 0)
      error->warning("fix mpm", 0,
                     text_of("fix '", fix->id, "' (", fix->style, ") acts on material points, where its force has no effect; "
                             "give it the group of the grains")
                         .c_str());
  }
}

void FixMpm::reset_dt() {
  // Velocities lie half an old step behind; the next step takes up the new one.
  if (built_) refresh_added_mass();
}

double FixMpm::memory_usage() { return static_cast<double>(avec_->points.memory_usage() + grid_.memory_usage()); }

}  // namespace LAMMPS_NS
