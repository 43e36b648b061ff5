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
#include "fix_gravity.h"
#include "force.h"
#include "group.h"
#include "host_recipe.h"
#include "modify.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::Arguments;
using mpdem::text_of;
using namespace FixConst;

namespace {
const std::vector<std::string> kKeywords = {"cell", "basis", "kinematics", "elastic", "axis", "damage",
                                            "regularization", "reproject", "check", "events"};
constexpr int kVectorSize = 18;
// Width over which a crack localises on quadratic B-splines.
constexpr double kBandOverCell = 1.5;
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

void FixMpm::parse(int narg, char** arg) {
  Arguments args(lmp, text_of("fix mpm (id ", id, ")"), narg, arg, 3);
  if (!avec_)
    args.complain(text_of("atom style '", atom->atom_style, "' cannot hold material points; use 'atom_style mpdem'"));
  bool has_elastic = false;
  mpdem::DamageParameters damage;
  while (!args.empty()) {
    const std::string key = args.word("a keyword");
    if (key == "cell") {
      cell_ = args.positive(key);
    } else if (key == "basis") {
      args.choice(key, {"quadratic"});
    } else if (key == "kinematics") {
      args.choice(key, {"total"});
    } else if (key == "elastic") {
      if (args.choice(key, {"vti", "isotropic"}) == "isotropic") {
        const double E = args.number("elastic isotropic E"), nu = args.number("elastic isotropic nu");
        constants_ = mpdem::VtiConstants::isotropic(E, nu);
        if (!(nu > -1.0 && nu < 0.5)) args.complain(text_of("'elastic isotropic' nu = ", nu, " must lie between -1 and 0.5"));
      } else {
        constants_.Ep = args.number("elastic vti Ep");
        constants_.Ez = args.number("elastic vti Ez");
        constants_.nu_p = args.number("elastic vti nu_p");
        constants_.nu_zp = args.number("elastic vti nu_zp");
        constants_.Gzp = args.number("elastic vti Gzp");
      }
      const std::string why = constants_.violated_condition();
      if (!why.empty()) args.complain("'elastic' is not positive definite: " + why);
      has_elastic = true;
    } else if (key == "axis") {
      const std::string rule = args.choice(key, {"radial", "bond", "global"});
      axis_ = rule == "radial" ? kRadial : rule == "bond" ? kBond : kGlobal;
      if (axis_ == kGlobal) {
        double length = 0.0;
        for (double& a : axis_direction_) {
          a = args.number("axis global");
          length += a * a;
        }
        length = std::sqrt(length);
        if (!(length > 0.0)) args.complain("'axis global 0 0 0': a direction is needed");
        for (double& a : axis_direction_) a /= length;
      }
    } else if (key == "damage") {
      if (args.choice(key, {"none", "tensor"}) == "none") {
        damage.B0 = 0.0;
      } else {
        while (true) {
          if (args.accept("B0")) damage.B0 = args.positive("damage tensor B0");
          else if (args.accept("cutoff")) {
            damage.Dcut = args.number("damage tensor cutoff");
            if (!(damage.Dcut > 0.0 && damage.Dcut < 1.0))
              args.complain(text_of("'damage tensor cutoff ", damage.Dcut, "': must lie between 0 and 1, both excluded"));
          } else if (args.accept("evolution")) {
            damage.monotone = args.choice("damage tensor evolution", {"monotone", "full"}) == "monotone";
          } else if (args.accept("zeta")) {
            damage.zeta = args.number("damage tensor zeta");
            if (!(damage.zeta > 0.0 && damage.zeta <= 1.0))
              args.complain(text_of("'damage tensor zeta ", damage.zeta, "': tensile over compressive strength, must lie in (0, 1]"));
          } else if (args.accept("interface")) {
            damage.interface = args.positive("damage tensor interface");
          } else if (args.accept("viscosity")) {
            damage.viscosity = args.positive("damage tensor viscosity");
          } else {
            break;
          }
        }
        if (damage.B0 == 0.0) args.complain("'damage tensor' needs 'B0', the energy per volume at which damage starts");
      }
    } else if (key == "regularization") {
      fracture_energy_ = args.choice(key, {"none", "crackband"}) == "none" ? 0.0 : args.positive("regularization crackband");
    } else if (key == "reproject") {
      reproject_every_ = args.integer(key, 1);
    } else if (key == "events") {
      events_name_ = args.word("a file name for 'events'");
      events_from_ = update->ntimestep;
    } else if (key == "check") {
      check_every_ = args.integer(key, 1);
    } else {
      args.unknown(key, kKeywords);
    }
  }
  if (cell_ == 0.0) args.complain("keyword 'cell' is missing: the spacing of the background grid");
  if (!has_elastic) args.complain("keyword 'elastic' is missing: use 'elastic vti Ep Ez nu_p nu_zp Gzp' or 'elastic isotropic E nu'");
  if (fracture_energy_ > 0.0) {
    if (damage.B0 == 0.0) args.complain("'regularization crackband' needs 'damage tensor'");
    try {
      damage.exponent = mpdem::crack_band_exponent(damage, fracture_energy_, kBandOverCell * cell_);
    } catch (const std::domain_error& e) {
      args.complain(text_of("'regularization crackband': ", e.what(), "; the band is ", kBandOverCell, " cells"));
    }
  }
  law_ = std::make_unique<mpdem::TensorDamage>(mpdem::VtiElasticity(constants_), damage);
}

int FixMpm::setmask() {
  return POST_INTEGRATE | PRE_EXCHANGE | PRE_NEIGHBOR | POST_FORCE | END_OF_STEP | POST_RUN;
}

void FixMpm::set_coupling(const std::string& coupling_id, const mpdem::PenaltyParameters& p) {
  if (coupled_ && coupling_id != coupling_id_)
    mpdem::stop_all(lmp, text_of("fix mpm/couple (id ", coupling_id, "): cement '", id, "' is coupled by fix '",
                                 coupling_id_, "' already; unfix one of them"));
  coupled_ = !coupling_id.empty();
  coupling_id_ = coupling_id;
  penalty_ = p;
}

void FixMpm::init() {
  avec_ = AtomVecMpdem::of(lmp);
  check_scene();
  check_host_recipe(lmp, mpdem::text_of("fix mpm (id ", id, "): "), *avec_);
  find_other_forces();
  coupled_ = false;  // fix mpm/couple says so again in its own init
}

void FixMpm::check_scene() {
  const std::string who = text_of("fix mpm (id ", id, "): ");
  if (domain->triclinic || domain->dimension != 3)
    mpdem::stop_all(lmp, who + "needs a three-dimensional orthogonal box");
  if (force->ftm2v != 1.0 || force->nktv2p != 1.0)
    mpdem::stop_all(lmp, who + text_of("units '", update->unit_style, "' are not consistent; use 'units si', 'cgs' or 'micro'"));
  for (int i = 0; i < modify->nfix; ++i)
    if (modify->fix[i] != this && std::string(modify->fix[i]->style) == "mpm")
      mpdem::stop_all(lmp, who + text_of("fix '", modify->fix[i]->id, "' is a fix mpm too; one moves all cement, unfix the other"));

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
                              "), and with them those of bonded grains; use 'delete_atoms ... compress no'");
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
  if (total == 0) mpdem::stop_all(lmp, who + "there are no material points; use create_cement before the run");
  if (high > low * (1.0 + 1e-12))
    mpdem::stop_all(lmp, who + text_of("material points differ in density, ", low, " to ", high, "; one density is needed"));
  density_ = low;
  bigint expected = 0;
  for (const mpdem::Body& b : avec_->bodies) expected += static_cast<bigint>(b.points);
  points_expected_ = expected;
  if (total != expected)
    mpdem::stop_all(lmp, who + text_of(expected - total, " of ", expected,
                                       " material points were deleted or left the box; cement cannot be deleted by points"));
  for (const mpdem::Body& b : avec_->bodies) {
    if (b.thickness < cell_)
      mpdem::stop_all(lmp, who + text_of("'cell ", cell_, "' is larger than the cement between grains ", b.grain[0], " and ",
                                         b.grain[1], " is thick (", b.thickness, "); use a smaller cell and spacing"));
    if (b.spacing > 0.75 * cell_ && comm->me == 0)
      error->warning("fix mpm", 0,
                     text_of("one point a cell: spacing ", b.spacing, " with cell ", cell_,
                             " makes the cement far too soft; use a cell of at least two spacings")
                         .c_str());
  }
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

// Element-wise bound: with row-sum lumping the largest eigenvalue of M^-1 K is at most that
// of a single point, which for quadratic B-splines is 6/h^2 times the largest stiffness over
// the density, wherever the point lies in its cell and however small its volume.
double FixMpm::cement_eigenvalue() const {
  return 6.0 * law_->elasticity().largest_stiffness() / (density_ * cell_ * cell_);
}

// Largest dt^2 lambda. A mode that re-projection removes altogether takes half of what the
// central difference takes.
double FixMpm::stability_bound() const { return reproject_every_ > 0 ? 2.0 : 4.0; }

double FixMpm::stable_step() const {
  double w2 = cement_eigenvalue();
  if (coupled_) {
    // A grain that follows its own mass feels all its links.
    std::vector<double> k(sides_.sides.size(), 0.0);
    links_.side_stiffness(k);
    double worst = 0.0;
    for (const OwnedSide& o : owned_) {
      const double r = atom->radius[o.atom], M = atom->rmass[o.atom];
      worst = std::max(worst, k[o.at] / M * (1.0 + r * r / (0.4 * r * r)));
    }
    double all;
    MPI_Allreduce(&worst, &all, 1, MPI_DOUBLE, MPI_MAX, world);
    w2 += all;
  }
  const double z = penalty_.damping;
  return std::sqrt(stability_bound() / w2) * (std::sqrt(1.0 + z * z) - z);
}

void FixMpm::report_parameters() {
  const double limit = stable_step();
  if (comm->me == 0 && !reported_) {
    const auto& p = law_->parameters();
    std::string text = text_of(
        "fix mpm (id ", id, "): ", points_expected_, " material points, ", avec_->bodies.size(), " bodies, cell ", cell_,
        "\n  elastic   Ep ", constants_.Ep, ", Ez ", constants_.Ez, ", nu_p ", constants_.nu_p, ", nu_zp ", constants_.nu_zp,
        ", Gzp ", constants_.Gzp, ", C33 ", law_->elasticity().C33, "\n");
    if (p.B0 > 0.0) {
      text += text_of("  damage    B0 ", p.B0, ", cut-off ", p.Dcut, p.monotone ? ", evolution monotone" : ", evolution full",
                      ", zeta ", p.zeta, ", interface ", p.interface, ", viscosity ", p.viscosity, ", crack band exponent ", p.exponent, "\n");
      const char* names[2] = {"along the axis", "in the plane  "};
      const double E[2] = {constants_.Ez, constants_.Ep};
      for (int i = 0; i < 2; ++i) {
        const mpdem::ImpliedStrength s = mpdem::implied_strength(p, E[i]);
        text += text_of("  implies   ", names[i], ": tensile strength ", s.tensile_strength, ", strain at onset ", s.onset_strain,
                        ", at failure ", s.failure_strain, "\n");
      }
      const mpdem::ImpliedStrength s = mpdem::implied_strength(p, constants_.Ez);
      text += text_of("  implies   energy per crack area ", s.work_per_volume * kBandOverCell * cell_, " for a crack ", kBandOverCell,
                      fracture_energy_ > 0.0 ? " cells wide\n"
                                             : " cells wide: without regularization it is proportional to the cell\n");
    } else {
      text += "  damage    none\n";
    }
    text += text_of("  time step ", update->dt, ", stable up to ", limit, "\n");
    for (FILE* f : {screen, logfile})
      if (f) std::fprintf(f, "%s", text.c_str());
    reported_ = true;
  }
  if (update->dt > limit)
    mpdem::stop_all(lmp, text_of("fix mpm (id ", id, "): time step ", update->dt, " exceeds the stable step ", limit,
                                 "; use 'timestep ", 0.9 * limit, "' or less, or a larger cell"));
}

double FixMpm::memory_usage() { return static_cast<double>(avec_->points.memory_usage()); }

}  // namespace LAMMPS_NS
