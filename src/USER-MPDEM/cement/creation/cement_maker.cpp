// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Makes the points of the planned bonds in batches. cement_fills.cpp fills bonds, and cement_overlaps.cpp checks them
// against other cement and grains.
#include "cement_maker.h"

#include <algorithm>
#include <cmath>

#include "../../parallel/agree.h"
#include "../../parallel/gather_ranks.h"

namespace mpdem {

namespace {
// Number of points of fills that a batch makes, and number that is kept for later batches. They take some 25 MB.
constexpr double kPointsOfABatch = 100000.0;
constexpr int kListed = 20;  // number of bonds reported one by one
constexpr double kFewCells = 2.0;

bool is_seam(const CementPlan::Kind& kind, const CementRequest& wish) {
  return wish.file.empty() && kind.width > 0.0 && kind.thickness < kCellOfPoints * wish.spacing;
}

// Describes how many cells of two points thickness and width of the bond have.
std::string of_cells(const CementPlan::Kind& kind, const CementRequest& wish) {
  if (!wish.file.empty()) return "";
  const double cell = kCellOfPoints * wish.spacing;
  if (kind.width == 0.0) return "  all of it is film, thinner or narrower than cells of two points\n";
  if (is_seam(kind, wish))
    return text_of("  a seam in cells of two points, ", kind.width / cell, " wide, since it is at most ", kind.thickness / cell,
                   " thick: for elastic grains\n");
  std::string text = text_of("  in cells of two points up to ", kind.thickness / cell, " thick and ", kind.width / cell, " wide");
  if (kind.film_share > 0.0) text += text_of("; film carries ", 100.0 * kind.film_share, " % of the attached area");
  return text + "\n";
}
}  // namespace

Box box_around(const BondRecord& record, const Box& box) {
  Box around;
  if (box.isEmpty()) return around;
  const Mat3<double> axes = axes_of(record);
  for (int n = 0; n < 8; ++n) {
    const Vector3 corner = box.corner(static_cast<Box::CornerType>(n));
    around.extend(Vector3(position_in_box(record, axes, corner.data()).data()));
  }
  return around;
}

CementMaker::CementMaker(MPI_Comm comm, CementPlan& plan, std::vector<BondRecord>& table, const Scene& scene, CementMakerHost& host)
    : comm_(comm),
      plan_(plan),
      wish_(plan.wish()),
      table_(table),
      host_(host),
      first_row_(table.size()),
      atoms_before_(scene.atoms),
      last_tag_(scene.last_tag) {
  me_ = rank_in(comm_);
  ranks_ = ranks_of(comm_);
  grains_ = gather_all(comm_, scene.grains);
  std::vector<Box> boxes;
  for (const Sphere& g : grains_) boxes.emplace_back(g.x - Vector3::Constant(g.radius), g.x + Vector3::Constant(g.radius));
  near_grains_ = std::make_unique<BoxSearch>(std::move(boxes));
}

CementMaker::Sums CementMaker::make() {
  if (wish_.overlap == CementRequest::trim) near_ = plan_.neighbours();
  group_fills();
  for (std::size_t from = 0; from < plan_.bonds().size();) {
    Batch batch;
    batch.from = from;
    batch.to = from = end_of_batch(from);
    make_batch(batch);
  }
  return sums_;
}

// Groups bonds that have the same points. The comparison is bitwise.
void CementMaker::group_fills() {
  std::unordered_map<std::string, int> known;
  const std::vector<PlannedBond>& bonds = plan_.bonds();
  for (std::size_t n = 0; n < bonds.size(); ++n) {
    std::string key(reinterpret_cast<const char*>(&bonds[n].kind), sizeof(int));
    if (!near_.empty())
      for (const CementPlan::Near& other : near_[n]) {
        key.append(reinterpret_cast<const char*>(&bonds[other.bond].kind), sizeof(int));
        key.append(reinterpret_cast<const char*>(other.apart.data()), 3 * sizeof(double));
        key.append(reinterpret_cast<const char*>(other.turn.coeffs().data()), 4 * sizeof(double));
      }
    const auto found = known.emplace(std::move(key), static_cast<int>(fills_.size()));
    if (found.second) {
      fills_.emplace_back();
      fills_.back().first = n;
      fills_.back().sent.assign(ranks_, 0);
    }
    fill_of_bond_.push_back(found.first->second);
  }
}

// Points of a file are read bond by bond, so such a bond is a batch of its own.
std::size_t CementMaker::end_of_batch(std::size_t from) const {
  if (!wish_.file.empty()) return from + 1;
  std::vector<char> counted(fills_.size(), 0);
  double points = 0.0;
  std::size_t to = from;
  for (; to < plan_.bonds().size(); ++to) {
    const int fill = fill_of_bond_[to];
    if (!counted[fill]) points += plan_.points_expected(to);
    counted[fill] = 1;
    if (points > kPointsOfABatch && to > from) break;
  }
  return to;
}

void CementMaker::make_batch(Batch& batch) {
  BondTrouble trouble;
  make_fills(batch, trouble);
  for (std::size_t n = batch.from; n < batch.to; ++n) batch.records.push_back(record_of(n));
  batch.kept.assign(batch.records.size(), 1);
  const bool shared_out = wish_.overlap == CementRequest::trim;  // then no two bonds of this command overlap
  const int rows = static_cast<int>(shared_out ? first_row_ : table_.size() + batch.records.size());
  resolve(batch, overlaps(batch, rows), trouble);
  check_other_grains(batch, trouble);
  check_numbers(batch, trouble);
  trouble.stop(comm_);
  if (wish_.later) choose_templates(batch);
  else create(batch);
  if (me_ == 0) report(batch);
  for (std::size_t n = 0; n < batch.records.size(); ++n) {
    if (!batch.kept[n]) continue;
    const BondRecord& b = batch.records[n];
    table_.push_back(b);
    sums_.points += b.points;
    sums_.volume += b.volume;
    sums_.mass += b.mass(wish_.density);
  }
  if (live_ > kPointsOfABatch || !wish_.file.empty()) forget_fills();
}

void CementMaker::forget_fills() {
  for (Fill& f : fills_) {
    f.known = false;
    std::vector<FillPoint>().swap(f.points);
    std::fill(f.sent.begin(), f.sent.end(), 0);
  }
  live_ = 0.0;
}

// Makes points in the order of the bonds and of their lattices.
void CementMaker::create(const Batch& batch) {
  std::vector<NewBond> made;
  int row = static_cast<int>(table_.size());
  long long expected = 0;
  for (std::size_t k = 0; k < batch.records.size(); ++k) {
    if (!batch.kept[k]) continue;
    const BondRecord& record = batch.records[k];
    const Fill& f = fill_of(batch.from + k);
    made.push_back({row++, last_tag_ + 1, plan_.bonds()[batch.from + k].grain, record, f.points, f.box});
    expected += record.points;
    last_tag_ += record.points;
  }
  long long mine = static_cast<long long>(host_.create_points(made, batch.to < plan_.bonds().size())), created;
  MPI_Allreduce(&mine, &created, 1, MPI_LONG_LONG, MPI_SUM, comm_);
  if (created != expected)
    throw BadState(text_of("create_cement: ", expected - created, " of ", expected,
                           " points lie outside the simulation box; use a larger box or move the grains"));
  created_ += static_cast<double>(created);
}

// Gives the bonds templates instead of points.
void CementMaker::choose_templates(Batch& batch) {
  for (std::size_t k = 0; k < batch.records.size(); ++k) {
    if (!batch.kept[k]) continue;
    Fill& f = fills_[fill_of_bond_[batch.from + k]];
    if (f.point_template == 0) f.point_template = host_.template_of(f.points);
    batch.records[k].point_template = f.point_template;
  }
}

// The fill of the bond must be known.
BondRecord CementMaker::record_of(std::size_t n) const {
  const PlannedBond& bond = plan_.bonds()[n];
  const Fill& f = fill_of(n);
  BondRecord record = f.record;
  const GrainToBond &g0 = bond.grain[0], &g1 = bond.grain[1];
  const Eigen::Quaterniond to_box = bond.turn * f.turn;
  for (int s = 0; s < 2; ++s) {
    const GrainToBond& g = bond.grain[s];
    record.grain[s] = g.tag;
    record.radius[s] = g.radius;
    const Eigen::Quaterniond q = to_box.conjugate() * Eigen::Quaterniond(g.q[0], g.q[1], g.q[2], g.q[3]);
    const double orientation[4] = {q.w(), q.x(), q.y(), q.z()};
    std::copy(orientation, orientation + 4, record.orientation[s]);
    const Vector3 centre = f.turn.conjugate() * bond.pair.centre(s) - f.corner;
    for (int c = 0; c < 3; ++c) record.centre[s][c] = centre[c];
  }
  const double turn[4] = {to_box.w(), to_box.x(), to_box.y(), to_box.z()};
  std::copy(turn, turn + 4, record.axes);
  const std::array<double, 3> ahead = turned(axes_of(record), record.centre[0]);
  for (int c = 0; c < 3; ++c) {
    record.origin[c] = g0.x[c] - ahead[c];
    if (!plan_.box().periodic[c]) continue;
    // The shift is a multiple of the box. It is taken from integers, not from a difference of coordinates.
    record.shift[0][c] = std::round((g0.x[c] - g0.unwrapped[c]) / plan_.box().period[c]) * plan_.box().period[c];
    record.shift[1][c] = std::round((g0.x[c] + bond.between[c] - g1.unwrapped[c]) / plan_.box().period[c]) * plan_.box().period[c];
    record.box[c] = plan_.box().period[c];
  }
  return record;
}

// Reports the first bonds one by one, and the number of the others.
void CementMaker::report(const Batch& batch) {
  for (std::size_t k = 0; k < batch.records.size(); ++k) {
    if (!batch.kept[k]) continue;
    const CementPlan::Kind& kind = plan_.kind_of(batch.from + k);
    const bool thin =
        wish_.file.empty() && kind.film_share == 0.0 && !is_seam(kind, wish_) && kind.thinnest < 2.0 * wish_.spacing * (1.0 - 1e-9);
    const bool coarse = wish_.file.empty() && kind.width > 0.0 && cells_across(kind) < kFewCells * (1.0 - 1e-9);
    if (thin && listed_ >= kListed) thin_.add(kind.thinnest);
    if (coarse && listed_ >= kListed) coarse_.add(cells_across(kind));
    ++listed_;
    if (listed_ > kListed) continue;
    host_.say(report_of(batch.from + k, batch.records[k]));
    if (thin)
      host_.warn(text_of(
          "pair ", batch.records[k].grain[0], " ", batch.records[k].grain[1], ": the cement is ", kind.thinnest,
          " thin at its inner rim, less than two spacings: between rigid grains the cement there is too soft and will not break; use 'film "
          "joined', 'inner auto' or a "
          "larger 'inner'"));
    if (coarse)
      host_.warn(text_of("pair ", batch.records[k].grain[0], " ", batch.records[k].grain[1], ": the cement is ", cells_across(kind),
                         " cells of two points across where cells resolve it, and its strength "
                         "depends on the spacing below ",
                         kFewCells, "; use a spacing of at most ", wish_.spacing * cells_across(kind) / kFewCells,
                         narrow(kind) ? ", or a smaller 'inner'," : "", " to resolve it"));
  }
  if (batch.to < plan_.bonds().size() || listed_ <= kListed) return;
  host_.say(text_of("  ... and ", listed_ - kListed, " more bonds\n"));
  if (thin_.count > 0)
    host_.warn(text_of(
        thin_.count, " of these bonds are less than two spacings thin at their inner rim, the thinnest ", thin_.least,
        ": between rigid grains the cement there is too soft and will not break; use 'film joined', 'inner auto' or a larger 'inner'"));
  if (coarse_.count > 0)
    host_.warn(text_of(coarse_.count, " of these bonds are less than ", kFewCells,
                       " cells of two points across where cells resolve them, the least ", coarse_.least,
                       ", and their strength depends on the spacing; use a spacing of at most ", wish_.spacing * coarse_.least / kFewCells,
                       " to resolve them"));
}

// True if an inner radius of the script leaves less width than thickness.
bool CementMaker::narrow(const CementPlan::Kind& kind) const {
  return wish_.inner_rule == CementRequest::given && wish_.inner > 0.0 && kind.width < kind.thickness;
}

// Cells of two points across thickness or width, whichever is less. Cells need not resolve the thickness of a seam.
double CementMaker::cells_across(const CementPlan::Kind& kind) const {
  return (is_seam(kind, wish_) ? kind.width : std::min(kind.thickness, kind.width)) / (kCellOfPoints * wish_.spacing);
}

std::string CementMaker::report_of(std::size_t n, const BondRecord& record) {
  const PlannedBond& bond = plan_.bonds()[n];
  const CementPlan::Kind& kind_told = plan_.kind_of(n);
  const double whole = kind_told.volume;
  std::string what = wish_.file.empty() ? plan_.shape_of(bond.kind).describe() : "file '" + wish_.file + "'";
  if (wish_.file.empty() && record.volume < whole) what += text_of(", trimmed from a volume of ", whole);
  return text_of("Cement between grains ", record.grain[0], " and ", record.grain[1], ": ", what, "\n  volume ", record.volume,
                 ", content (mass over mass of the grains) ", record.mass(wish_.density) / (bond.grain[0].mass + bond.grain[1].mass),
                 ", attached area ", record.attached_area[0], " + ", record.attached_area[1], ", ", record.points, " points\n",
                 of_cells(kind_told, wish_));
}

std::string CementMaker::text_of_skipped() const {
  if (skipped_.empty()) return "";
  constexpr std::size_t kMost = 20;
  std::string pairs;
  for (std::size_t n = 0; n < std::min(skipped_.size(), kMost); ++n) pairs += text_of(" ", skipped_[n].first, "-", skipped_[n].second);
  if (skipped_.size() > kMost) pairs += " ...";
  return text_of(skipped_.size(), " bonds left out whose cement would overlap that of others, between grains", pairs, "\n");
}

}  // namespace mpdem
