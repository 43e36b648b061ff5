// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// create_cement: new cement against what is there, and bonds of one command against each other.
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <unordered_map>

#include "atom.h"
#include "atom_vec_mpdem.h"
#include "comm.h"
#include "create_cement.h"
#include "domain.h"

namespace LAMMPS_NS {

using mpdem::Body;
using mpdem::FillPoint;
using mpdem::text_of;
using mpdem::Vector3;

namespace {

enum Check { overlap = 1, other_grains = 2 };

// Points of a fill by cells of this width.
class PointsNear {
 public:
  PointsNear(const std::vector<FillPoint>& fill, double width) : fill_(fill), width_(width) {
    near_.reserve(fill.size());
    for (std::size_t n = 0; n < fill.size(); ++n) near_.emplace(key(cell(fill[n].X[0]), cell(fill[n].X[1]), cell(fill[n].X[2])), static_cast<int>(n));
  }
  // Of the points less than `half` from x along each axis; half at most the width.
  double volume_around(const Vector3& x, double half) const {
    const long at[3] = {cell(x[0]), cell(x[1]), cell(x[2])};
    double sum = 0.0;
    for (int n = 0; n < 27; ++n) {
      const auto range = near_.equal_range(key(at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1));
      for (auto it = range.first; it != range.second; ++it)
        if ((fill_[it->second].X - x).cwiseAbs().maxCoeff() < half) sum += fill_[it->second].volume;
    }
    return sum;
  }

 private:
  static long key(long i, long j, long k) { return (i * 73856093L) ^ (j * 19349663L) ^ (k * 83492791L); }
  long cell(double x) const { return static_cast<long>(std::floor(x / width_)); }
  const std::vector<FillPoint>& fill_;
  double width_;
  std::unordered_multimap<long, int> near_;
};

template <class T>
std::vector<T> gather_all(MPI_Comm world, const std::vector<T>& mine) {
  int ranks;
  MPI_Comm_size(world, &ranks);
  const int bytes = static_cast<int>(mine.size() * sizeof(T));
  std::vector<int> counts(ranks), at(ranks, 0);
  MPI_Allgather(&bytes, 1, MPI_INT, counts.data(), 1, MPI_INT, world);
  for (int r = 1; r < ranks; ++r) at[r] = at[r - 1] + counts[r - 1];
  std::vector<T> all((at.back() + counts.back()) / sizeof(T));
  MPI_Allgatherv(mine.data(), bytes, MPI_BYTE, all.data(), counts.data(), at.data(), MPI_BYTE, world);
  return all;
}

Vector3 origin_of(const Body& b) { return {b.origin[0], b.origin[1], b.origin[2]}; }

}  // namespace

// Points overlap that are less than this apart along each axis.
double CreateCement::reach_of_cells() const {
  double widest = spacing_;
  for (const Body& b : AtomVecMpdem::of(lmp)->bonds.table) widest = std::max(widest, b.spacing);
  return 0.5 * widest;
}

// Ways to the periodic images of a place, itself first.
std::vector<Vector3> CreateCement::images() const {
  const int n[3] = {domain->periodicity[0], domain->periodicity[1], domain->periodicity[2]};
  std::vector<Vector3> all = {Vector3::Zero()};
  for (int i = -n[0]; i <= n[0]; ++i)
    for (int j = -n[1]; j <= n[1]; ++j)
      for (int k = -n[2]; k <= n[2]; ++k)
        if (i != 0 || j != 0 || k != 0) all.emplace_back(i * domain->prd[0], j * domain->prd[1], k * domain->prd[2]);
  return all;
}

// Volume of new points inside cells that bodies before `bodies` fill (nearly) whole; those of the part come after those
// that are. Each rank looks at the full cells in its sub-domain. Collective.
std::vector<CreateCement::Overlap> CreateCement::overlaps(const Part& part, int bodies) const {
  const AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  const int there = static_cast<int>(avec->bonds.table.size());
  const Vector3 margin = Vector3::Constant(reach_of_cells());
  std::vector<mpdem::Box> boxes;
  for (std::size_t k = 0; k < part.bodies.size(); ++k) {
    const Fill& f = fills_[bonds_[part.from + k].fill];
    const Vector3 origin = origin_of(part.bodies[k]);
    boxes.push_back(f.points.empty() ? mpdem::Box() : mpdem::Box(f.box.min() + origin - margin, f.box.max() + origin + margin));
  }
  const mpdem::BoxSearch search(boxes);
  const std::vector<Vector3> shifts = images();
  std::map<int, PointsNear> by_cells;  // of the fills that are asked for
  std::map<std::pair<std::size_t, int>, double> found;
  const auto look = [&](std::size_t k, int body, double spacing, const Vector3& x) {
    const int fill = bonds_[part.from + k].fill;
    auto near = by_cells.find(fill);
    if (near == by_cells.end()) near = by_cells.emplace(std::piecewise_construct, std::forward_as_tuple(fill), std::forward_as_tuple(fills_[fill].points, 2.0 * margin[0])).first;
    const double inside = near->second.volume_around(x - origin_of(part.bodies[k]), 0.5 * spacing * (1.0 - 1e-6));
    if (inside > 0.0) found[{part.from + k, body}] += inside;
  };
  if (there > 0)
    for (const FullPoint& p : full_points(std::min(bodies, there)))
      for (const Vector3& shift : shifts) search.holding(p.x + shift, [&](int k) { look(k, p.body, avec->bonds.table[p.body].spacing, p.x + shift); });
  const double full = 0.95 * std::pow(spacing_, 3);
  for (std::size_t m = 0; m < part.bodies.size() && bodies > there; ++m) {
    const Fill& f = fills_[bonds_[part.from + m].fill];
    if (f.points.empty()) continue;
    const Body& body = part.bodies[m];
    for (const Vector3& shift : shifts) {
      const Vector3 way = origin_of(body) + shift;
      search.meeting(mpdem::Box(f.box).translate(way), [&](int k) {
        if (static_cast<std::size_t>(k) <= m) return;
        double x[3];
        tagint image;
        for (const FillPoint& p : f.points) {
          if (p.volume < full || !search.box(k).contains(p.X + way) || !place(body, p, x, image)) continue;
          look(k, there + static_cast<int>(m), spacing_, p.X + way);
        }
      });
    }
  }
  std::vector<Overlap> mine;
  for (const auto& f : found) mine.push_back({f.first.first, f.first.second, f.second});
  found.clear();
  for (const Overlap& o : gather_all(world, mine)) found[{o.bond, o.body}] += o.volume;
  mine.clear();
  for (const auto& f : found) mine.push_back({f.first.first, f.first.second, f.second});
  return mine;
}

// Which bonds are left out, in the order of the bonds: one that is left out is in nobody's way. found: ascending.
void CreateCement::resolve(Part& part, const std::vector<Overlap>& found, Trouble& trouble, std::vector<Pair>& skipped) const {
  const AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  const int there = static_cast<int>(avec->bonds.table.size());
  for (const Overlap& o : found) {
    const std::size_t k = o.bond - part.from;
    if (!part.kept[k] || (o.body >= there && !part.kept[o.body - there])) continue;
    const Body &body = part.bodies[k], &other = o.body < there ? avec->bonds.table[o.body] : part.bodies[o.body - there];
    if (overlap_ == "skip") {
      part.kept[k] = 0;
      skipped.emplace_back(body.grain[0], body.grain[1]);
      continue;
    }
    trouble.tell(o.bond, overlap,
                 prefix(bonds_[o.bond]) + text_of("the cement of grains ", body.grain[0], " and ", body.grain[1], " overlaps that of grains ", other.grain[0], " and ",
                                                  other.grain[1], ", in a volume of ", o.volume, " of ", body.volume) +
                     (overlap_ == "trim" ? ", which is of an earlier command and stays as it is; use 'overlap skip'"
                                         : "; make one of them smaller (a coating: 'cap'), leave the second out by 'overlap skip', or "
                                           "share out the bonds of a 'contacts' by 'overlap trim'"));
  }
}

void CreateCement::gather_grains() {
  const AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  std::vector<Sphere> mine;
  for (int i = 0; i < atom->nlocal; ++i)
    if (!avec->is_point(i)) mine.push_back({atom->tag[i], Vector3(atom->x[i][0], atom->x[i][1], atom->x[i][2]), atom->radius[i]});
  grains_ = gather_all(world, mine);
  std::vector<mpdem::Box> boxes;
  for (const Sphere& g : grains_) boxes.emplace_back(g.x - Vector3::Constant(g.radius), g.x + Vector3::Constant(g.radius));
  near_grains_ = std::make_unique<mpdem::BoxSearch>(std::move(boxes));
}

// Points inside another grain than the two, or in another image of these. Each rank looks at the points in its sub-domain.
// Collective.
void CreateCement::check_other_grains(const Part& part, Trouble& trouble) const {
  struct Inside {
    std::size_t bond;
    double points, deepest;
    int tag;
  };
  const double tolerance = 0.5 * spacing_;
  const std::vector<Vector3> shifts = images();
  std::vector<Inside> mine;
  for (std::size_t k = 0; k < part.bodies.size(); ++k) {
    const Body& body = part.bodies[k];
    const Fill& f = fills_[bonds_[part.from + k].fill];
    if (!part.kept[k] || f.points.empty()) continue;
    const Vector3 origin = origin_of(body);
    Inside in{part.from + k, 0.0, 0.0, 0};
    for (const Vector3& shift : shifts)
      near_grains_->meeting(mpdem::Box(f.box).translate(origin - shift), [&](int g) {
        const Sphere& grain = grains_[g];
        const Vector3 centre = grain.x + shift - origin;
        const double within = grain.radius - tolerance;
        if (within <= 0.0 || f.box.exteriorDistance(centre) >= within) return;
        for (int s = 0; s < 2; ++s)
          if (grain.tag == body.grain[s] && (centre - Vector3(body.centre[s][0], body.centre[s][1], body.centre[s][2])).norm() < tolerance) return;
        double x[3];
        tagint image;
        for (const FillPoint& p : f.points) {
          const double depth = grain.radius - (p.X - centre).norm();
          if (depth <= tolerance || !place(body, p, x, image)) continue;
          ++in.points;
          if (depth > in.deepest) in.tag = grain.tag;
          in.deepest = std::max(in.deepest, depth);
        }
      });
    if (in.points > 0.0) mine.push_back(in);
  }
  std::map<std::size_t, Inside> all;
  for (const Inside& in : gather_all(world, mine)) {
    Inside& sum = all.emplace(in.bond, Inside{in.bond, 0.0, 0.0, 0}).first->second;
    sum.points += in.points;
    if (in.deepest > sum.deepest) sum.tag = in.tag;
    sum.deepest = std::max(sum.deepest, in.deepest);
  }
  if (all.empty()) return;
  const Inside& in = all.begin()->second;
  const Body& body = part.bodies[in.bond - part.from];
  trouble.tell(in.bond, other_grains,
               text_of("create_cement: ", std::llround(in.points), " of ", std::llround(body.points), " points of the cement of grains ", body.grain[0], " and ", body.grain[1],
                       " lie inside grain ", in.tag, in.tag == body.grain[0] || in.tag == body.grain[1] ? ", in another image of the periodic box" : "",
                       ", as deep as ", in.deepest, " (half a spacing, ", tolerance, ", is allowed); make the shape smaller, a coating by 'cap' or "
                       "'thickness', or move that grain away before"));
}

}  // namespace LAMMPS_NS
