// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "layout.h"

#include <algorithm>
#include <numeric>

#include "../../geometry/frame_along.h"
#include "../../geometry/radial_axis.h"
#include "../../material/tensor_damage.h"
#include "../../mpm/point_scatter.h"
#include "../../mpm/point_state.h"
#include "../../numerics/index_in.h"
#include "../../parallel/agree.h"
#include "../../parallel/ranks.h"
#include "../failure/node_aliases.h"

namespace mpdem {

namespace {

Vector3 axis_at(const Vector3& X, const BondRecord& record, const CementOptions& options) {
  if (options.axis == AxisRule::global) return Vector3(turned_back(axes_of(record), options.axis_direction).data());
  Vector3 centre[2];
  for (int s = 0; s < 2; ++s) centre[s] = Vector3(record.centre[s][0], record.centre[s][1], record.centre[s][2]);
  if (options.axis == AxisRule::bond) return centre[1] - centre[0];
  return radial_axis(X, centre, record.radius, record.spacing);
}

// Sets the frame of each new point. Its third axis is the axis of the stiffness. axis(X): a vector along this axis.
template <class Axis>
void set_frames(PointStore& points, const Law& law, Axis axis) {
  for (std::size_t b = 0; b < points.blocks.size(); ++b) {
    BlockMeta& m = points.meta[b];
    if (m.framed == m.occupied) continue;
    for (int l = 0; l < kLanes; ++l) {
      if (!(m.occupied >> l & 1) || (m.framed >> l & 1)) continue;
      const PointBlock& p = points.blocks[b];
      const Eigen::Quaterniond q = frame_along(axis(Vector3(p.X[0][l], p.X[1][l], p.X[2][l])).normalized());
      Frame& f = points.blocks[b].q;
      f.w[l] = q.w();
      f.x[l] = q.x();
      f.y[l] = q.y();
      f.z[l] = q.z();
      if (m.damaged && law.state_is_tensor()) {  // the initial damage is in the axes of the bond
        const Sym3<vd> D = rotate_back(rotation_matrix(f), state_of<TensorDamage>(points, static_cast<int>(b)));
        const double numbers[6] = {D.xx[l], D.yy[l], D.zz[l], D.yz[l], D.xz[l], D.xy[l]};
        points.set_state(kLanes * static_cast<int>(b) + l, numbers);
      }
      m.framed |= static_cast<std::uint8_t>(1u << l);
    }
  }
}

std::vector<Grid::Cell> cells_of(BondLayout& l, const NodeAliases& aliases) {
  std::vector<Grid::Cell> cells;
  for (BlockMeta& m : l.points.meta)
    if (!aliases.may_alias(m)) cells.push_back({field_of(m.row, m.layer), m.base, m.column, m.joined});
  l.links.add_cells(cells);
  return cells;
}

class LayoutMaker {
 public:
  LayoutMaker(const LayoutRules& rules, const std::vector<int>& rows, std::vector<LayoutRequest>& requests)
      : rules_(rules), rows_(rows), requests_(requests), layouts_(requests.size()) {}

  std::vector<BondLayout> make() {
    const int ranks = ranks_of(rules_.comm);
    for (std::size_t n = 0; n < layouts_.size(); ++n) start(requests_[n], layouts_[n]);
    NodeSplitting& splits = rules_.splits;
    const bool finds_edges = rules_.options.tied && !splits.edges_known(rows_);
    // The masters of a constrained node of this rank may be nodes that only other ranks have. build() adds them here, as
    // nodes without cells. A first grid without motion, the plan, shows which they are.
    if (finds_edges && ranks > 1) {
      std::vector<Grid> plans(layouts_.size());
      build(plans, false);
      keep_edges(plans);
    }
    std::vector<Grid> grids(layouts_.size());
    build(grids, true);
    if (finds_edges && ranks == 1) keep_edges(grids);
    std::vector<std::vector<ExtensionConstraint>> constraints(layouts_.size());
    for (std::size_t n = 0; n < constraints.size(); ++n) constraints[n] = splits.constraints(grids[n].keys);
    const std::vector<char> any = constrained_anywhere(constraints);
    for (std::size_t n = 0; n < layouts_.size(); ++n) {
      BondLayout& l = layouts_[n];
      l.grid = std::move(grids[n]);
      l.grid.constrain(constraints[n], any[n], !rules_.options.split);
      l.grid.given_volume = splits.volumes(l.grid.keys, rules_.options);
      l.grid.lump_mass(l.points, rules_.density);
    }
    if (!rules_.options.split) splits.drop_edges(rows_);
    return std::move(layouts_);
  }

 private:
  void start(LayoutRequest& r, BondLayout& l) {
    const BondRecord& record = rules_.table[r.row];
    const CementOptions& o = rules_.options;
    l.row = r.row;
    l.points = std::move(r.points);
    l.points.set_law(rules_.law);
    if (rules_.arrange) {
      l.new_slot = l.points.arrange(o.cell, o.basis, r.layers.layer_of_slot, rules_.formulation.joins_cells());
      set_frames(l.points, *rules_.law, [&](const Vector3& X) { return axis_at(X, record, o); });
    }
    find_softening(l.points, record, o.cell);
    find_scatter(l.points, record);
    scatter_softening(l.points, record);
    if (rules_.penalty) l.links = PenaltyLinks(l.points, record, *rules_.penalty, o.cell, rules_.density, o.basis);
  }

  // Builds grids with nodes for all cells and masters, with the previous motion or at rest.
  void build(std::vector<Grid>& grids, bool with_motion) {
    const NodeAliases aliases(rules_.options, rules_.penalty);
    std::vector<GridRequest> wanted(grids.size());
    for (std::size_t n = 0; n < grids.size(); ++n) {
      GridRequest& w = wanted[n];
      grids[n].basis = rules_.options.basis;
      w.grid = &grids[n];
      w.cells = cells_of(layouts_[n], aliases);
      w.extra = rules_.splits.nodes_beside(layouts_[n].points, layouts_[n].row, support(rules_.options.basis));
      // Contact of crack faces needs all phantom nodes, see coupling/crack_faces.h. A rank whose last point of the bond
      // has left shares none of its nodes.
      if (rules_.options.split && rules_.penalty && rules_.penalty->friction >= 0.0 && !layouts_[n].points.blocks.empty()) {
        const std::vector<Key> copies = rules_.splits.copies_of(layouts_[n].row);
        w.extra.insert(w.extra.end(), copies.begin(), copies.end());
      }
      if (!with_motion) continue;
      w.before = std::move(requests_[n].before);
      w.source = std::move(requests_[n].layers.source);
    }
    const int margin = with_motion ? rules_.formulation.margin() : 0;
    try {
      build_grids(rules_.comm, rules_.options.cell, margin, rules_.options.most_bytes, wanted);
    } catch (const GridTooLarge& e) {
      throw BadState(text_of("the grid would take more than ", e.bytes, " bytes on a rank, half of the memory for one is ",
                             rules_.options.most_bytes, "; use a larger 'cell', more machines",
                             margin > 0 ? ", or 'kinematics total', since points that are scattered take hundreds of nodes each" : ""));
    }
    for (std::size_t n = 0; n < grids.size(); ++n) aliases.find(layouts_[n].points, grids[n], rules_.splits);
    for (std::size_t n = 0; n < grids.size() && with_motion; ++n) {
      layouts_[n].fresh.swap(wanted[n].fresh);
      aliases.copy_motion_of_representatives(grids[n], rules_.splits, layouts_[n].fresh);
    }
  }

  // Collective. Finds and stores the constraints that edge nodes have at the start.
  void keep_edges(std::vector<Grid>& grids) const {
    const NodeSplitting& splits = rules_.splits;
    std::vector<std::pair<Key, double>> all;
    for (std::size_t n = 0; n < grids.size(); ++n) {
      const std::vector<double> mass = grids[n].local_mass(layouts_[n].points, rules_.density);
      for (int i = 0; i < grids[n].size(); ++i) all.emplace_back(splits.at_start(grids[n].keys[i]), mass[i]);
    }
    std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    EdgeNodes nodes;
    for (const auto& a : all) {
      if (nodes.keys.empty() || nodes.keys.back() != a.first) {
        nodes.keys.push_back(a.first);
        nodes.mass.push_back(0.0);
      }
      nodes.mass.back() += a.second;
    }
    HaloSum halo;
    halo.build(rules_.comm, nodes.keys);
    halo.sum(nodes.mass.data(), 1);
    nodes.next = [&splits](const Key& k, int direction) { return splits.next(k, direction); };
    std::vector<ExtensionConstraint> edges = find_extension_constraints(rules_.comm, rules_.options.basis, nodes);
    for (ExtensionConstraint& t : edges)
      if (rules_.options.split) std::vector<std::pair<Key, double>>().swap(t.behind);  // only for the chain, which is not made then
    rules_.splits.keep_edges(rows_, std::move(edges));
  }

  // Returns for each layout whether some rank has constrained nodes in it.
  std::vector<char> constrained_anywhere(const std::vector<std::vector<ExtensionConstraint>>& constraints) const {
    std::vector<char> of_rows(rows_.size(), 0), any;
    const auto at = [&](std::size_t n) { return index_in(rows_, layouts_[n].row, "bond"); };
    for (std::size_t n = 0; n < layouts_.size(); ++n) of_rows[at(n)] = !constraints[n].empty();
    MPI_Allreduce(MPI_IN_PLACE, of_rows.data(), static_cast<int>(of_rows.size()), MPI_SIGNED_CHAR, MPI_MAX, rules_.comm);
    for (std::size_t n = 0; n < layouts_.size(); ++n) any.push_back(of_rows[at(n)]);
    return any;
  }

  const LayoutRules& rules_;
  const std::vector<int>& rows_;
  std::vector<LayoutRequest>& requests_;
  std::vector<BondLayout> layouts_;
};

}  // namespace

// Columns of a film are along the line of centres. With `axis radial` their axis is along it too: the normals of the two
// grains at the ends of a column lie on either side of this line.
void lay_out_film(Film& film, const BondRecord& record, const CementOptions& options, const std::shared_ptr<const Law>& law) {
  film.lay_out(record, law);
  CementOptions of_film(options);
  if (options.axis == AxisRule::radial) of_film.axis = AxisRule::bond;
  set_frames(film.points, *law, [&](const Vector3& X) { return axis_at(X, record, of_film); });
}

std::vector<BondLayout> make_layout(const LayoutRules& rules, const std::vector<int>& rows, std::vector<LayoutRequest> requests) {
  return LayoutMaker(rules, rows, requests).make();
}

}  // namespace mpdem
