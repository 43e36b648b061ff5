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

namespace mpdem {

namespace {

const std::vector<std::string> kPosition = {"x", "y", "z", "volume"}, kAxis = {"ax", "ay", "az"},
                               kTensor = {"dxx", "dyy", "dzz", "dyz", "dxz", "dxy"},
                               kPrincipal = {"d1", "d2", "d3", "v1x", "v1y", "v1z", "v2x", "v2y", "v2z"},
                               kFailed = {"failed"}, kGrains = {"grain_i", "grain_j"}, kArea = {"area_i", "area_j"},
                               kFoot = {"foot_ix", "foot_iy", "foot_iz", "foot_jx", "foot_jy", "foot_jz"},
                               kAttached = {"attached_i", "attached_j"};
// Attached points can be centroids of cells cut by the surface, feet of patches those of neighbours.
constexpr double kFurthestFoot = 4.0;  // spacings
// So neither area nor volume of a point can be larger than what lies within that distance of it.
constexpr double kLargestArea = 4.0 * kFurthestFoot * kFurthestFoot;                    // squares of the spacing
constexpr double kLargestVolume = 8.0 * kFurthestFoot * kFurthestFoot * kFurthestFoot;  // cubes of the spacing
constexpr double kMostOfSphere = 1.05;  // of its surface may be attached; patches are flat

template <class... T>
[[noreturn]] void stop(const T&... parts) {
  std::ostringstream s;
  s.precision(10);
  (s << ... << parts);
  throw ShapeError(s.str());
}

class Reader {
 public:
  Reader(const std::string& text, const std::string& name) : text_(text), name_(name) {}

  // Words of the next line that has any, without comments; false at the end.
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
  std::string place() const { return place(line_); }
  std::string place(int line) const { return place_in_file(name_, line); }

 private:
  const std::string &text_, &name_;
  std::size_t at_ = 0;
  int line_ = 0;
};

// Columns by name; a group is there as a whole or not at all.
class Columns {
 public:
  Columns(const std::vector<std::string>& names, const std::string& place) : count_(names.size()) {
    std::map<std::string, const std::vector<std::string>*> known;
    std::string list;
    for (const auto* g : {&kPosition, &kAxis, &kTensor, &kPrincipal, &kFailed, &kGrains, &kArea, &kFoot, &kAttached})
      for (const std::string& n : *g) {
        known[n] = g;
        list += (list.empty() ? "" : " ") + n;
      }
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (!known.count(names[i])) stop(place, "unknown column '", names[i], "' in the line that names the columns; known are ", list);
      if (!column_.emplace(names[i], static_cast<int>(i)).second) stop(place, "column '", names[i], "' is named twice");
    }
    for (const auto& k : known)
      if (has(*k.second) || k.second == &kPosition)
        if (!column_.count(k.first)) stop(place, "column '", k.first, "' is missing; it is needed with the others");
    if (has(kTensor) && has(kPrincipal)) stop(place, "damage is given twice, by 'dxx ...' and by 'd1 ...'; use one of them");
    if ((has(kFoot) || has(kAttached)) && !has(kArea)) stop(place, "columns 'foot_..' and 'attached_..' need 'area_i area_j'");
  }
  std::size_t count() const { return count_; }
  bool has(const std::vector<std::string>& group) const {
    return std::any_of(group.begin(), group.end(), [&](const std::string& n) { return column_.count(n) != 0; });
  }
  int of(const std::string& name) const { return column_.at(name); }
  const std::map<std::string, int>& all() const { return column_; }

 private:
  std::size_t count_;
  std::map<std::string, int> column_;
};

double number(const std::string& word, const std::string& column, const std::string& place) {
  const char* first = word.c_str() + (word[0] == '+' ? 1 : 0);
  const char* last = word.c_str() + word.size();
  double v = 0.0;
  const auto r = std::from_chars(first, last, v);
  // Subnormal and smaller numbers come with an error too, but are as good as zero.
  if (r.ec == std::errc::result_out_of_range && r.ptr == last) v = std::strtod(first, nullptr);
  else if (r.ec != std::errc() || r.ptr != last) stop(place, "'", word, "' in column '", column, "' is not a number");
  if (!std::isfinite(v)) stop(place, "'", word, "' in column '", column, "': a finite number is needed");
  return v;
}

bool flag(double v, const std::string& column, const std::string& place) {
  if (v != 0.0 && v != 1.0) stop(place, "column '", column, "' is ", v, "; must be 0 or 1");
  return v == 1.0;
}

// An ID of a grain.
int grain_of(double v, const std::string& column, const std::string& place) {
  if (v != std::floor(v) || v < 1.0 || v > std::numeric_limits<int>::max())
    stop(place, "column '", column, "' is ", v, "; the ID of a grain is needed, a whole number of at least 1");
  return static_cast<int>(v);
}

using Matrix3 = Eigen::Matrix3d;

Matrix3 principal_damage(const std::array<double, 9>& v, const std::string& place) {
  const Vector3 a(v[3], v[4], v[5]), b(v[6], v[7], v[8]);
  if (!(a.norm() > 0.0) || !(b.norm() > 0.0)) stop(place, "a direction of the damage is zero");
  if (std::fabs(a.normalized().dot(b.normalized())) > 1e-3)
    stop(place, "directions v1 and v2 of the damage are not at right angles, their cosine is ", a.normalized().dot(b.normalized()));
  Matrix3 R;
  R.col(0) = a.normalized();
  R.col(2) = a.cross(b).normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  return R * Vector3(v[0], v[1], v[2]).asDiagonal() * R.transpose();
}

void check_damage(const Matrix3& D, const std::string& place) {
  const Vector3 e = Eigen::SelfAdjointEigenSolver<Matrix3>(D, Eigen::EigenvaluesOnly).eigenvalues();
  if (!(e[0] >= -1e-9) || !(e[2] < 1.0))
    stop(place, "damage has eigenvalues from ", e[0], " to ", e[2], "; they must lie in [0, 1), below the cut-off of fix mpm");
}

std::array<long, 3> cell_of(const Vector3& x, double spacing) {
  std::array<long, 3> c;
  for (int d = 0; d < 3; ++d) c[d] = static_cast<long>(std::floor(x[d] / spacing));
  return c;
}

// Order of the points by their cells from `corner`; first pair that shares one, or -1.
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

// Is a point within rounding of a face between cells?
bool on_a_face(const std::vector<FillPoint>& p, double spacing) {
  for (const FillPoint& f : p)
    for (int d = 0; d < 3; ++d)
      if (std::fabs(std::remainder(f.X[d], spacing)) < 1e-6 * spacing) return true;
  return false;
}

// Half a spacing beside the mean place of the points in their cells (a mean of angles).
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

// Do these lie within a small part of the spacing of the middle of their cells, and all points in cells of their own?
bool is_lattice(const std::vector<FillPoint>& p, const std::vector<FillPoint>& full, const Vector3& corner, double spacing) {
  for (const FillPoint& f : full)
    for (int d = 0; d < 3; ++d)
      if (std::fabs(std::remainder(f.X[d] - corner[d] - 0.5 * spacing, spacing)) > 0.02 * spacing) return false;
  int other;
  return shared_cell(p, corner, spacing, other) < 0;
}

}  // namespace

std::string place_in_file(const std::string& name, int line) { return "file '" + name + "', line " + std::to_string(line) + ": "; }

PointCloud read_points(const std::string& text, const std::string& name, const GrainPair& pair,
                       const PointFileOptions& o) {
  Reader file(text, name);
  std::vector<std::string> words;
  if (!file.next(words)) stop("file '", name, "' is empty; a line with the names of the columns is needed, and one a point");
  const Columns columns(words, file.place());
  const bool tensor = columns.has(kTensor), principal = columns.has(kPrincipal), area_given = columns.has(kArea);
  const double attach = o.attach > 0.0 ? o.attach : o.spacing;

  PointCloud cloud;
  std::vector<int> line;
  std::vector<double> v(columns.count());
  const auto value = [&](const std::string& n) { return v[columns.of(n)]; };
  const auto vector = [&](const char* a, const char* b, const char* c) { return Vector3(value(a), value(b), value(c)); };
  while (file.next(words)) {
    const std::string place = file.place();
    if (words.size() != columns.count())
      stop(place, words.size(), " numbers, but ", columns.count(), " columns are named");
    for (const auto& c : columns.all()) v[c.second] = number(words[c.second], c.first, place);
    if (columns.has(kGrains)) {
      int grain[2];
      for (int s = 0; s < 2; ++s) grain[s] = grain_of(value(kGrains[s]), kGrains[s], place);
      if (grain[0] == grain[1]) stop(place, "'grain_i' and 'grain_j' are both ", grain[0], "; two different grains are needed");
      if (std::min(grain[0], grain[1]) != o.tag[0] || std::max(grain[0], grain[1]) != o.tag[1]) {
        for (int g : grain) cloud.other_grains.emplace(g, file.line());
        continue;
      }
    }
    FillPoint p;
    p.X = o.to_body(vector("x", "y", "z"));
    p.volume = value("volume");
    if (!(p.volume > 0.0)) stop(place, "volume ", p.volume, " must be greater than 0");
    if (p.volume > kLargestVolume * std::pow(o.spacing, 3))
      stop(place, "volume ", p.volume, " is ", p.volume / std::pow(o.spacing, 3), " times a cell of a lattice of spacing ", o.spacing,
           "; check the units of lengths and volumes and the spacing");
    if (columns.has(kAxis)) {
      p.axis = vector("ax", "ay", "az");
      if (!(p.axis.norm() > 0.0)) stop(place, "axis 0 0 0: a direction is needed, or leave the columns 'ax ay az' out");
      p.axis.normalize();
    }
    if (tensor) {
      for (int i = 0; i < 6; ++i) p.damage[i] = value(kTensor[i]);
    } else if (principal) {
      std::array<double, 9> a;
      for (int i = 0; i < 9; ++i) a[i] = value(kPrincipal[i]);
      const Matrix3 D = principal_damage(a, place);
      const double full[6] = {D(0, 0), D(1, 1), D(2, 2), D(1, 2), D(0, 2), D(0, 1)};
      std::copy(full, full + 6, p.damage);
    }
    const double* D = p.damage;
    if (tensor || principal)
      check_damage((Matrix3() << D[0], D[5], D[4], D[5], D[1], D[3], D[4], D[3], D[2]).finished(), place);
    if (columns.has(kFailed)) p.failed = flag(value("failed"), "failed", place);

    for (int s = 0; s < 2; ++s) {
      const double R = pair.radius(s);
      const Vector3 from = p.X - pair.centre(s);
      const double r = from.norm();
      if (r < R - 0.5 * o.spacing)
        stop(place, "the point lies ", R - r, " inside grain ", o.tag[s], ", more than half the spacing, ", 0.5 * o.spacing,
             "; check the units and the place of the grains");
      FillPoint::Attachment k;
      k.side = s;
      k.foot = pair.centre(s) + R * from.normalized();
      k.attached = !p.failed;
      if (area_given) {
        k.area = value(kArea[s]);
        if (!(k.area >= 0.0)) stop(place, "area ", k.area, " must not be negative");
        if (k.area == 0.0) continue;
        if (k.area > kLargestArea * o.spacing * o.spacing)
          stop(place, "area ", k.area, " at grain ", o.tag[s], " is ", k.area / (o.spacing * o.spacing), " times a face of a lattice of spacing ",
               o.spacing, "; check the units of lengths and areas and the spacing");
        if (columns.has(kFoot)) k.foot = o.to_body(Vector3(value(kFoot[3 * s]), value(kFoot[3 * s + 1]), value(kFoot[3 * s + 2])));
        const double off = (k.foot - pair.centre(s)).norm() - R;
        if (std::fabs(off) > 1e-6 * R) stop(place, "foot point is ", off, " off the surface of grain ", o.tag[s]);
        if ((k.foot - p.X).norm() > kFurthestFoot * o.spacing)
          stop(place, "the point is ", (k.foot - p.X).norm(), " from where it is attached to grain ", o.tag[s], ", more than ", kFurthestFoot,
               " spacings");
        if (columns.has(kAttached)) k.attached = flag(value(kAttached[s]), kAttached[s], place) && !p.failed;
      } else {
        if (r - R > attach) continue;
        // Where the cement is thinner than a layer it is the layer.
        const double z = p.X.dot(pair.n), rho = std::sqrt(std::max(p.X.squaredNorm() - z * z, 0.0));
        const bool between = z > pair.height(0) && z < pair.height(1) && rho < std::min(pair.R1, pair.R2);
        const double layer = between ? std::min(attach, std::max(pair.thickness(rho), 1e-3 * attach)) : attach;
        k.area = p.volume * R * R / (r * r * layer);
      }
      cloud.attached_area[s] += k.area;
      p.link[p.links++] = k;
    }
    cloud.points.push_back(p);
    line.push_back(file.line());
  }
  if (cloud.points.empty()) {
    if (columns.has(kGrains) && file.line() > 1)
      stop("file '", name, "' has no points of grains ", o.tag[0], " and ", o.tag[1], " (columns 'grain_i grain_j')");
    stop("file '", name, "' has no points");
  }
  for (int s = 0; s < 2; ++s)
    if (cloud.attached_area[s] == 0.0)
      stop("file '", name, "': nothing is attached to grain ", o.tag[s], "; no point is within ", attach,
           " of its surface (keyword 'attach', default one spacing); check the units and the place of the grains");

  for (int s = 0; s < 2; ++s) {
    const double sphere = 4.0 * M_PI * pair.radius(s) * pair.radius(s);
    if (cloud.attached_area[s] > kMostOfSphere * sphere)
      stop("file '", name, "': the attached area at grain ", o.tag[s], " is ", cloud.attached_area[s], " in all, more than its surface, ", sphere,
           "; check the units of lengths and areas");
  }

  int other = -1, twice = shared_cell(cloud.points, cloud.corner, o.spacing, other);
  if (twice >= 0 || on_a_face(cloud.points, o.spacing)) {
    cloud.corner = beside_the_points(cloud.points, o.spacing);
    twice = shared_cell(cloud.points, cloud.corner, o.spacing, other);
  }
  if (twice >= 0) {
    const double apart = (cloud.points[twice].X - cloud.points[other].X).norm();
    if (apart < 1e-6 * o.spacing)
      stop(file.place(std::max(line[twice], line[other])), "the point repeats that of line ", std::min(line[twice], line[other]));
    stop(file.place(std::max(line[twice], line[other])), "the point shares a cell of a lattice of spacing ", o.spacing, " with that of line ",
         std::min(line[twice], line[other]), ", ", apart, " away; points must lie on a cubic lattice along the axes of the box: use its spacing");
  }

  for (const FillPoint& p : cloud.points) cloud.largest_volume = std::max(cloud.largest_volume, p.volume);
  std::vector<FillPoint> full;  // cut cells have their centroids off the middle
  for (const FillPoint& p : cloud.points)
    if (p.volume > 0.99 * cloud.largest_volume) full.push_back(p);
  cloud.lattice = beside_the_points(full, o.spacing);
  // one that is within rounding of where shapes have theirs is it
  if (cloud.lattice.cwiseAbs().maxCoeff() < 1e-3 * o.spacing) cloud.lattice.setZero();
  cloud.regular = is_lattice(cloud.points, full, cloud.lattice, o.spacing);
  if (!cloud.regular) cloud.lattice = cloud.corner;

  double low = 1e300, high = -1e300, thickest = 0.0;
  for (const FillPoint& p : cloud.points) {
    const double z = p.X.dot(pair.n), r = std::sqrt(std::max(p.X.squaredNorm() - z * z, 0.0));
    cloud.volume += p.volume;
    low = std::min(low, z);
    high = std::max(high, z);
    thickest = std::max(thickest, pair.thickness(std::min(r, std::min(pair.R1, pair.R2))));
  }
  cloud.thickness = std::min(thickest, high - low + o.spacing);
  return cloud;
}

}  // namespace mpdem
