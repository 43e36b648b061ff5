// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "point_atoms.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "../../cement/creation/cement_plan.h"
#include "../../parallel/agree.h"
#include "atom.h"
#include "domain.h"
#include "fix.h"
#include "force.h"
#include "local_atom.h"
#include "modify.h"
#include "pair.h"

namespace mpdem {

using namespace LAMMPS_NS;

namespace {

constexpr double kMostTag = 2147483647.0;

// A grain of a bond: number of ranks that have it, unwrapped position, orientation, velocities.
struct GrainOfRow {
  double found = 0.0, x[3] = {0, 0, 0}, q[4] = {0, 0, 0, 0}, v[3] = {0, 0, 0}, omega[3] = {0, 0, 0};
};

// Collective. Both grains of each of these bonds, one after the other.
std::vector<GrainOfRow> grains_of(LAMMPS* lmp, AtomVecMpdem& avec, const std::vector<int>& rows) {
  Atom& atom = *lmp->atom;
  std::vector<GrainOfRow> grains(2 * rows.size());
  for (std::size_t n = 0; n < grains.size(); ++n) {
    const int i = local_atom(atom, avec.bonds.table[rows[n / 2]].grain[n % 2]);
    if (i < 0 || !avec.orientation(i)) continue;
    GrainOfRow& g = grains[n];
    g.found = 1.0;
    lmp->domain->unmap(atom.x[i], atom.image[i], g.x);
    std::copy(avec.orientation(i), avec.orientation(i) + 4, g.q);
    std::copy(atom.v[i], atom.v[i] + 3, g.v);
    std::copy(atom.omega[i], atom.omega[i] + 3, g.omega);
  }
  constexpr int kNumbers = sizeof(GrainOfRow) / sizeof(double);
  MPI_Allreduce(MPI_IN_PLACE, grains.data(), kNumbers * static_cast<int>(grains.size()), MPI_DOUBLE, MPI_SUM, lmp->world);
  return grains;
}

// Finds positions and velocities of the points of a bond in rigid motion with its first grain. Velocities are
// interpolated between those of both grains, as in create_cement.
class RigidBody {
 public:
  // grains: those of the bond, grain 0 and then grain 1.
  RigidBody(const BondRecord& record, const GrainOfRow* grains) : record_(record), grain_(grains[0]), axes_(axes_of(record)) {
    for (int s = 0; s < 2; ++s) {
      both_[s].radius = record.radius[s];
      std::copy(grains[s].v, grains[s].v + 3, both_[s].v);
      std::copy(grains[s].omega, grains[s].omega + 3, both_[s].omega);
    }
    if (!record.in_motion) return;
    // From the axes of the bond to those fixed in the first grain, and on to the box by the present orientation of the
    // grain.
    turned_ = product(rotation_of(grain_.q), transpose(rotation_of(record.orientation[0])));
  }
  void find(const double* X, double* x, double* v) const {
    std::array<double, 3> r[2];  // position from the centre of each grain
    for (int s = 0; s < 2; ++s) {
      double arm[3];
      for (int d = 0; d < 3; ++d) arm[d] = X[d] - record_.centre[s][d];
      r[s] = turned(record_.in_motion ? turned_ : axes_, arm);
    }
    const std::array<double, 3> at_rest = position_in_box(record_, axes_, X), velocity = velocity_between(both_, r);
    for (int d = 0; d < 3; ++d) {
      x[d] = record_.in_motion ? grain_.x[d] + record_.shift[0][d] + r[0][d] : at_rest[d];
      v[d] = velocity[d];
    }
  }

 private:
  const BondRecord& record_;
  const GrainOfRow& grain_;
  GrainToBond both_[2];
  Mat3<double> axes_, turned_;
};

}  // namespace

SceneBox scene_box(const Domain& domain) {
  SceneBox box;
  for (int c = 0; c < 3; ++c) {
    box.low[c] = domain.boxlo[c];
    box.high[c] = domain.boxhi[c];
    box.period[c] = domain.prd[c];
    box.periodic[c] = domain.periodicity[c] != 0;
    // Atoms may lie beyond a face that follows them. LIGGGHTS moves it before it exchanges atoms.
    constexpr int kFollows = 2;
    constexpr double kAnywhere = 1e150;
    box.own_low[c] = domain.boundary[c][0] >= kFollows && domain.sublo[c] == domain.boxlo[c] ? -kAnywhere : domain.sublo[c];
    box.own_high[c] = domain.boundary[c][1] >= kFollows && domain.subhi[c] == domain.boxhi[c] ? kAnywhere : domain.subhi[c];
  }
  return box;
}

PointAtoms::PointAtoms(LAMMPS* lmp) : Pointers(lmp), avec_(AtomVecMpdem::of(lmp)), before_(lmp->atom->nlocal) {}

int PointAtoms::made() const { return atom->nlocal - before_; }

void PointAtoms::reserve(double points, bool more) {
  const double needed = atom->nlocal + points;
  if (needed <= atom->nmax) return;
  avec_->grow(static_cast<int>(std::min(kMostTag - 1.0, std::max(needed, more ? 1.5 * atom->nmax : 0.0))));
}

int PointAtoms::add(const PointRecord& r, const TemplateHead& head, int tag, double* x, const int* image) {
  avec_->create_atom(head.type, x);
  const int i = atom->nlocal - 1;
  const auto boxes = [image](int c) { return static_cast<tagint>(IMGMAX + image[c]) & IMGMASK; };
  atom->tag[i] = tag;
  atom->image[i] = (boxes(2) << IMG2BITS) | (boxes(1) << IMGBITS) | boxes(0);
  atom->mask[i] = head.mask;
  atom->radius[i] = std::cbrt(0.75 * r.volume / M_PI);
  const double own = avec_->bonds.own_density(r.material);
  atom->density[i] = own > 0.0 ? own : head.density;
  atom->rmass[i] = atom->density[i] * r.volume;
  avec_->add_point(i, r, tag);
  return i;
}

void PointAtoms::finish(int first_tag, double created) {
  atom->natoms += static_cast<bigint>(created);
  avec_->unclaimed.add(lmp, before_, first_tag);
  for (int m = 0; m < modify->nfix; ++m) {
    Fix* fix = modify->fix[m];
    if (!fix->create_attribute) continue;
    fix->pre_set_arrays();
    for (int i = before_; i < atom->nlocal; ++i) fix->set_arrays(i);
  }
  if (atom->map_style) {
    atom->nghost = 0;
    atom->map_init();
    atom->map_set();
  }
}

void keep_contact_history(LAMMPS* lmp) {
  if (!lmp->force->pair || !lmp->force->pair->list) return;
  for (int m = 0; m < lmp->modify->nfix; ++m)
    if (std::string(lmp->modify->fix[m]->style) == "contacthistory") lmp->modify->fix[m]->setup_pre_exchange();
}

int last_tag(LAMMPS* lmp) {
  int mine = 0, largest;
  for (int i = 0; i < lmp->atom->nlocal; ++i) mine = std::max(mine, lmp->atom->tag[i]);
  MPI_Allreduce(&mine, &largest, 1, MPI_INT, MPI_MAX, lmp->world);
  return largest;
}

double make_points(LAMMPS* lmp, const std::vector<int>& rows) {
  if (rows.empty()) return 0.0;
  AtomVecMpdem& avec = *AtomVecMpdem::of(lmp);
  const SceneBox box = scene_box(*lmp->domain);
  const std::vector<GrainOfRow> grains = grains_of(lmp, avec, rows);
  const int first_tag = last_tag(lmp) + 1;
  double expected = 0.0;
  for (std::size_t n = 0; n < rows.size(); ++n) {
    const BondRecord& record = avec.bonds.table[rows[n]];
    expected += record.points;
    for (int s = 0; s < 2; ++s)
      if (grains[2 * n + s].found == 0.0)
        throw BadState(text_of("grain ", record.grain[s], " has cement but was deleted or lost; keep bonded grains, or use a larger box"));
  }
  if (first_tag - 1 + expected > kMostTag)
    throw BadState(text_of("the ", expected,
                           " points of bonds that are activated exceed the number of atom IDs; create the cement with a larger spacing"));
  PointAtoms atoms(lmp);
  int tag = first_tag;
  double x[3], v[3];
  for (std::size_t n = 0; n < rows.size(); ++n) {
    BondRecord& record = avec.bonds.table[rows[n]];
    const PointTemplate& of_bond = avec.bonds.templates[record.point_template - 1];
    const RigidBody rigid(record, &grains[2 * n]);
    int mine = 0;
    for (const bool count : {true, false}) {  // counts the points of this rank, then makes them
      if (!count) atoms.reserve(mine, n + 1 < rows.size());
      for (std::size_t p = 0; p < of_bond.points.size() && (count || mine > 0); ++p) {
        int image[3] = {0, 0, 0};
        rigid.find(of_bond.points[p].X, x, v);
        if (!box.wrap(x, image)) continue;
        if (count) ++mine;
        else
          std::copy(v, v + 3,
                    lmp->atom->v[atoms.add(of_bond.record(p, rows[n], record), of_bond.head, tag + static_cast<int>(p), x, image)]);
      }
    }
    tag += record.points;
    record.point_template = 0;
    record.wants_points = false;
  }
  const double mine = atoms.made();
  double created;
  MPI_Allreduce(&mine, &created, 1, MPI_DOUBLE, MPI_SUM, lmp->world);
  if (created != expected)
    throw BadState(text_of(expected - created, " of the ", expected,
                           " points of bonds that are activated lie outside the simulation box; use a larger or periodic box"));
  atoms.finish(first_tag, created);
  return created;
}

}  // namespace mpdem
