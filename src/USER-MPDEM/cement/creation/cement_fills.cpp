// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Fills new bonds with points of shapes or of a file, and decides which rank makes them for which others.
#include <mpi.h>

#include <algorithm>
#include <cmath>

#include "../../parallel/agree.h"
#include "../../parallel/all_to_all.h"
#include "../../parallel/memory_limit.h"
#include "../../parallel/ranks.h"
#include "broadcast_file.h"
#include "cement_maker.h"
#include "point_file.h"

namespace mpdem {

namespace {

enum FillCheck { cells };  // checks of a bond in their order; cement_overlaps.cpp has the next ones

void move_origin(std::vector<FillPoint>& points, const Vector3& to) {
  for (FillPoint& p : points) {
    p.X -= to;
    for (int k = 0; k < p.link_count; ++k) p.link[k].foot -= to;
  }
}

// Computes volume and attached areas from the points, for bonds that are trimmed by neighbours.
void measure(const std::vector<FillPoint>& fill, BondRecord& record) {
  record.volume = record.attached_area[0] = record.attached_area[1] = 0.0;
  for (const FillPoint& p : fill) {
    record.volume += p.volume;
    for (int k = 0; k < p.link_count; ++k) record.attached_area[p.link[k].side] += p.link[k].area;
  }
}

}  // namespace

void CementMaker::fill_by_shape(Fill& f, double most) {
  const CementPlan::Kind& kind = plan_.kind_of(f.first);
  const int shape = plan_.bonds()[f.first].kind;
  std::vector<Neighbour> neighbours;
  if (!near_.empty())
    for (const CementPlan::Near& other : near_[f.first])
      neighbours.push_back({&plan_.shape_of(plan_.bonds()[other.bond].kind), other.apart, other.turn});
  const FilmFill& film = plan_.film_of(shape);
  f.points.clear();
  const Shape& resolved = plan_.resolved_of(shape);
  f.record.regular = film.all || !is_seam(resolved, wish_.spacing);
  if (!f.record.regular) f.points = fill_seam(resolved, wish_.spacing, neighbours);
  else if (!film.all) f.points = fill_with_points(resolved, wish_.spacing, most, neighbours);
  const std::vector<FillPoint> of_film = fill_film(plan_.shape_of(shape).pair(), film, neighbours);
  f.points.insert(f.points.end(), of_film.begin(), of_film.end());
  for (FillPoint& p : f.points) p.material = wish_.material_of(plan_.shape_of(shape).part_at(p.X));
  f.corner = Vector3(wish_.grid[0], wish_.grid[1], wish_.grid[2]);
  move_origin(f.points, f.corner);
  for (int c = 0; c < 3; ++c) f.record.lattice[c] = -f.corner[c];
  std::copy(kind.area, kind.area + 2, f.record.attached_area);
  f.record.volume = kind.volume;
  if (!neighbours.empty()) measure(f.points, f.record);
  f.record.thickness = kind.thickness;
}

void CementMaker::fill_by_file(Fill& f) {
  const PlannedBond& bond = plan_.bonds()[f.first];
  std::string trouble;
  const std::string text = broadcast_file(comm_, wish_.file, trouble);
  if (!trouble.empty()) throw BadState(plan_.prefix(f.first) + trouble);
  PointFileOptions o;
  for (int s = 0; s < 2; ++s) o.tag[s] = bond.grain[s].tag;
  o.spacing = wish_.spacing;
  o.attach = wish_.attach;
  o.material = wish_.material;
  o.materials = wish_.materials;
  const double* first = bond.grain[0].x;
  o.to_bond = [&](const Vector3& x) -> Vector3 {
    return plan_.box().shortest(Vector3(x[0] - first[0], x[1] - first[1], x[2] - first[2])) + bond.pair.centre(0);
  };
  PointCloud cloud = read_points(text, wish_.file, bond.pair, o);
  check_grains_of_file(f.first, cloud.other_grains);
  f.points = std::move(cloud.points);
  f.turn = cloud.turn;
  f.corner = cloud.corner;
  move_origin(f.points, f.corner);
  BondRecord& record = f.record;
  for (int d = 0; d < 3; ++d) record.lattice[d] = cloud.lattice[d] - f.corner[d];
  record.regular = cloud.regular;
  if (me_ == 0 && cloud.largest_volume > 1.05 * std::pow(wish_.spacing, 3))
    host_.warn(text_of("file '", wish_.file, "': points of up to ", cloud.largest_volume,
                       " are larger than a cell of a lattice of spacing ", wish_.spacing, ", ", std::pow(wish_.spacing, 3),
                       "; cracks and gaps are found by such cells: use the spacing of the points"));
  record.volume = cloud.volume;
  record.thickness = cloud.thickness;
  std::copy(cloud.attached_area, cloud.attached_area + 2, record.attached_area);
}

// Throws BadState if a grain that the file names is not in the scene. line: the first line that names each grain.
void CementMaker::check_grains_of_file(std::size_t bond, const std::map<int, int>& line) const {
  for (const auto& g : line)
    if (std::none_of(grains_.begin(), grains_.end(), [&](const Sphere& s) { return s.tag == g.first; }))
      throw BadState(text_of(plan_.prefix(bond), line_in_file(wish_.file, g.second), "grain ", g.first,
                             " does not exist; create it before, or leave its lines out"));
}

// Mass of points whose material has a density of its own. The points of a shape may sum to another volume than the shape by a rounding.
void CementMaker::find_own_mass(Fill& f) const {
  CementVolume points;
  for (const FillPoint& p : f.points) points.add(p.volume, wish_.own_density(p.material));
  if (points.own_volume == 0.0) return;
  const double factor = f.record.volume / points.volume;
  f.record.own_volume = std::min(f.record.volume, points.own_volume * factor);
  f.record.own_mass = points.own_mass * factor;
  if (f.record.material == kSeveralMaterials) return;
  f.record.own_volume = f.record.volume;
  f.record.own_mass = wish_.own_density(f.record.material) * f.record.volume;
}

void CementMaker::fill_one(int fill, double most, BondTrouble& trouble) {
  Fill& f = fills_[fill];
  f.record = BondRecord();
  try {
    if (wish_.file.empty()) fill_by_shape(f, most);
    else fill_by_file(f);
  } catch (const ShapeError& e) {
    f.points.clear();
    trouble.tell(f.first, cells, plan_.prefix(f.first) + e.what());
  }
  f.record.spacing = wish_.spacing;
  f.record.points = static_cast<int>(f.points.size());
  f.record.material = f.points.empty() ? 0 : f.points.front().material;
  for (const FillPoint& p : f.points)
    if (p.material != f.record.material) f.record.material = kSeveralMaterials;
  find_own_mass(f);
  f.box.setEmpty();
  for (const FillPoint& p : f.points) f.box.extend(p.X);
}

// Returns how many more points fit in memory. Ranks list points while they are made, and keep their own. more: points
// that are planned already.
double CementMaker::most_points(double memory, double more) const {
  constexpr double kListed = 500.0, kKept = 700.0;  // bytes per point, measured
  const double kept = kKept / ranks_;
  return std::max(1.0, (memory - kept * (atoms_before_ + created_ + more)) / (kListed + kept));
}

// Collective. Makes the points of the bonds of a batch, on the ranks that need them.
void CementMaker::make_fills(const Batch& batch, BondTrouble& trouble) {
  const double memory = memory_limit(comm_);
  double planned = 0.0;
  std::vector<int> used, fresh;
  std::vector<double> most;
  std::vector<char> seen(fills_.size(), 0);
  for (std::size_t n = batch.from; n < batch.to; ++n) {
    const int fill = fill_of_bond_[n];
    const double expected = plan_.points_expected(n), room = most_points(memory, planned);
    if (!seen[fill]) {
      used.push_back(fill);
      if (!fills_[fill].known) {
        fresh.push_back(fill);
        most.push_back(room);
      }
    } else if (!(expected < room)) {  // no room for one more bond of this fill: throws with the message
      try {
        fill_with_points(plan_.resolved_of(plan_.bonds()[n].kind), wish_.spacing, room);
      } catch (const ShapeError& e) {
        trouble.tell(n, cells, plan_.prefix(n) + e.what());
      }
    }
    seen[fill] = 1;
    if (!wish_.later) planned += expected;
  }
  // Every rank makes a single fill itself, since it would have nothing else to make meanwhile.
  const bool each = fresh.size() == 1;
  for (std::size_t k = 0; k < fresh.size(); ++k)
    if (each || fresh[k] % ranks_ == me_) fill_one(fresh[k], most[k], trouble);
  if (!each) share_numbers(fresh);
  for (const int f : fresh) {
    fills_[f].known = true;
    live_ += fills_[f].record.points;
    if (each) std::fill(fills_[f].sent.begin(), fills_[f].sent.end(), 1);
    else fills_[f].sent[f % ranks_] = 1;
  }
  if (ranks_ > 1) send_fills(batch, used);
}

// Shares the numbers of fills among all ranks. The rank that made a fill has them; the others add zero.
void CementMaker::share_numbers(const std::vector<int>& fills) {
  constexpr int kNumbers = 15;
  std::vector<double> all(kNumbers * fills.size(), 0.0);
  for (std::size_t k = 0; k < fills.size(); ++k) {
    const Fill& f = fills_[fills[k]];
    if (fills[k] % ranks_ != me_) continue;
    double* v = &all[kNumbers * k];
    v[0] = f.record.points;
    v[1] = f.record.volume;
    std::copy(f.record.attached_area, f.record.attached_area + 2, v + 2);
    v[4] = f.record.thickness;
    v[11] = f.record.material;
    v[12] = f.record.regular;
    v[13] = f.record.own_volume;
    v[14] = f.record.own_mass;
    if (f.points.empty()) continue;
    for (int d = 0; d < 3; ++d) {
      v[5 + d] = f.box.min()[d];
      v[8 + d] = f.box.max()[d];
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM, comm_);
  for (std::size_t k = 0; k < fills.size(); ++k) {
    if (fills[k] % ranks_ == me_) continue;
    const double* v = &all[kNumbers * k];
    Fill& f = fills_[fills[k]];
    f.record = BondRecord();
    f.record.points = static_cast<int>(v[0]);
    f.record.volume = v[1];
    std::copy(v + 2, v + 4, f.record.attached_area);
    f.record.thickness = v[4];
    f.record.material = static_cast<int>(v[11]);
    f.record.regular = v[12] > 0.0;
    f.record.own_volume = v[13];
    f.record.own_mass = v[14];
    f.record.spacing = wish_.spacing;
    f.corner = Vector3(wish_.grid[0], wish_.grid[1], wish_.grid[2]);
    for (int c = 0; c < 3; ++c) f.record.lattice[c] = -f.corner[c];
    f.box = v[0] > 0.0 ? Box(Vector3(v[5], v[6], v[7]), Vector3(v[8], v[9], v[10])) : Box();
  }
}

// Marks for each fill the ranks that need its points: a bond of the batch with this fill lies in or near their subdomain.
std::vector<std::vector<char>> CementMaker::needed(const Batch& batch, const std::vector<int>& fills) const {
  double mine[6];
  std::copy(plan_.box().own_low, plan_.box().own_low + 3, mine);
  std::copy(plan_.box().own_high, plan_.box().own_high + 3, mine + 3);
  std::vector<double> all(6 * ranks_);
  MPI_Allgather(mine, 6, MPI_DOUBLE, all.data(), 6, MPI_DOUBLE, comm_);
  std::vector<Box> domains;
  const Vector3 margin = Vector3::Constant(1.001 * reach_of_cells());
  for (int r = 0; r < ranks_; ++r) {
    const double* v = &all[6 * r];
    domains.emplace_back(Vector3(v[0], v[1], v[2]) - margin, Vector3(v[3], v[4], v[5]) + margin);
  }
  const BoxSearch search(domains);
  std::vector<std::vector<char>> need(fills_.size());
  for (const int f : fills) need[f].assign(ranks_, 0);
  const std::vector<Vector3> shifts = plan_.box().images();
  for (std::size_t n = batch.from; n < batch.to; ++n) {
    const Fill& f = fill_of(n);
    if (f.box.isEmpty()) continue;
    if (wish_.later) {  // every rank has all templates
      need[fill_of_bond_[n]].assign(ranks_, 1);
      continue;
    }
    const Box box = box_around(record_of(n), f.box);
    for (const Vector3& shift : shifts) search.meeting(Box(box).translate(shift), [&](int r) { need[fill_of_bond_[n]][r] = 1; });
  }
  return need;
}

// Sends points from the ranks that made them to those that need them and do not have them yet. Sender and receiver both
// know which these are.
void CementMaker::send_fills(const Batch& batch, const std::vector<int>& fills) {
  const std::vector<std::vector<char>> need = needed(batch, fills);
  std::vector<std::vector<FillPoint>> out(ranks_);
  std::vector<std::vector<int>> from(ranks_);
  for (const int n : fills) {
    Fill& f = fills_[n];
    const int maker = n % ranks_;
    for (int r = 0; r < ranks_; ++r) {
      if (!need[n][r] || f.sent[r]) continue;
      f.sent[r] = 1;
      if (maker == me_) out[r].insert(out[r].end(), f.points.begin(), f.points.end());
      if (r == me_) from[maker].push_back(n);
    }
  }
  const Received<FillPoint> in = all_to_all(comm_, out);
  auto next = in.data.begin();
  for (int r = 0; r < ranks_; ++r)
    for (const int n : from[r]) {
      const auto end = next + static_cast<std::ptrdiff_t>(fills_[n].record.points);
      fills_[n].points.assign(next, end);
      next = end;
    }
}

}  // namespace mpdem
