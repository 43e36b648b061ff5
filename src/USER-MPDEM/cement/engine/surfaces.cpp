// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Contact of cement with other bodies: its surfaces and its stiffness.
#include <algorithm>

#include "../../parallel/gather_ranks.h"
#include "../condensed/fragments.h"
#include "cement.h"

namespace mpdem {

namespace {

struct PointOfRow {
  int row;
  PointOfCement point;
};

// Grain (0 or 1) with which a point moves.
int side_of_point(const BondRecord& record, const double* X, int connected) {
  if (connected == 1 || connected == 2) return connected - 1;
  const int nearer = nearer_grain(record, nearer_to_first(record, X));
  return record.has_grain(nearer) ? nearer : 1 - nearer;
}

double thickness_at(const BondRecord& record, const double* X) { return above_grain(record, 0, X) + above_grain(record, 1, X); }

// side_of: side of a slot, see PointOfCement; Fragments::kNone: it has no contact.
template <class SideOf>
void add_points(const PointStore& store, const BondRecord& record, int row, bool film, SideOf side_of, std::vector<PointOfRow>& points) {
  for (std::size_t b = 0; b < store.blocks.size(); ++b)
    for (int l = 0; l < kLanes; ++l) {
      if (!(store.meta[b].occupied >> l & 1)) continue;
      const int slot = static_cast<int>(b) * kLanes + l;
      PointOfRow p{row, {}};
      for (int d = 0; d < 3; ++d) p.point.X[d] = store.created_at(static_cast<int>(b))[d][l];
      p.point.volume = store.blocks[b].volume[l];
      p.point.side = side_of(p.point.X, slot);
      if (p.point.side == Fragments::kNone) continue;
      p.point.thickness = film ? thickness_at(record, p.point.X) : 0.0;
      p.point.tag = store.tag(slot);
      points.push_back(p);
    }
}

}  // namespace

bool Cement::has_contact() const { return scene_.touches() && !scene_.bonds().table.empty(); }

// A surface yields like a column of cement as long as the smallest grain with cement is thick; the ratio of the
// stiffnesses is that of two elastic spheres (R. D. Mindlin, J. Appl. Mech. 16, 1949, 259-268).
ContactOfPieces Cement::contact_parameters() const {
  ContactOfPieces c;
  double radius = std::numeric_limits<double>::infinity(), spacing = 0.0;
  for (const BondRecord& b : scene_.bonds().table) {
    radius = std::min({radius, b.radius[0], b.radius[1]});
    spacing = std::max(spacing, b.spacing);
  }
  const VtiElasticity& e = scene_.law->elasticity();
  const double nu = std::max(e.constants.nu_p, 0.0);
  c.kn = e.C33 / radius;
  c.kt = c.kn * 2.0 * (1.0 - nu) / (2.0 - nu);
  c.friction = scene_.friction();
  c.search_margin = spacing;
  return c;
}

std::vector<std::vector<CementPiece>> Cement::surfaces(const std::vector<int>& rows) {
  std::vector<PointOfRow> points;
  std::vector<int> with_fragments;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(with_fragments), [&](int row) { return scene_.fragments.has(row); });
  Fragments fragments;
  if (!with_fragments.empty()) fragments = find_fragments(scene_.comm, scene_.bonds(), with_fragments);
  for (int row : rows) {
    const BondRecord& record = scene_.bonds().table[row];
    const Bond* b = scene_.bonds().find(row);
    if (!b) continue;
    const auto side_on_grid = [&](const double* X, int slot) {
      return scene_.fragments.has(row) ? fragments.side_of(*b, slot)
                                       : side_of_point(record, X, is_apart(row) ? b->points.connected(slot) : 0);
    };
    add_points(b->points, record, row, false, side_on_grid, points);
    add_points(
        b->film.points, record, row, true, [&](const double* X, int) { return side_of_point(record, X, 0); }, points);
  }
  points = gather_all(scene_.comm, points);
  std::sort(points.begin(), points.end(),
            [](const PointOfRow& a, const PointOfRow& b) { return a.row != b.row ? a.row < b.row : a.point.tag < b.point.tag; });
  std::vector<std::vector<CementPiece>> found;
  auto next = points.begin();
  std::vector<PointOfCement> of_row;
  for (int row : rows) {
    const BondRecord& record = scene_.bonds().table[row];
    of_row.clear();
    for (; next != points.end() && next->row == row; ++next) of_row.push_back(next->point);
    if (record.point_template > 0)
      for (const TemplatePoint& t : scene_.bonds().template_of(row).points) {
        PointOfCement p;
        std::copy(t.X, t.X + 3, p.X);
        p.volume = t.volume;
        p.side = side_of_point(record, p.X, 0);
        p.thickness = t.film ? thickness_at(record, p.X) : 0.0;
        of_row.push_back(p);
      }
    found.push_back(of_row.empty() ? std::vector<CementPiece>() : pieces_of(record, row, of_row, is_apart(row), fragments.nodes[row]));
  }
  return found;
}

double Cement::changes_of_surfaces() const {
  double sum = condensed_.changes_of_surfaces() + scene_.fragments.changes();
  for (int row : scene_.fragments.rows()) sum += seen_of_fragments(row);
  return sum;
}

void Cement::take_surfaces(const std::vector<int>& rows) {
  contact_.replace(rows, surfaces(rows));
  name_fragments();
}

// In the order of their tags.
void Cement::name_fragments() {
  std::vector<FragmentBodies::NodesOf> fragments;
  for (const CementPiece& p : contact_.pieces())
    if (p.is_loose()) fragments.push_back({p.row, p.nodes});
  scene_.fragments.set(fragments);
}

const std::vector<BodyOfNodes>& Cement::motions_of_fragments(bool moved) {
  return scene_.fragments.find_motions(scene_.comm, scene_.bonds(), moved ? FragmentBodies::Drift() : scene_.drift());
}

void Cement::load_fragments(std::vector<double> forces) {
  if (ranks_of(scene_.comm) > 1)
    MPI_Allreduce(MPI_IN_PLACE, forces.data(), static_cast<int>(forces.size()), MPI_DOUBLE, MPI_SUM, scene_.comm);
  scene_.fragments.set_forces(forces, scene_.bonds());
}

}  // namespace mpdem
