// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "point_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>
#include <type_traits>

#include "../../geometry/bond_axes.h"
#include "../../mpm/point_row.h"
#include "../../numerics/text_of.h"

namespace mpdem {

namespace {

// Names of columns that come together or not at all.
using Group = std::vector<std::string>;
template <std::size_t n>
Group group(const char* const (&names)[n]) {
  return {names, names + n};
}
const Group kPosition = group(PointRow::kPlace), kAxis = group(PointRow::kAxis), kTensor = group(PointRow::kDamage),
            kPrincipal = {"d1", "d2", "d3", "v1x", "v1y", "v1z", "v2x", "v2y", "v2z"}, kFailed = group(PointRow::kFailed),
            kGrains = group(PointRow::kGrain), kArea = group(PointRow::kArea), kFoot = group(PointRow::kFoot),
            kAttached = group(PointRow::kAttached), kLinkDamage = group(PointRow::kLinkDamage), kMaterial = group(PointRow::kMaterial);
// Attached points can be centroids of cut cells. Foot points of patches can be those of neighbours.
constexpr double kFurthestFoot = 4.0;  // spacings
// Neither area nor volume of a point can be larger than what lies within that distance of it.
constexpr double kLargestArea = 4.0 * kFurthestFoot * kFurthestFoot;                    // squares of the spacing
constexpr double kLargestVolume = 8.0 * kFurthestFoot * kFurthestFoot * kFurthestFoot;  // cubes of the spacing
constexpr double kMostOfSphere = 1.05;  // share of the surface of a sphere that may be attached; patches are flat

template <class... T>
[[noreturn]] void stop(const T&... parts) {
  std::ostringstream s;
  s.precision(10);
  (s << ... << parts);
  throw ShapeError(s.str());
}

class Reader {
 public:
  // Skips the byte order mark with which spreadsheets begin a file.
  Reader(const std::string& text, const std::string& name) : text_(text), name_(name), at_(text.rfind("\xEF\xBB\xBF", 0) == 0 ? 3 : 0) {}

  // Reads the words of the next line that has any, without comments. Returns false at the end.
  bool next(std::vector<std::string>& words) {
    words.clear();
    while (words.empty() && at_ < text_.size()) {
      const std::size_t end = std::min(text_.find('\n', at_), text_.size());
      std::string line = text_.substr(at_, end - at_);
      at_ = end + 1;
      ++line_;
      std::istringstream in(line.substr(0, line.find('#')));
      for (std::string w; in >> w;) words.push_back(w);
    }
    return !words.empty();
  }
  int line() const { return line_; }
  std::string where() const { return where(line_); }
  std::string where(int line) const { return line_in_file(name_, line); }

 private:
  const std::string &text_, &name_;
  std::size_t at_;
  int line_ = 0;
};

// Columns by name. A group is present as a whole or not at all.
class Columns {
 public:
  Columns(const std::vector<std::string>& names, const std::string& where) : count_(names.size()) {
    std::map<std::string, const Group*> known;
    std::string list;
    for (const auto* g :
         {&kPosition, &kAxis, &kTensor, &kPrincipal, &kFailed, &kGrains, &kArea, &kFoot, &kAttached, &kLinkDamage, &kMaterial})
      for (const std::string& n : *g) {
        known[n] = g;
        list += (list.empty() ? "" : " ") + n;
      }
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i].find(',') != std::string::npos) stop(where, "'", names[i], "' has commas; columns are separated by blanks");
      if (!known.count(names[i])) stop(where, "unknown column '", names[i], "' in the line that names the columns; known are ", list);
      if (!column_.emplace(names[i], static_cast<int>(i)).second) stop(where, "column '", names[i], "' is named twice");
    }
    for (const auto& k : known)
      if (has(*k.second) || k.second == &kPosition)
        if (!column_.count(k.first)) stop(where, "column '", k.first, "' is missing; it is needed with the others");
    if (has(kTensor) && has(kPrincipal)) stop(where, "damage is given twice, by 'dxx ...' and by 'd1 ...'; use one of them");
    if ((has(kFoot) || has(kAttached)) && !has(kArea)) stop(where, "columns 'foot_..' and 'attached_..' need 'area_i area_j'");
    if (has(kLinkDamage) && !has(kAttached)) stop(where, "columns 'damage_i damage_j' need 'attached_i attached_j'");
  }
  std::size_t count() const { return count_; }
  bool has(const Group& group) const {
    return std::any_of(group.begin(), group.end(), [&](const std::string& n) { return column_.count(n) != 0; });
  }
  bool has(const std::string& name) const { return column_.count(name) != 0; }
  int of(const std::string& name) const { return column_.at(name); }
  const std::map<std::string, int>& all() const { return column_; }

 private:
  std::size_t count_;
  std::map<std::string, int> column_;
};

double number(const std::string& word, const std::string& column, const std::string& where) {
  const char* first = word.c_str() + (word[0] == '+' && word[1] != '-' ? 1 : 0);
  const char* last = word.c_str() + word.size();
  double v = 0.0;
  const auto r = std::from_chars(first, last, v);
  // Subnormal and smaller numbers give an error too, but are as good as zero.
  if (r.ec == std::errc::result_out_of_range && r.ptr == last) v = std::strtod(first, nullptr);
  else if (r.ec != std::errc() || r.ptr != last) stop(where, "'", word, "' in column '", column, "' is not a number");
  if (!std::isfinite(v)) stop(where, "'", word, "' in column '", column, "': a finite number is needed");
  return v;
}

bool flag(double v, const std::string& column, const std::string& where) {
  if (v != 0.0 && v != 1.0) stop(where, "column '", column, "' is ", v, "; must be 0 or 1");
  return v == 1.0;
}

// Returns the ID of a grain.
int grain_of(double v, const std::string& column, const std::string& where) {
  if (v != std::floor(v) || v < 1.0 || v > std::numeric_limits<int>::max())
    stop(where, "column '", column, "' is ", v, "; the ID of a grain is needed, a whole number of at least 1");
  return static_cast<int>(v);
}

// Returns the number of a material; text says what is wrong.
int material_of(double v, int materials, const std::string& where) {
  if (v != std::floor(v) || v < 0.0 || v >= materials)
    stop(where, "column '", PointRow::kMaterial[0], "' is ", v, "; the scene has ", materials, " materials, numbers 0 (of fix mpm) to ",
         materials - 1, " in the order of the commands cement_material");
  return static_cast<int>(v);
}

using Matrix3 = Eigen::Matrix3d;

Matrix3 principal_damage(const std::array<double, 9>& v, const std::string& where) {
  const Vector3 a(v[3], v[4], v[5]), b(v[6], v[7], v[8]);
  if (!(a.norm() > 0.0) || !(b.norm() > 0.0)) stop(where, "a direction of the damage is zero");
  if (std::fabs(a.normalized().dot(b.normalized())) > 1e-3)
    stop(where, "directions v1 and v2 of the damage are not at right angles, their cosine is ", a.normalized().dot(b.normalized()));
  Matrix3 R;
  R.col(0) = a.normalized();
  R.col(2) = a.cross(b).normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  return R * Vector3(v[0], v[1], v[2]).asDiagonal() * R.transpose();
}

void check_damage(const Matrix3& D, const std::string& where) {
  const Vector3 e = Eigen::SelfAdjointEigenSolver<Matrix3>(D, Eigen::EigenvaluesOnly).eigenvalues();
  if (!(e[0] >= -1e-9) || !(e[2] < 1.0))
    stop(where, "damage has eigenvalues from ", e[0], " to ", e[2], "; they must lie in [0, 1), below the cut-off of fix mpm");
}

std::array<long, 3> cell_of(const Vector3& x, double spacing) {
  std::array<long, 3> c;
  for (int d = 0; d < 3; ++d) c[d] = static_cast<long>(std::floor(x[d] / spacing));
  return c;
}

// Sorts the points by their cells from `corner`. Returns the second point of the first pair that shares a cell and sets
// `other` to the first, or returns -1.
int shared_cell(const std::vector<FillPoint>& p, const Vector3& corner, double spacing, int& other) {
  std::vector<std::pair<std::array<long, 3>, int>> cells;
  for (std::size_t i = 0; i < p.size(); ++i) cells.emplace_back(cell_of(p[i].X - corner, spacing), static_cast<int>(i));
  std::sort(cells.begin(), cells.end());
  for (std::size_t i = 1; i < cells.size(); ++i)
    if (cells[i].first == cells[i - 1].first) {
      other = cells[i - 1].second;
      return cells[i].second;
    }
  return -1;
}

// Whether a point lies within rounding of a face between cells.
bool on_a_face(const std::vector<FillPoint>& p, double spacing) {
  for (const FillPoint& f : p)
    for (int d = 0; d < 3; ++d)
      if (std::fabs(std::remainder(f.X[d], spacing)) < 1e-6 * spacing) return true;
  return false;
}

// Returns the corner of a lattice in whose cells the points lie in the middle, on average. The mean is one of angles, since
// positions in cells are periodic.
Vector3 beside_the_points(const std::vector<FillPoint>& p, double spacing) {
  Vector3 corner;
  for (int d = 0; d < 3; ++d) {
    double c = 0.0, s = 0.0;
    for (const FillPoint& f : p) {
      c += std::cos(2.0 * M_PI * f.X[d] / spacing);
      s += std::sin(2.0 * M_PI * f.X[d] / spacing);
    }
    corner[d] = std::remainder(spacing * (std::atan2(s, c) / (2.0 * M_PI) - 0.5), spacing);
  }
  return corner;
}

// Whether the points of `full` lie near the centres of their cells, and all points in cells of their own.
bool is_lattice(const std::vector<FillPoint>& p, const std::vector<FillPoint>& full, const Vector3& corner, double spacing) {
  for (const FillPoint& f : full)
    for (int d = 0; d < 3; ++d)
      if (std::fabs(std::remainder(f.X[d] - corner[d] - 0.5 * spacing, spacing)) > 0.02 * spacing) return false;
  int other;
  return shared_cell(p, corner, spacing, other) < 0;
}

// Lattice with the points of full cells at the centres of its cells, if there is one.
struct FullLattice {
  double largest_volume = 0.0;
  Vector3 corner;
  bool regular;
  FullLattice(const std::vector<FillPoint>& points, double spacing) {
    for (const FillPoint& p : points) largest_volume = std::max(largest_volume, p.volume);
    std::vector<FillPoint> full;  // centroids of cut cells are off the centre
    for (const FillPoint& p : points)
      if (p.volume > 0.99 * largest_volume) full.push_back(p);
    corner = beside_the_points(full, spacing);
    // Shapes use the corner 0. A corner that differs by rounding of the file becomes the same.
    if (corner.cwiseAbs().maxCoeff() < 1e-3 * spacing) corner.setZero();
    regular = is_lattice(points, full, corner, spacing);
  }
};

// Reads a row of the file, for the columns that it has.
class RowReader : public record_detail::Visitor<RowReader> {
 public:
  RowReader(const Columns& columns, const std::vector<double>& numbers, const std::string& where)
      : columns_(columns), numbers_(numbers), where_(where) {}
  template <class T>
  void put(const char* name, T& field, Range) {
    if (!columns_.has(std::string(name)) || name == std::string(PointRow::kMaterial[0])) return;
    const double v = numbers_[columns_.of(name)];
    if constexpr (std::is_same_v<T, bool>) field = flag(v, name, where_);
    else if constexpr (std::is_same_v<T, int>) field = grain_of(v, name, where_);
    else field = v;
  }

 private:
  const Columns& columns_;
  const std::vector<double>& numbers_;
  const std::string& where_;
};

// Reads a file for one pair of grains, then checks the points together.
class PointFile {
 public:
  PointFile(const std::string& text, const std::string& name, const GrainPair& pair, const PointFileOptions& options)
      : o_(options),
        pair_(pair),
        name_(name),
        file_(text, name),
        columns_(first_line()),
        attach_(o_.attach > 0.0 ? o_.attach : o_.spacing) {}

  PointCloud read() {
    if (attach_ > kFurthestFoot * o_.spacing)
      stop("'attach ", attach_, "': must be at most ", kFurthestFoot, " spacings, ", kFurthestFoot * o_.spacing,
           "; or give the areas of links in columns 'area_i area_j'");
    std::vector<std::string> words;
    std::vector<double> numbers(columns_.count());
    while (file_.next(words)) {
      const std::string where = file_.where();
      if (words.size() != columns_.count()) stop(where, words.size(), " numbers, but ", columns_.count(), " columns are named");
      for (const auto& c : columns_.all()) numbers[c.second] = number(words[c.second], c.first, where);
      if (is_of_others(numbers, where)) continue;
      cloud_.points.push_back(point_of(numbers, where));
      line_.push_back(file_.line());
    }
    check_whole();
    choose_axes();
    find_corner();
    find_lattice();
    measure();
    return std::move(cloud_);
  }

 private:
  Columns first_line() {
    std::vector<std::string> words;
    if (!file_.next(words)) stop("file '", name_, "' is empty; a line with the names of the columns is needed, and one a point");
    return Columns(words, file_.where());
  }

  bool is_of_others(const std::vector<double>& numbers, const std::string& where) {
    if (!columns_.has(kGrains)) return false;
    int grain[2];
    for (int s = 0; s < 2; ++s) grain[s] = grain_of(numbers[columns_.of(kGrains[s])], kGrains[s], where);
    if (grain[0] == grain[1]) stop(where, "'grain_i' and 'grain_j' are both ", grain[0], "; two different grains are needed");
    if (std::min(grain[0], grain[1]) == o_.tag[0] && std::max(grain[0], grain[1]) == o_.tag[1]) return false;
    for (int g : grain) cloud_.other_grains.emplace(g, file_.line());
    return true;
  }

  FillPoint point_of(const std::vector<double>& numbers, const std::string& where) {
    PointRow row;
    row.has_axis = columns_.has(kAxis);
    row.has_link_damage = columns_.has(kLinkDamage);
    row.has_material = columns_.has(kMaterial);
    RowReader reader(columns_, numbers, where);
    PointRow::describe(row, reader);
    FillPoint p;
    p.X = o_.to_bond(Vector3(row.x[0], row.x[1], row.x[2]));
    p.volume = row.volume;
    if (!(p.volume > 0.0)) stop(where, "volume ", p.volume, " must be greater than 0");
    if (p.volume > kLargestVolume * std::pow(o_.spacing, 3))
      stop(where, "volume ", p.volume, " is ", p.volume / std::pow(o_.spacing, 3), " times a cell of a lattice of spacing ", o_.spacing,
           "; check the units of lengths and volumes and the spacing");
    if (row.has_axis) {
      p.axis = Vector3(row.axis[0], row.axis[1], row.axis[2]);
      if (!(p.axis.norm() > 0.0)) stop(where, "axis 0 0 0: a direction is needed, or leave the columns 'ax ay az' out");
      p.axis.normalize();
    }
    take_damage(row, numbers, where, p);
    p.failed = row.failed;
    p.material = row.has_material ? material_of(numbers[columns_.of(PointRow::kMaterial[0])], o_.materials, where) : o_.material;
    for (int s = 0; s < 2; ++s) attach(row, s, where, p);
    return p;
  }

  void take_damage(const PointRow& row, const std::vector<double>& numbers, const std::string& where, FillPoint& p) const {
    if (columns_.has(kTensor)) {
      std::copy(row.damage, row.damage + 6, p.damage);
    } else if (columns_.has(kPrincipal)) {
      std::array<double, 9> a;
      for (int i = 0; i < 9; ++i) a[i] = numbers[columns_.of(kPrincipal[i])];
      const Matrix3 D = principal_damage(a, where);
      const double full[6] = {D(0, 0), D(1, 1), D(2, 2), D(1, 2), D(0, 2), D(0, 1)};
      std::copy(full, full + 6, p.damage);
    } else {
      return;
    }
    const double* D = p.damage;
    check_damage((Matrix3() << D[0], D[5], D[4], D[5], D[1], D[3], D[4], D[3], D[2]).finished(), where);
  }

  void attach(const PointRow& row, int s, const std::string& where, FillPoint& p) {
    const double R = pair_.radius(s);
    const Vector3 from = p.X - pair_.centre(s);
    const double r = from.norm();
    if (r < R - 0.5 * o_.spacing)
      stop(where, "the point lies ", R - r, " inside grain ", o_.tag[s], ", more than half the spacing, ", 0.5 * o_.spacing,
           "; check the units and the positions of the grains");
    FillPoint::Attachment k;
    k.side = s;
    k.foot = pair_.centre(s) + R * from.normalized();
    k.attached = !p.failed;
    if (columns_.has(kArea)) {
      if (!take_area(row.side[s], where, p, k)) return;
    } else {
      if (r - R > attach_) return;
      // Cement that is thinner than `attach` is attached over its whole thickness.
      const double z = p.X.dot(pair_.n), rho = std::sqrt(std::max(p.X.squaredNorm() - z * z, 0.0));
      const bool between = z > pair_.height(0) && z < pair_.height(1) && rho < std::min(pair_.R1, pair_.R2);
      const double layer = between ? std::min(attach_, std::max(pair_.thickness(rho), 1e-3 * attach_)) : attach_;
      k.area = p.volume * R * R / (r * r * layer);
    }
    cloud_.attached_area[s] += k.area;
    p.link[p.link_count++] = k;
  }

  // Reads the area from the file. Returns false if it is zero.
  bool take_area(const PointRow::Side& side, const std::string& where, const FillPoint& p, FillPoint::Attachment& k) const {
    const int s = k.side;
    k.area = side.area;
    if (!(k.area >= 0.0)) stop(where, "area ", k.area, " must not be negative");
    if (k.area == 0.0) return false;
    if (k.area > kLargestArea * o_.spacing * o_.spacing)
      stop(where, "area ", k.area, " at grain ", o_.tag[s], " is ", k.area / (o_.spacing * o_.spacing),
           " times a face of a lattice of spacing ", o_.spacing, "; check the units of lengths and areas and the spacing");
    if (columns_.has(kFoot)) k.foot = o_.to_bond(Vector3(side.foot[0], side.foot[1], side.foot[2]));
    const double off = (k.foot - pair_.centre(s)).norm() - pair_.radius(s);
    if (std::fabs(off) > 1e-6 * pair_.radius(s))
      stop(where, "foot point is ", off, " off the surface of grain ", o_.tag[s],
           "; use the units and the positions of the grains for which the file was written");
    if ((k.foot - p.X).norm() > kFurthestFoot * o_.spacing)
      stop(where, "the point is ", (k.foot - p.X).norm(), " from where it is attached to grain ", o_.tag[s], ", more than ", kFurthestFoot,
           " spacings");
    if (columns_.has(kAttached)) k.attached = side.attached && (columns_.has(kLinkDamage) || !p.failed);
    k.damage = side.damage;
    if (!(k.damage >= 0.0 && k.damage <= 1.0))
      stop(where, "column '", PointRow::kLinkDamage[s], "' is ", k.damage, "; the damage of a link must lie between 0 and 1");
    if (k.attached && k.damage == 1.0)
      stop(where, "'", PointRow::kLinkDamage[s], "' is 1 but '", PointRow::kAttached[s],
           "' is 1 too; a link of damage 1 has debonded: make one of them less");
    return true;
  }

  void check_whole() const {
    if (cloud_.points.empty()) {
      if (columns_.has(kGrains) && file_.line() > 1)
        stop("file '", name_, "' has no points of grains ", o_.tag[0], " and ", o_.tag[1], " (columns 'grain_i grain_j')");
      stop("file '", name_, "' has no points");
    }
    for (int s = 0; s < 2; ++s)
      if (cloud_.attached_area[s] == 0.0)
        stop("file '", name_, "': nothing is attached to grain ", o_.tag[s], "; ",
             columns_.has(kArea)
                 ? text_of("column '", kArea[s],
                           "' is 0 in all lines; give the area of the grain's surface that a point bonds, or leave 'area_i area_j' out")
                 : text_of("no point is within ", attach_,
                           " of its surface (keyword 'attach', default one spacing); check the units and the positions of the grains"));
    for (int s = 0; s < 2; ++s) {
      const double sphere = 4.0 * M_PI * pair_.radius(s) * pair_.radius(s);
      if (cloud_.attached_area[s] > kMostOfSphere * sphere)
        stop("file '", name_, "': the attached area at grain ", o_.tag[s], " is ", cloud_.attached_area[s],
             " in all, more than its surface, ", sphere, "; check the units of lengths and areas");
    }
  }

  // Keeps the axes of the box, unless the points have a lattice only along those of the bond.
  void choose_axes() {
    if (FullLattice(cloud_.points, o_.spacing).regular) return;
    const BondAxes axes = bond_axes(pair_.n);
    std::vector<FillPoint> turned = cloud_.points;
    const Matrix3 T = axes.turn.conjugate().toRotationMatrix();
    for (FillPoint& p : turned) {
      p.X = T * p.X;
      p.axis = T * p.axis;
      for (int k = 0; k < p.link_count; ++k) p.link[k].foot = T * p.link[k].foot;
      const double* D = p.damage;
      const Matrix3 d = T * (Matrix3() << D[0], D[5], D[4], D[5], D[1], D[3], D[4], D[3], D[2]).finished() * T.transpose();
      const double along[6] = {d(0, 0), d(1, 1), d(2, 2), d(1, 2), d(0, 2), d(0, 1)};
      std::copy(along, along + 6, p.damage);
    }
    if (!FullLattice(turned, o_.spacing).regular) return;
    cloud_.points.swap(turned);
    cloud_.turn = axes.turn;
    n_ = axes.n;
  }

  void find_corner() {
    int other = -1, twice = shared_cell(cloud_.points, cloud_.corner, o_.spacing, other);
    if (twice >= 0 || on_a_face(cloud_.points, o_.spacing)) {
      cloud_.corner = beside_the_points(cloud_.points, o_.spacing);
      twice = shared_cell(cloud_.points, cloud_.corner, o_.spacing, other);
    }
    if (twice < 0) return;
    const double apart = (cloud_.points[twice].X - cloud_.points[other].X).norm();
    const std::string where = file_.where(std::max(line_[twice], line_[other]));
    const int earlier = std::min(line_[twice], line_[other]);
    if (apart < 1e-6 * o_.spacing) stop(where, "the point repeats that of line ", earlier);
    stop(where, "the point shares a cell of a lattice of spacing ", o_.spacing, " with that of line ", earlier, ", ", apart,
         " away; points must lie on a cubic lattice along the axes of the box or of the bond: use its spacing");
  }

  void find_lattice() {
    const FullLattice found(cloud_.points, o_.spacing);
    cloud_.largest_volume = found.largest_volume;
    cloud_.regular = found.regular;
    cloud_.lattice = found.regular ? found.corner : cloud_.corner;
  }

  void measure() {
    double low = 1e300, high = -1e300, thickest = 0.0;
    for (const FillPoint& p : cloud_.points) {
      const double z = p.X.dot(n_), r = std::sqrt(std::max(p.X.squaredNorm() - z * z, 0.0));
      cloud_.volume += p.volume;
      low = std::min(low, z);
      high = std::max(high, z);
      thickest = std::max(thickest, pair_.thickness(std::min(r, std::min(pair_.R1, pair_.R2))));
    }
    cloud_.thickness = std::min(thickest, high - low + o_.spacing);
  }

  const PointFileOptions& o_;
  const GrainPair& pair_;
  const std::string& name_;
  Reader file_;
  Columns columns_;
  double attach_;
  PointCloud cloud_;
  Vector3 n_ = pair_.n;    // direction of the line of centres, in the axes of the points
  std::vector<int> line_;  // line of each point
};

}  // namespace

std::string line_in_file(const std::string& name, int line) { return "file '" + name + "', line " + std::to_string(line) + ": "; }

PointCloud read_points(const std::string& text, const std::string& name, const GrainPair& pair, const PointFileOptions& o) {
  return PointFile(text, name, pair, o).read();
}

}  // namespace mpdem
