// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "cement_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "../../geometry/bond_axes.h"
#include "../../geometry/composite.h"
#include "../../numerics/length.h"
#include "../../parallel/agree.h"
#include "../../parallel/gather_ranks.h"
#include "../../parallel/ranks.h"

namespace mpdem {

namespace {
constexpr double kRoundingOfLengths = 1e-9;                         // rounding of lengths that a script computed
enum PlanCheck { geometry, shape, position_of_points, thickness };  // checks of a bond, in their order
}  // namespace

// Keeps this error if it comes before the one it has, in the order of bonds, then of checks.
void BondTrouble::tell(std::size_t of_bond, int of_check, const std::string& why) {
  if (why.empty() || std::make_pair(of_bond, of_check) >= std::make_pair(bond, check)) return;
  bond = of_bond;
  check = of_check;
  text = why;
}

// All ranks throw the text of the rank whose error comes first. Bond and check are one number, so one minimum finds it.
void BondTrouble::stop(MPI_Comm comm) const {
  constexpr long long kChecks = 16;  // more than there are checks
  long long mine = static_cast<long long>(bond) * kChecks + check, first;
  MPI_Allreduce(&mine, &first, 1, MPI_LONG_LONG, MPI_MIN, comm);
  throw_if_any(comm, mine == first ? text : "");
}

std::string trouble_of_shared_id(int tag) {
  return text_of(
      "there are several atoms of ID ", tag,
      ", and cement knows its grains by their IDs; give each atom an ID of its own, in the data file it comes from for instance");
}

// Velocity of a rigid motion of each grain at the position, weighted by the distance to the surface of the other grain.
std::array<double, 3> velocity_between(const GrainToBond* grain, const std::array<double, 3>* arm) {
  double distance[2];
  for (int s = 0; s < 2; ++s) distance[s] = std::max(length(arm[s].data()) - grain[s].radius, 0.0);
  const double sum = distance[0] + distance[1];
  std::array<double, 3> v = {0, 0, 0};
  for (int s = 0; s < 2; ++s) {
    const double weight = sum > 0.0 ? distance[1 - s] / sum : 0.5;
    const GrainToBond& g = grain[s];
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, f = (d + 2) % 3;
      v[d] += weight * (g.v[d] + g.omega[e] * arm[s][f] - g.omega[f] * arm[s][e]);
    }
  }
  return v;
}

std::string CementPlan::prefix(const PlannedBond& bond) {
  return text_of("create_cement pair ", bond.grain[0].tag, " ", bond.grain[1].tag, ": ");
}

// Rounding of positions must not strain bonds noticeably. length: length over which an error of position is a strain.
// The limit is low since links are a hundred times as stiff as the cement: the same error is a stress a hundred times as
// large there.
std::string CementPlan::error_of_position(const PlannedBond& bond, double length) {
  constexpr double kMostStrain = 1e-8;
  double largest = 0.0;  // coordinate
  for (const GrainToBond& g : bond.grain)
    for (double x : g.x) largest = std::max(largest, std::fabs(x));
  const double rounding = std::numeric_limits<double>::epsilon() * largest;
  if (!(rounding > kMostStrain * length)) return "";
  return text_of("grains ", bond.grain[0].tag, " and ", bond.grain[1].tag, " are ", largest,
                 " from the origin, where positions are rounded to ", rounding, ", too much for a length of ", length,
                 "; place the box nearer to the origin, within ", kMostStrain * length / std::numeric_limits<double>::epsilon());
}

// Sets the geometry of the pair. Returns what is wrong with it, or an empty text.
std::string CementPlan::trouble_of_geometry(PlannedBond& bond) const {
  const GrainToBond &g0 = bond.grain[0], &g1 = bond.grain[1];
  const Vector3 centres = bond.between = box_.shortest(Vector3(g1.x[0] - g0.x[0], g1.x[1] - g0.x[1], g1.x[2] - g0.x[2]));
  bond.pair = pair_between(g0.radius, g1.radius, centres);
  const double gap = bond.pair.gap, smaller = std::min(g0.radius, g1.radius), reach = 0.5 * smaller;
  const std::string too_far = error_of_position(bond, smaller);
  if (!too_far.empty()) return too_far;
  if (!(centres.norm() > 0.0) || !(gap <= reach * (1.0 + kRoundingOfLengths)))
    return text_of("grains ", g0.tag, " and ", g1.tag, " are not neighbours: their gap ", gap, " exceeds half the smaller radius, ", reach,
                   "; bring them together or name other grains");
  if (!(gap > -0.2 * reach))
    return text_of("grains ", g0.tag, " and ", g1.tag, " overlap by ", -gap, ", more than a tenth of the smaller radius, ", 0.2 * reach,
                   "; move them apart, or name other grains");
  return "";
}

// Rotates the bond to its own axes, see bond_axes.h.
void CementPlan::choose_axes(PlannedBond& bond) {
  const BondAxes axes = bond_axes(bond.pair.n);
  bond.turn = axes.turn;
  bond.pair = pair_between(bond.pair.R1, bond.pair.R2, bond.between.norm() * axes.n);
}

// Checks the grains of each pair, then finds contents, kinds and shapes. An error ends the loop on all ranks alike, since
// all have the same pairs and grains. Errors of shapes are found by one rank each; BondTrouble::stop() tells the others.
void CementPlan::make(const std::vector<GrainTags>& pairs, const std::vector<GrainToBond>& grains, const std::vector<GrainTags>& before,
                      const std::function<void(CementRequest&)>& read_words, const Choice& choice) {
  std::unordered_multimap<int, GrainToBond> grain_of;
  for (const GrainToBond& g : gather_all(comm_, grains)) grain_of.emplace(g.tag, g);
  std::unordered_map<std::string, int> kinds;
  BondTrouble trouble;
  for (std::size_t n = 0; n < pairs.size(); ++n) {
    PlannedBond bond;
    std::string why;
    if (std::binary_search(before.begin(), before.end(), pairs[n]))
      why = text_of("grains ", pairs[n].first, " and ", pairs[n].second,
                    " have cement already, and it would overlap; use delete_bond before, or leave the pair out");
    for (int s = 0; s < 2; ++s) {
      const int tag = bond.grain[s].tag = s == 0 ? pairs[n].first : pairs[n].second;
      const std::size_t atoms = grain_of.count(tag);
      if (atoms == 1) bond.grain[s] = grain_of.find(tag)->second;
      if (!why.empty()) continue;
      if (atoms == 0) why = text_of("grain ", tag, " does not exist; create both grains before their cement");
      else if (atoms > 1) why = trouble_of_shared_id(tag);
      else if (bond.grain[s].is_point) why = text_of("atom ", tag, " is a material point, not a grain");
    }
    if (why.empty()) why = trouble_of_geometry(bond);
    if (!why.empty()) {
      trouble.tell(n, geometry, prefix(bond) + why);
      break;
    }
    if (n == 0) read_words(wish_);  // only now, so that wrong grains are reported before wrong options
    if (const double most = 0.5 * std::min(bond.pair.R1, bond.pair.R2); wish_.spacing > most) {
      trouble.tell(n, geometry,
                   prefix(bond) + text_of("'spacing ", wish_.spacing, "' is more than half the smaller radius, ", most,
                                          ", too coarse for any bond; it is the distance of material points, in the units of the script"));
      break;
    }
    if (wish_.file.empty()) choose_axes(bond);  // points of a file lie along the axes of the box
    const std::string too_far = error_of_position(bond, wish_.spacing);
    if (!too_far.empty()) trouble.tell(n, position_of_points, prefix(bond) + too_far);
    bonds_.push_back(bond);
  }
  if (wish_.contents.acts() && trouble.text.empty()) choose_contents(choice);
  for (std::size_t n = 0; n < bonds_.size(); ++n) bonds_[n].kind = kind_of(n, kinds);
  if (wish_.file.empty()) measure_kinds(trouble);
  trouble.stop(comm_);
  share_kinds();
}

// Sets the content of each bond, and leaves out pairs that get no cement.
void CementPlan::choose_contents(const Choice& choice) {
  const std::vector<double> contents = choice(*this);
  std::vector<PlannedBond> kept;
  for (std::size_t n = 0; n < bonds_.size(); ++n) {
    bonds_[n].content = contents[n];
    if (contents[n] > 0.0) kept.push_back(bonds_[n]);
  }
  bonds_.swap(kept);
}

// Bonds of one kind have the same shape. A kind is known by the bits of the numbers that decide the shape. Each bond with
// points of a file is a kind of its own.
int CementPlan::kind_of(std::size_t n, std::unordered_map<std::string, int>& kinds) {
  const PlannedBond& bond = bonds_[n];
  const GrainPair& p = bond.pair;
  const double numbers[] = {p.R1, p.R2, p.gap, p.n[0], p.n[1], p.n[2], bond.grain[0].mass + bond.grain[1].mass, bond.content};
  std::string key(reinterpret_cast<const char*>(numbers), sizeof numbers);
  if (!wish_.file.empty()) key += std::to_string(n);
  const auto known = kinds.emplace(std::move(key), static_cast<int>(kinds_.size()));
  if (known.second) {
    kinds_.emplace_back();
    kinds_.back().first = n;
  }
  return known.first->second;
}

double CementPlan::points_expected(std::size_t bond) const { return kind_of(bond).volume / std::pow(wish_.spacing, 3); }

// Each rank computes shapes and sizes of its share of the kinds.
void CementPlan::measure_kinds(BondTrouble& trouble) {
  const int ranks = ranks_of(comm_), me = rank_in(comm_);
  for (std::size_t k = me; k < kinds_.size(); k += ranks) {
    Kind& kind = kinds_[k];
    try {
      const Shape& made = shape_of(static_cast<int>(k));
      kind.volume = made.volume();
      for (int s = 0; s < 2; ++s) kind.area[s] = made.attached_area(s);
      kind.thinnest = made.smallest_thickness();
      const FilmFill& film = film_of(static_cast<int>(k));
      kind.film_share = (film.area[0] + film.area[1]) / (kind.area[0] + kind.area[1]);
      if (film.all) continue;  // the rest is about the part that cells fill
      kind.thickness = made.largest_thickness();
      kind.width = made.spans() - film.to;
      if (kind.thickness < kCellOfPoints * wish_.spacing && !is_seam(made, wish_.spacing))
        trouble.tell(
            kind.first, thickness,
            prefix(kind.first) + text_of("the cement is at most ", kind.thickness, " thick, less than a cell of two points of spacing ",
                                         wish_.spacing, "; use a spacing of at most ", 0.5 * kind.thickness, " or more cement"));
    } catch (const ShapeError& e) {
      trouble.tell(kind.first, shape, prefix(kind.first) + e.what());
    }
  }
}

// Gives the sizes of all kinds to all ranks. A kind is zero on all ranks but the one that measured it.
void CementPlan::share_kinds() {
  constexpr int kNumbers = 7;
  const int ranks = ranks_of(comm_), me = rank_in(comm_);
  std::vector<double> shared(kNumbers * kinds_.size(), 0.0);
  for (std::size_t k = me; k < kinds_.size(); k += ranks) {
    const Kind& kind = kinds_[k];
    const double numbers[kNumbers] = {kind.volume, kind.area[0], kind.area[1], kind.thickness, kind.thinnest, kind.film_share, kind.width};
    std::copy(numbers, numbers + kNumbers, &shared[kNumbers * k]);
  }
  MPI_Allreduce(MPI_IN_PLACE, shared.data(), static_cast<int>(shared.size()), MPI_DOUBLE, MPI_SUM, comm_);
  for (std::size_t k = 0; k < kinds_.size(); ++k) {
    const double* v = &shared[kNumbers * k];
    Kind& kind = kinds_[k];
    kind.volume = v[0];
    std::copy(v + 1, v + 3, kind.area);
    kind.thickness = v[3];
    kind.thinnest = v[4];
    kind.film_share = v[5];
    kind.width = v[6];
  }
}

// An inner radius is needed: where rigid spheres touch, the stiffness of a film between them has no bound.
double CementPlan::inner_of(const PlannedBond& bond) const {
  return wish_.inner_rule == CementRequest::given          ? wish_.inner
         : wish_.inner_rule == CementRequest::two_spacings ? bond.pair.radius_of_thickness(2.0 * wish_.spacing)
                                                           : bond.pair.usual_inner(wish_.share);
}

// Bond content of a shape; 0 if it has another size.
double CementPlan::content_of(const ShapeWords& words, const PlannedBond& bond) const {
  const auto given = words.given.find("content");
  return given == words.given.end() ? 0.0 : wish_.contents.acts() ? bond.content : given->second;
}

std::pair<double, double> CementPlan::content_bounds(const PlannedBond& bond) const {
  const double grain_mass = bond.grain[0].mass + bond.grain[1].mass;
  // more than both grains hold
  const double too_much = 1e3 * (std::pow(bond.pair.R1, 3) + std::pow(bond.pair.R2, 3));
  for (const ShapeWords& w : wish_.shapes) {
    if (!w.given.count("content")) continue;
    try {
      make_shape(w, bond.pair, too_much, inner_of(bond));
    } catch (const VolumeError& e) {
      // By rounding, a shape may refuse its own bounds.
      constexpr double kInside = 1e-9;
      const double to_content = wish_.density_of_shape(w) / grain_mass;
      return {e.least * (1.0 + kInside) * to_content, e.most * (1.0 - kInside) * to_content};
    }
  }
  throw ShapeError("no shape has its size from 'content'");
}

const Shape& CementPlan::shape_of(int kind) {
  Kind& k = kinds_[kind];
  if (k.shape) return *k.shape;
  const PlannedBond& bond = bonds_[k.first];
  const double grain_mass = bond.grain[0].mass + bond.grain[1].mass;
  const double inner = inner_of(bond);
  std::vector<std::unique_ptr<Shape>> made;
  for (const ShapeWords& w : wish_.shapes) {
    const double asked = content_of(w, bond), density = wish_.density_of_shape(w);
    try {
      made.push_back(make_shape(w, bond.pair, asked * grain_mass / density, inner));
    } catch (const VolumeError& e) {
      const double to_content = density / grain_mass;
      const bool per_cent = 0.01 * asked >= e.least * to_content && 0.01 * asked <= e.most * to_content;
      throw ShapeError(text_of("'content ", asked, "' must lie between ", e.least * to_content, " and ", e.most * to_content,
                               " here: it is the mass of the cement, of density ", density, ", over that of its two grains",
                               per_cent ? text_of(" (", asked, " % is 'content ", 0.01 * asked, "')") : "", "; ", e.what()));
    }
  }
  std::unique_ptr<Shape> shape;
  if (made.size() == 1) shape = std::move(made.front());
  else shape = std::make_unique<Composite>(std::move(made));
  // With 'inner auto' no cement is too thin for cells. film_fill() would still make all of a narrow bond film.
  if (wish_.film && wish_.inner_rule != CementRequest::two_spacings) k.film = film_fill(*shape, wish_.spacing);
  if (!k.film.empty() && !k.film.all) k.resolved = shape->with_inner(k.film.to);
  k.shape = std::move(shape);
  return *k.shape;
}

const Shape& CementPlan::resolved_of(int kind) {
  const Shape& whole = shape_of(kind);
  return kinds_[kind].resolved ? *kinds_[kind].resolved : whole;
}

std::vector<std::vector<CementPlan::Near>> CementPlan::neighbours() {
  struct PlacedBond {
    Vector3 middle;
    std::size_t bond;
    bool image;
  };
  double widest = 0.0;
  std::vector<Vector3> extent;  // half of the extent, along the axes of the box
  for (const PlannedBond& b : bonds_) {
    extent.push_back(b.turn.toRotationMatrix().cwiseAbs() * shape_of(b.kind).half_extent());
    widest = std::max(widest, extent.back().maxCoeff());
  }
  const Vector3 low(box_.low[0], box_.low[1], box_.low[2]), high(box_.high[0], box_.high[1], box_.high[2]);
  const int images[3] = {box_.periodic[0], box_.periodic[1], box_.periodic[2]};
  std::vector<PlacedBond> places;
  for (std::size_t n = 0; n < bonds_.size(); ++n)
    for (int i = -images[0]; i <= images[0]; ++i)
      for (int j = -images[1]; j <= images[1]; ++j)
        for (int k = -images[2]; k <= images[2]; ++k) {
          const Vector3 x = bonds_[n].middle() + Vector3(i * box_.period[0], j * box_.period[1], k * box_.period[2]);
          const bool image = i != 0 || j != 0 || k != 0;
          // Middles lie up to a radius outside the box, near the first grain.
          const double reach = 2.0 * widest + bonds_[n].pair.R1;
          if (image && ((x - low).minCoeff() < -reach || (high - x).minCoeff() < -reach)) continue;
          places.push_back({x, n, image});
        }
  std::sort(places.begin(), places.end(), [](const PlacedBond& a, const PlacedBond& b) {
    return a.middle[0] != b.middle[0] ? a.middle[0] < b.middle[0] : a.bond < b.bond;
  });
  std::vector<std::vector<Near>> near(bonds_.size());
  for (std::size_t n = 0; n < places.size(); ++n)
    for (std::size_t m = n + 1; m < places.size() && places[m].middle[0] - places[n].middle[0] <= 2.0 * widest; ++m) {
      const PlacedBond &a = places[n], &b = places[m];
      const Vector3 apart = b.middle - a.middle;
      if ((apart.cwiseAbs().array() > (extent[a.bond] + extent[b.bond]).array()).any()) continue;
      const Eigen::Quaterniond of_a = bonds_[a.bond].turn.conjugate(), of_b = bonds_[b.bond].turn.conjugate();
      if (!a.image) near[a.bond].push_back({b.bond, of_a * apart, of_b * bonds_[a.bond].turn});
      if (!b.image) near[b.bond].push_back({a.bond, -(of_b * apart), of_a * bonds_[b.bond].turn});
    }
  return near;
}

}  // namespace mpdem
