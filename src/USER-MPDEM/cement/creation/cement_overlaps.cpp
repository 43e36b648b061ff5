// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Checks new cement against other cement of this or earlier commands, other grains, limits of numbers, and the box.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <unordered_map>

#include "../../numerics/cross_matrix.h"
#include "../../numerics/grid_index.h"
#include "../../numerics/text_of.h"
#include "../../parallel/gather_ranks.h"
#include "cement_maker.h"

namespace mpdem {

namespace {

enum OverlapCheck { overlap = 1, other_grains, numbers, outside };  // checks of a bond in order, after those of its points

// Finds the points of a fill near a position, by cells of this width.
class PointsNear {
 public:
  PointsNear(const std::vector<FillPoint>& fill, double width) : fill_(fill), width_(width) {
    near_.reserve(fill.size());
    for (std::size_t n = 0; n < fill.size(); ++n)
      near_.emplace(key(cell(fill[n].X[0]), cell(fill[n].X[1]), cell(fill[n].X[2])), static_cast<int>(n));
  }
  // Returns the volume of the points less than `half` from x along each of three axes. `turn` rotates the axes of the
  // points to these. `half` is at most the width over the root of three.
  double volume_around(const Vector3& x, double half, const Eigen::Matrix3d& turn) const {
    const long at[3] = {cell(x[0]), cell(x[1]), cell(x[2])};
    double sum = 0.0;
    for (int n = 0; n < 27; ++n) {
      const auto range = near_.equal_range(key(at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1));
      for (auto it = range.first; it != range.second; ++it)
        if ((turn * (fill_[it->second].X - x)).cwiseAbs().maxCoeff() < half) sum += fill_[it->second].volume;
    }
    return sum;
  }

 private:
  using Cell = std::array<long, 3>;
  static Cell key(long i, long j, long k) { return {i, j, k}; }
  long cell(double x) const { return static_cast<long>(std::floor(x / width_)); }
  const std::vector<FillPoint>& fill_;
  double width_;
  std::unordered_multimap<Cell, int, GridIndexHash> near_;
};

// Converts coordinates of the box to those of a bond, and back.
struct Coordinates {
  Vector3 origin;
  Mat3<double> axes;
  explicit Coordinates(const BondRecord& b) : origin(b.origin), axes(axes_of(b)) {}
  Vector3 into(const Vector3& x) const {
    const Vector3 from = x - origin;
    return Vector3(turned_back(axes, from.data()).data());
  }
  Vector3 out(const Vector3& X) const { return origin + Vector3(turned(axes, X.data()).data()); }
  // Returns the rotation from the axes of this bond to those of another.
  Eigen::Matrix3d to(const Coordinates& other) const { return matrix_of(product(transpose(other.axes), axes)); }
};

}  // namespace

// Returns the distance from the middle of a cell to its corners.
double CementMaker::reach_of_cells() const {
  double widest = wish_.spacing;
  for (const BondRecord& b : table_) widest = std::max(widest, b.spacing);
  return 0.5 * std::sqrt(3.0) * widest;
}

// Collective. Finds the volume of new points inside cells that bonds before row `rows` fill (nearly) whole. Bonds of
// the batch come after those of the table. Each rank examines the full cells in its subdomain. The result is ascending.
std::vector<CementMaker::Overlap> CementMaker::overlaps(const Batch& batch, int rows) const {
  const int there = static_cast<int>(table_.size());
  const Vector3 margin = Vector3::Constant(reach_of_cells());
  std::vector<Box> boxes;
  std::vector<Coordinates> of;
  for (std::size_t k = 0; k < batch.records.size(); ++k) {
    const Fill& f = fill_of(batch.from + k);
    const Box around = box_around(batch.records[k], f.box);
    of.emplace_back(batch.records[k]);
    boxes.push_back(f.points.empty() ? Box() : Box(around.min() - margin, around.max() + margin));
  }
  const BoxSearch search(boxes);
  const std::vector<Vector3> shifts = plan_.box().images();
  std::map<int, PointsNear> by_cells;  // points of the fills that are needed
  std::map<std::pair<std::size_t, int>, double> found;
  // Adds the volume of bond k of the batch inside a full cell of the bond of `row`. x: middle of this cell.
  const auto add_overlap = [&](std::size_t k, int row, const Coordinates& of_other, double spacing, const Vector3& x) {
    const PointsNear& near =
        by_cells.try_emplace(fill_of_bond_[batch.from + k], fill_of(batch.from + k).points, 2.0 * margin[0]).first->second;
    const double inside = near.volume_around(of[k].into(x), 0.5 * spacing * (1.0 - 1e-6), of[k].to(of_other));
    if (inside > 0.0) found[{batch.from + k, row}] += inside;
  };
  if (there > 0)
    for (const FullPoint& p : host_.full_points(std::min(rows, there)))
      for (const Vector3& shift : shifts)
        search.holding(p.x + shift, [&](int k) { add_overlap(k, p.row, Coordinates(table_[p.row]), p.width, p.x + shift); });
  const double full = 0.95 * std::pow(wish_.spacing, 3);
  for (std::size_t m = 0; m < batch.records.size() && rows > there; ++m) {
    const Fill& f = fill_of(batch.from + m);
    if (f.points.empty()) continue;
    const Box around = box_around(batch.records[m], f.box);
    for (const Vector3& shift : shifts)
      search.meeting(Box(around).translate(shift), [&](int k) {
        if (static_cast<std::size_t>(k) <= m) return;
        for (const FillPoint& p : f.points) {
          const double width = width_filled(p, wish_.spacing, full);
          if (width == 0.0) continue;
          const Vector3 x = of[m].out(p.X);
          if (search.box(k).contains(x + shift) && plan_.box().owns(x))
            add_overlap(k, there + static_cast<int>(m), of[m], width, x + shift);
        }
      });
  }
  std::vector<Overlap> mine;
  for (const auto& f : found) mine.push_back({f.first.first, f.first.second, f.second});
  found.clear();
  for (const Overlap& o : gather_all(comm_, mine)) found[{o.bond, o.row}] += o.volume;
  mine.clear();
  for (const auto& f : found) mine.push_back({f.first.first, f.first.second, f.second});
  return mine;
}

// Decides in the order of the bonds which are left out. These do not obstruct others. found: ascending.
void CementMaker::resolve(Batch& batch, const std::vector<Overlap>& found, BondTrouble& trouble) {
  const int there = static_cast<int>(table_.size());
  for (const Overlap& o : found) {
    const std::size_t k = o.bond - batch.from;
    if (!batch.kept[k] || (o.row >= there && !batch.kept[o.row - there])) continue;
    const BondRecord &record = batch.records[k], &other = o.row < there ? table_[o.row] : batch.records[o.row - there];
    if (wish_.overlap == CementRequest::skip) {
      batch.kept[k] = 0;
      skipped_.emplace_back(record.grain[0], record.grain[1]);
      continue;
    }
    trouble.tell(o.bond, overlap,
                 plan_.prefix(o.bond) +
                     text_of("the cement of grains ", record.grain[0], " and ", record.grain[1], " overlaps that of grains ",
                             other.grain[0], " and ", other.grain[1], ", in a volume of ", o.volume, " of ", record.volume) +
                     (wish_.overlap == CementRequest::trim
                          ? ", which is of an earlier command and stays as it is; use 'overlap skip'"
                          : "; make one of them smaller (a coating: 'cap'), leave the second out by 'overlap skip', or "
                            "share out the bonds of a 'contacts' by 'overlap trim'"));
  }
}

// Collective. Finds points inside third grains, or other images of the two. Each rank examines its subdomain.
void CementMaker::check_other_grains(const Batch& batch, BondTrouble& trouble) const {
  struct Inside {
    std::size_t bond;
    double points, largest_penetration;
    int tag;
  };
  const double tolerance = 0.5 * wish_.spacing;
  const std::vector<Vector3> shifts = plan_.box().images();
  std::vector<Inside> mine;
  for (std::size_t k = 0; k < batch.records.size(); ++k) {
    const BondRecord& record = batch.records[k];
    const Fill& f = fill_of(batch.from + k);
    if (!batch.kept[k] || f.points.empty()) continue;
    const Coordinates of(record);
    const Box around = box_around(record, f.box);
    Inside in{batch.from + k, 0.0, 0.0, 0};
    for (const Vector3& shift : shifts)
      near_grains_->meeting(Box(around).translate(-shift), [&](int g) {
        const Sphere& grain = grains_[g];
        const Vector3 centre = of.into(grain.x + shift);
        const double within = grain.radius - tolerance;
        if (within <= 0.0 || f.box.exteriorDistance(centre) >= within) return;
        for (int s = 0; s < 2; ++s)
          if (grain.tag == record.grain[s] &&
              (centre - Vector3(record.centre[s][0], record.centre[s][1], record.centre[s][2])).norm() < tolerance)
            return;
        for (const FillPoint& p : f.points) {
          const double depth = grain.radius - (p.X - centre).norm();
          if (depth <= tolerance || !plan_.box().owns(of.out(p.X))) continue;
          ++in.points;
          if (depth > in.largest_penetration) in.tag = grain.tag;
          in.largest_penetration = std::max(in.largest_penetration, depth);
        }
      });
    if (in.points > 0.0) mine.push_back(in);
  }
  std::map<std::size_t, Inside> all;
  for (const Inside& in : gather_all(comm_, mine)) {
    Inside& sum = all.emplace(in.bond, Inside{in.bond, 0.0, 0.0, 0}).first->second;
    sum.points += in.points;
    if (in.largest_penetration > sum.largest_penetration) sum.tag = in.tag;
    sum.largest_penetration = std::max(sum.largest_penetration, in.largest_penetration);
  }
  if (all.empty()) return;
  const Inside& in = all.begin()->second;
  const BondRecord& record = batch.records[in.bond - batch.from];
  trouble.tell(in.bond, other_grains,
               text_of("create_cement: ", std::llround(in.points), " of ", record.points, " points of the cement of grains ",
                       record.grain[0], " and ", record.grain[1], " lie inside grain ", in.tag,
                       in.tag == record.grain[0] || in.tag == record.grain[1] ? ", in another image of the periodic box" : "",
                       ", as deep as ", in.largest_penetration, " (half a spacing, ", tolerance,
                       ", is allowed); make the shape smaller, a coating by 'cap' or "
                       "'thickness', or move that grain away before"));
}

// Checks the numbers of bonds and of IDs, and finds points outside the box.
void CementMaker::check_numbers(const Batch& batch, BondTrouble& trouble) const {
  std::size_t bonds = table_.size();
  double last = last_tag_;
  for (std::size_t k = 0; k < batch.records.size(); ++k) {
    if (!batch.kept[k]) continue;
    const std::size_t n = batch.from + k;
    const BondRecord& record = batch.records[k];
    if (bonds++ == std::numeric_limits<int>::max())
      trouble.tell(n, numbers, plan_.prefix(n) + text_of("there are ", bonds - 1, " bonds, which is the most"));
    if (!wish_.later) last += record.points;
    if (last > 2147483647.0)
      trouble.tell(n, numbers, plan_.prefix(n) + text_of(record.points, " points exceed the number of atom IDs; use a larger spacing"));
    const int lost = points_outside(fill_of(n), record);
    if (lost > 0)
      trouble.tell(n, outside,
                   plan_.prefix(n) +
                       text_of(lost, " of ", record.points, " points lie outside the simulation box; use a larger box or move the grains"));
  }
}

int CementMaker::points_outside(const Fill& f, const BondRecord& record) const {
  const auto in = [&](const Vector3& x) {
    bool all = true;
    for (int c = 0; c < 3; ++c) all = all && (plan_.box().periodic[c] || (x[c] >= plan_.box().low[c] && x[c] < plan_.box().high[c]));
    return all;
  };
  const Box around = box_around(record, f.box);
  if (f.points.empty() || (in(around.min()) && in(around.max()))) return 0;
  const Coordinates of(record);
  return static_cast<int>(std::count_if(f.points.begin(), f.points.end(), [&](const FillPoint& p) { return !in(of.out(p.X)); }));
}

}  // namespace mpdem
