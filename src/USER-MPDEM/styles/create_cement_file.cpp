// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// create_cement: points from a file.
#include <mpi.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>

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

}  // namespace LAMMPS_NS
