// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// create_cement: points from a file, and the check of new cement against what is there.
#include <mpi.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <unordered_map>

#include "../geometry/frame_along.h"
#include "../geometry/point_file.h"
#include "atom.h"
#include "atom_vec_mpdem.h"
#include "comm.h"
#include "create_cement.h"
#include "domain.h"

namespace LAMMPS_NS {

using mpdem::FillPoint;
using mpdem::text_of;
using mpdem::Vector3;

namespace {

// The text of a file that only the first rank reads. Collective.
std::string broadcast_file(MPI_Comm world, const std::string& name, std::string& trouble) {
  int me;
  MPI_Comm_rank(world, &me);
  std::string text;
  long long size = -1;
  int code = 0;
  if (me == 0) {
    std::FILE* f = std::fopen(name.c_str(), "rb");
    if (f) {
      char buffer[65536];
      for (std::size_t n; (n = std::fread(buffer, 1, sizeof buffer, f)) > 0;) text.append(buffer, n);
      if (!std::ferror(f)) size = static_cast<long long>(text.size());
      else code = errno;
      std::fclose(f);
    } else {
      code = errno;
    }
  }
  MPI_Bcast(&code, 1, MPI_INT, 0, world);
  MPI_Bcast(&size, 1, MPI_LONG_LONG, 0, world);
  if (size < 0) {
    trouble = text_of("file '", name, "' cannot be read: ", std::strerror(code), "; check name and folder");
    return text;
  }
  text.resize(size);
  constexpr long long kMost = 1 << 30;  // MPI counts in int
  for (long long at = 0; at < size; at += kMost)
    MPI_Bcast(&text[at], static_cast<int>(std::min(kMost, size - at)), MPI_CHAR, 0, world);
  return text;
}

}  // namespace

// Fills volume, areas and thickness of the body; `corner` is where its coordinates start, from
// the middle of the gap.
std::vector<FillPoint> CreateCement::read_file(const mpdem::GrainPair& pair, const int* tags, const double* first_centre,
                                               mpdem::Body& body, Vector3& corner, const mpdem::Arguments& args) {
  std::string trouble;
  const std::string text = broadcast_file(world, file_, trouble);
  if (!trouble.empty()) args.complain(trouble);
  mpdem::PointFileOptions o;
  o.tag[0] = tags[0];
  o.tag[1] = tags[1];
  o.spacing = spacing_;
  o.attach = attach_;
  o.to_body = [&](const Vector3& x) {
    double d[3] = {x[0] - first_centre[0], x[1] - first_centre[1], x[2] - first_centre[2]};
    domain->minimum_image(d[0], d[1], d[2]);
    return Vector3(Vector3(d[0], d[1], d[2]) + pair.centre(0));
  };
  mpdem::PointCloud cloud = mpdem::read_points(text, file_, pair, o);
  check_grains_of_file(cloud.other_grains, args);
  for (FillPoint& p : cloud.points) {
    p.X -= cloud.corner;
    for (int k = 0; k < p.links; ++k) p.link[k].foot -= cloud.corner;
  }
  corner = cloud.corner;
  for (int d = 0; d < 3; ++d) body.lattice[d] = cloud.lattice[d] - corner[d];
  body.regular = cloud.regular;
  if (comm->me == 0 && cloud.largest_volume > 1.05 * std::pow(spacing_, 3))
    error->warning("create_cement", 0,
                   text_of("file '", file_, "': points of up to ", cloud.largest_volume, " are larger than a cell of a lattice of spacing ", spacing_,
                           ", ", std::pow(spacing_, 3), "; cracks and crevices are found by such cells: use the spacing of the points")
                       .c_str());
  body.volume = cloud.volume;
  body.thickness = cloud.thickness;
  std::copy(cloud.attached_area, cloud.attached_area + 2, body.attached_area);
  return std::move(cloud.points);
}

// Are they in the scene? line: first that names a grain. Collective.
void CreateCement::check_grains_of_file(const std::map<int, int>& line, const mpdem::Arguments& args) const {
  const AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  std::vector<int> tags, found(line.size(), 0);
  for (const auto& g : line) tags.push_back(g.first);
  for (int i = 0; i < atom->nlocal; ++i) {
    const auto at = std::lower_bound(tags.begin(), tags.end(), atom->tag[i]);
    if (at != tags.end() && *at == atom->tag[i] && !avec->is_point(i)) found[at - tags.begin()] = 1;
  }
  MPI_Allreduce(MPI_IN_PLACE, found.data(), static_cast<int>(found.size()), MPI_INT, MPI_MAX, world);
  std::size_t n = 0;
  for (const auto& g : line)
    if (!found[n++])
      args.complain(text_of(mpdem::place_in_file(file_, g.second), "grain ", g.first, " does not exist; create it before, or leave its lines out"));
}

// Third axis of the frame along the axis of the elasticity, damage in its components.
void CreateCement::set_frame(const FillPoint& p, mpdem::PointRecord& r) const {
  const Eigen::Quaterniond q = mpdem::frame_along(p.axis);
  const double w[4] = {q.w(), q.x(), q.y(), q.z()};
  std::copy(w, w + 4, r.q);
  r.has_frame = true;
  const double* D = p.damage;
  Eigen::Matrix3d m;
  m << D[0], D[5], D[4], D[5], D[1], D[3], D[4], D[3], D[2];
  const Eigen::Matrix3d R = q.toRotationMatrix(), t = R.transpose() * m * R;
  const double turned[6] = {t(0, 0), t(1, 1), t(2, 2), t(1, 2), t(0, 2), t(0, 1)};
  std::copy(turned, turned + 6, r.damage);
}

// New points inside cells that cement of another bond, of the first `bodies`, fills (nearly) whole; empty if there are
// none. Collective.
std::string CreateCement::overlap_of(const std::vector<FillPoint>& fill, const mpdem::Body& body, std::size_t bodies) const {
  AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  if (bodies == 0) return "";
  // New points by cells as wide as the coarsest lattice.
  double width = spacing_;
  for (const mpdem::Body& b : avec->bonds.table) width = std::max(width, b.spacing);
  const auto key = [](long i, long j, long k) { return (i * 73856093L) ^ (j * 19349663L) ^ (k * 83492791L); };
  const auto cell = [width](double x) { return static_cast<long>(std::floor(x / width)); };
  std::unordered_multimap<long, int> near;
  near.reserve(fill.size());
  Vector3 low = Vector3::Constant(1e300), high = -low;
  for (std::size_t n = 0; n < fill.size(); ++n) {
    near.emplace(key(cell(fill[n].X[0]), cell(fill[n].X[1]), cell(fill[n].X[2])), static_cast<int>(n));
    low = low.cwiseMin(fill[n].X);
    high = high.cwiseMax(fill[n].X);
  }
  std::vector<double> inside(avec->bonds.table.size(), 0.0), full;
  for (const mpdem::Body& b : avec->bonds.table) full.push_back(0.95 * std::pow(b.spacing, 3));
  for (int i = 0; i < atom->nlocal; ++i) {
    if (!avec->is_point(i)) continue;
    const int b = avec->slot[i] / mpdem::kLanes, l = avec->slot[i] % mpdem::kLanes;
    const int body_of_point = avec->bond[i];
    if (body_of_point >= static_cast<int>(bodies) || avec->points_of(i).blocks[b].volume[l] < full[body_of_point]) continue;
    const double half = 0.5 * avec->bonds.table[body_of_point].spacing * (1.0 - 1e-6);
    // From the middle of the new cement, so that the nearest periodic image is meant.
    Vector3 middle = 0.5 * (low + high);
    double d[3];
    for (int c = 0; c < 3; ++c) d[c] = atom->x[i][c] - body.origin[c] - middle[c];
    domain->minimum_image(d[0], d[1], d[2]);
    const Vector3 x = middle + Vector3(d[0], d[1], d[2]);
    if (((x - low).array() < -half).any() || ((x - high).array() > half).any()) continue;
    const long at[3] = {cell(x[0]), cell(x[1]), cell(x[2])};
    for (int n = 0; n < 27; ++n) {
      const auto range = near.equal_range(key(at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1));
      for (auto it = range.first; it != range.second; ++it)
        if ((fill[it->second].X - x).cwiseAbs().maxCoeff() < half) inside[body_of_point] += fill[it->second].volume;
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, inside.data(), static_cast<int>(inside.size()), MPI_DOUBLE, MPI_SUM, world);
  for (std::size_t b = 0; b < inside.size(); ++b)
    if (inside[b] > 0.0)
      return text_of("the cement of grains ", body.grain[0], " and ", body.grain[1], " overlaps that of grains ",
                     avec->bonds.table[b].grain[0], " and ", avec->bonds.table[b].grain[1], ", in a volume of ", inside[b], " of ", body.volume);
  return "";
}

// Points inside another grain than the two, or in another image of these. Each rank looks at its own grains,
// all of whose images may come near. Collective.
void CreateCement::check_other_grains(const std::vector<FillPoint>& fill, const mpdem::Body& body) const {
  const AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  Vector3 low = Vector3::Constant(1e300), high = -low;
  for (const FillPoint& p : fill) {
    low = low.cwiseMin(p.X);
    high = high.cwiseMax(p.X);
  }
  const double tolerance = 0.5 * spacing_;
  const int images[3] = {domain->periodicity[0], domain->periodicity[1], domain->periodicity[2]};
  int inside = 0, tag = 0;
  double deepest = 0.0;
  for (int i = 0; i < atom->nlocal; ++i) {
    if (avec->is_point(i)) continue;
    for (int a = -images[0]; a <= images[0]; ++a)
      for (int b = -images[1]; b <= images[1]; ++b)
        for (int c = -images[2]; c <= images[2]; ++c) {
          const int box[3] = {a, b, c};
          Vector3 centre;
          for (int d = 0; d < 3; ++d) centre[d] = atom->x[i][d] + box[d] * domain->prd[d] - body.origin[d];
          const double within = atom->radius[i] - tolerance;
          if (within <= 0.0 || (centre - centre.cwiseMax(low).cwiseMin(high)).norm() >= within) continue;
          bool own = false;
          for (int s = 0; s < 2; ++s)
            own = own || (atom->tag[i] == body.grain[s] &&
                          (centre - Vector3(body.centre[s][0], body.centre[s][1], body.centre[s][2])).norm() < tolerance);
          if (own) continue;
          for (const FillPoint& p : fill) {
            const double depth = atom->radius[i] - (p.X - centre).norm();
            if (depth <= tolerance) continue;
            ++inside;
            if (depth > deepest) tag = atom->tag[i];
            deepest = std::max(deepest, depth);
          }
        }
  }
  std::string trouble;
  if (inside > 0)
    trouble = text_of("create_cement: ", inside, " of ", fill.size(), " points of the cement of grains ", body.grain[0], " and ", body.grain[1],
                      " lie inside grain ", tag, tag == body.grain[0] || tag == body.grain[1] ? ", in another image of the periodic box" : "",
                      ", as deep as ", deepest, " (half a spacing, ", tolerance, ", is allowed); make the shape smaller, a coating by 'cap' or "
                      "'thickness', or move that grain away before");
  mpdem::stop_if_any(lmp, trouble);
}

}  // namespace LAMMPS_NS
