// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "film.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "../mpm/material_runs.h"
#include "../mpm/point_scatter.h"
#include "../mpm/point_state.h"
#include "../mpm/point_stress.h"
#include "traction_laws.h"

namespace mpdem {

// Sums over columns, one column per lane.
struct Film::Loads {
  vd force[3] = {}, torque[2][3] = {};  // force: on grain 1. torque: of the forces, about the centres
  Mat3<vd> moment = {};                 // -V P

  // weighted: -V P of eight columns.
  void add(const Mat3<vd>& weighted, const Column& c, const vd (*r)[3]) {
    vd f[3];
    for (int i = 0; i < 3; ++i) {
      f[i] = c.inverse_t * (weighted.a[i][0] * c.N[0] + weighted.a[i][1] * c.N[1] + weighted.a[i][2] * c.N[2]);
      force[i] += f[i];
      for (int j = 0; j < 3; ++j) moment.a[i][j] += weighted.a[i][j];
    }
    for (int s = 0; s < 2; ++s)
      for (int d = 0; d < 3; ++d) {
        const int e = (d + 1) % 3, g = (d + 2) % 3;
        const vd t = r[s][e] * f[g] - r[s][g] * f[e];
        torque[s][d] += s == 1 ? t : -t;
      }
  }

  void add_to(BondEnd* bond_ends, const Rotations& turns) const {
    Mat3<double> T;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) T.a[i][j] = sum_lanes(moment.a[i][j]);
    for (int s = 0; s < 2; ++s) {
      const Mat3<double> A = product(turns.Q[s], transpose(T));
      for (int d = 0; d < 3; ++d) {
        const int e = (d + 1) % 3, g = (d + 2) % 3;
        const double f = sum_lanes(force[d]);
        bond_ends[s].force[d] += s == 1 ? f : -f;
        bond_ends[s].torque[d] += sum_lanes(torque[s][d]) + 0.5 * (A.a[e][g] - A.a[g][e]);
      }
    }
  }
};

bool Film::carries_load() const {
  for (std::size_t b = 0; b < columns_.size(); ++b)
    if (carrying(b)) return true;
  return false;
}

Film::Areas Film::areas() const {
  Areas sum;
  for (std::size_t b = 0; b < points.blocks.size(); ++b) {
    const vd area = points.blocks[b].volume * columns_[b].inverse_t;
    sum.intact += sum_lanes(masked(carrying(b), area));
    sum.inside += sum_lanes(masked(points.meta[b].failed, area));
    if (!columns_[b].cut) continue;
    // A debonded face has all of the damage; the other one has less.
    const vmask cut = lanes(static_cast<std::uint8_t>(columns_[b].cut & ~points.meta[b].failed));
    const vd second = select(faces_[b].damage[1] >= 1.0, splat(1.0), vd{}), first = select(faces_[b].damage[0] >= 1.0, splat(1.0), vd{});
    const vd both = max(first + second, splat(1.0));
    sum.at_grain[0] += sum_lanes(select(cut, area * first / both, vd{}));
    sum.at_grain[1] += sum_lanes(select(cut, area * second / both, vd{}));
  }
  return sum;
}

void Film::lay_out(const BondRecord& record, const std::shared_ptr<const Law>& law) {
  if (empty()) return;
  points.set_law(law);
  points.arrange(1e6 * (record.radius[0] + record.radius[1]), Basis::quadratic);  // one cell for all, about the origin
  for (int s = 0; s < 2; ++s) orientation_[s] = rotation_of(record.orientation[s]);
  columns_.assign(points.blocks.size(), Column{});
  for (Column& c : columns_)
    for (auto& of_grain : c.link) std::fill(of_grain, of_grain + kLanes, -1);
  faces_.assign(points.blocks.size(), Faces{});
  points.softening.clear();
  for (std::size_t b = 0; b < points.blocks.size(); ++b)
    points.softening.push_back(splat(law_of_block(points, *law, static_cast<int>(b)).softening_of_layer(1.0)));
  find_scatter(points, record);
  bool opened = false;
  std::vector<std::array<const Link*, 2>> ends(kLanes * points.blocks.size(), {nullptr, nullptr});
  for (const Link& k : points.links) ends[k.slot][k.grain == record.grain[1]] = &k;
  for (std::size_t slot = 0; slot < ends.size(); ++slot) {
    const std::size_t b = slot / kLanes, l = slot % kLanes;
    if (!(points.meta[b].occupied >> l & 1) || !ends[slot][0] || !ends[slot][1]) continue;
    Eigen::Vector3d along;
    for (int d = 0; d < 3; ++d) along[d] = ends[slot][1]->foot[d] - ends[slot][0]->foot[d];
    const double t = along.norm();
    Column& c = columns_[b];
    c.inverse_t[l] = 1.0 / t;
    points.softening[b][l] = law_of_block(points, *law, static_cast<int>(b)).softening_of_layer(t);
    for (int d = 0; d < 3; ++d) {
      c.N[d][l] = along[d] / t;
      for (int s = 0; s < 2; ++s) {
        c.arm[s][d][l] = points.blocks[b].X[d][l] - record.centre[s][d];
        c.normal[s][d][l] = (ends[slot][s]->foot[d] - record.centre[s][d]) / record.radius[s];
        faces_[b].open[s][d][l] = ends[slot][s]->moved[d];
      }
    }
    for (int s = 0; s < 2; ++s) {
      c.area[s][l] = ends[slot][s]->area;
      c.link[s][l] = static_cast<int>(ends[slot][s] - points.links.data());
      faces_[b].damage[s][l] = ends[slot][s]->state[0];
      opened = opened || ends[slot][s]->state[0] > 0.0 || ends[slot][s]->moved[0] != 0.0 || ends[slot][s]->moved[1] != 0.0 ||
               ends[slot][s]->moved[2] != 0.0;
      if (!ends[slot][s]->attached) c.cut |= static_cast<std::uint8_t>(1u << l);
    }
  }
  if (!opened) faces_.clear();
}

Film::Rotations Film::turns(const BondEnd* bond_ends) const {
  Rotations t;
  for (int s = 0; s < 2; ++s) t.Q[s] = product(bond_ends[s].R, transpose(orientation_[s]));
  return t;
}

void Film::deform(std::size_t b, const Rotations& t, const BondEnd* bond_ends, vd (*r)[3], Mat3<vd>& F) const {
  const Column& c = columns_[b];
  vd apart[3];
  for (int i = 0; i < 3; ++i) {
    for (int s = 0; s < 2; ++s) {
      const double* Q = t.Q[s].a[i];
      r[s][i] = Q[0] * c.arm[s][0] + Q[1] * c.arm[s][1] + Q[2] * c.arm[s][2];
      if (!faces_.empty()) r[s][i] += Q[0] * faces_[b].open[s][0] + Q[1] * faces_[b].open[s][1] + Q[2] * faces_[b].open[s][2];
    }
    apart[i] = c.inverse_t * ((bond_ends[1].x[i] - bond_ends[0].x[i]) + (r[1][i] - r[0][i]));
  }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) F.a[i][j] = 0.5 * (t.Q[0].a[i][j] + t.Q[1].a[i][j]) + apart[i] * c.N[j];
}

void Film::advance(BondEnd* ends, const Law& of_any_kind, const TractionLaw* faces, double dt, const AdvanceOptions& given,
                   AdvanceResult& result) {
  failed.clear();
  debonded.clear();
  if (empty()) return;
  AdvanceOptions options(given);
  options.nonlocal = false;  // a column is its own neighbourhood: it softens by its thickness
  const Rotations rotations_now = turns(ends);
  Loads loads;
  if (faces) open_faces(of_any_kind, *faces, rotations_now, ends, result);
  for_each_material(points, of_any_kind, [&](const auto& law, int first, int last) {
    using L = std::decay_t<decltype(law)>;
    PointStress<L> stress_at_end(points, law, dt, options, {}, result);
    PassClock clock(result.ticks);
    const auto load = [&](int b, const Sym3<vd>& stress) {
      vd r[2][3];
      Mat3<vd> unused;
      deform(static_cast<std::size_t>(b), rotations_now, ends, r, unused);
      const PointBlock& p = points.blocks[b];
      loads.add(weighted_piola(p.F, p.q, stress, volume_that_carries(b)), columns_[b], r);
    };
    for (int b = first; b < last; ++b) {
      const BlockMeta& m = points.meta[b];
      if (!carrying(static_cast<std::size_t>(b))) continue;
      PointBlock& p = points.blocks[b];
      vd r[2][3];
      Mat3<vd> F, dF;
      deform(static_cast<std::size_t>(b), rotations_now, ends, r, F);
      if (const std::uint8_t at_rest = m.failed | columns_[b].cut) F = blend(lanes(at_rest), p.F, F);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) dF.a[i][j] = F.a[i][j] - p.F.a[i][j];
      const Sym3<vd> strain_start = p.strain;
      advance_strain(p.F, dF, p.q, p.strain);
      p.F = F;
      Sym3<vd> stress;
      if (stress_at_end(
              b, strain_start, [] { return vd{}; }, stress))
        loads.add(weighted_piola(p.F, p.q, stress, volume_that_carries(b)), columns_[b], r);
      if (stress_at_end.full()) stress_at_end.flush(clock, load);
    }
    stress_at_end.flush(clock, load);
  });
  loads.add_to(ends, rotations_now);
  failed.swap(result.failed);
  result.failed.clear();
  std::sort(failed.begin(), failed.end());
  if (faces && !failed.empty()) result.released += energy_of_faces_at(failed, *faces);
  for (int slot : failed) debond(slot, false);
}

void Film::add_force(BondEnd* ends, const Law& of_any_kind) const {
  if (empty()) return;
  const Rotations rotations_now = turns(ends);
  Loads loads;
  for_each_material(points, of_any_kind, [&](const auto& law, int first, int last) {
    for (int b = first; b < last; ++b) {
      const PointBlock& p = points.blocks[b];
      vd r[2][3];
      Mat3<vd> unused;
      deform(static_cast<std::size_t>(b), rotations_now, ends, r, unused);
      loads.add(weighted_piola(p.F, p.q, stress_of(points, b, law), volume_that_carries(b)), columns_[b], r);
    }
  });
  loads.add_to(ends, rotations_now);
}

// The strain is the logarithm of the stretch, to which the sum over steps converges where the axes of the stretch are
// fixed.
void Film::start_from(const BondEnd* ends) {
  const Rotations rotations_now = turns(ends);
  points.forget_roots_of_norm();
  for (std::size_t b = 0; b < points.blocks.size(); ++b) {
    PointBlock& p = points.blocks[b];
    vd r[2][3];
    deform(static_cast<std::size_t>(b), rotations_now, ends, r, p.F);
    for (int l = 0; l < kLanes; ++l) {
      if (!(points.meta[b].occupied >> l & 1)) continue;
      Eigen::Matrix3d F;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) F(i, j) = p.F.a[i][j][l];
      const Eigen::JacobiSVD<Eigen::Matrix3d> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
      const Eigen::Matrix3d R = svd.matrixU() * svd.matrixV().transpose();
      const Eigen::Quaterniond at_creation(p.q.w[l], p.q.x[l], p.q.y[l], p.q.z[l]), q = (Eigen::Quaterniond(R) * at_creation).normalized();
      const Eigen::Matrix3d frame = at_creation.toRotationMatrix();
      // small is U - 1. From the singular values it would lose its digits. e is the logarithm of U to second order.
      const Eigen::Matrix3d small = R.transpose() * (F - R), stretch = 0.5 * (small + small.transpose());
      const Eigen::Matrix3d e = frame.transpose() * (stretch - 0.5 * stretch * stretch) * frame;
      const double strain[6] = {e(0, 0), e(1, 1), e(2, 2), e(1, 2), e(0, 2), e(0, 1)};
      double* to = reinterpret_cast<double*>(&p.strain) + l;
      for (int i = 0; i < 6; ++i) to[kLanes * i] = strain[i];
      p.q.w[l] = q.w();
      p.q.x[l] = q.x();
      p.q.y[l] = q.y();
      p.q.z[l] = q.z();
    }
  }
}

void Film::set_strain(const Strains& strains, const double* d) {
  points.forget_roots_of_norm();
  for (std::size_t b = 0; b < points.blocks.size(); ++b) {
    Sym3<vd> e{};
    for (int j = 0; j < 6; ++j) e = e + splat(d[j]) * strains[j][b];
    points.blocks[b].strain = e;
  }
}

Film::Strains Film::strains(const BondEnd* ends, const Eigen::Vector3d& middle) const {
  Strains all;
  if (empty()) return all;
  const Rotations rotations_now = turns(ends);
  for (auto& of_motion : all) of_motion.resize(points.blocks.size());
  for (std::size_t b = 0; b < points.blocks.size(); ++b) {
    const PointBlock& p = points.blocks[b];
    const Column& c = columns_[b];
    vd r[2][3], from_middle[3];
    Mat3<vd> unused;
    deform(b, rotations_now, ends, r, unused);
    for (int d = 0; d < 3; ++d) from_middle[d] = r[1][d] + (ends[1].x[d] - middle[d]);
    const Mat3<vd> to_present = inverse(p.F), frame = rotation_matrix(p.q);
    for (int j = 0; j < 6; ++j) {
      double turn[3] = {0, 0, 0};  // turn: rotation of grain 1; way: displacement of x_1; G: change of F
      vd way[3] = {};
      if (j < 3) way[j] = splat(1.0);
      else turn[j - 3] = 1.0;
      Mat3<vd> G = {};
      for (int d = 0; d < 3; ++d) {
        const int e = (d + 1) % 3, g = (d + 2) % 3;
        way[d] += turn[e] * from_middle[g] - turn[g] * from_middle[e];
        for (int k = 0; k < 3; ++k) G.a[d][k] = splat(0.5 * (turn[e] * rotations_now.Q[1].a[g][k] - turn[g] * rotations_now.Q[1].a[e][k]));
      }
      for (int d = 0; d < 3; ++d)
        for (int k = 0; k < 3; ++k) G.a[d][k] += c.inverse_t * way[d] * c.N[k];
      const Mat3<vd> H = product(G, to_present);
      all[j][b] = rotate_back(frame, Sym3<vd>{H.a[0][0], H.a[1][1], H.a[2][2], 0.5 * (H.a[1][2] + H.a[2][1]), 0.5 * (H.a[0][2] + H.a[2][0]),
                                              0.5 * (H.a[0][1] + H.a[1][0])});
    }
  }
  return all;
}

Film::Matrix6 Film::stiffness(const Strains& strains, const Law& of_any_kind) const {
  Matrix6 K = Matrix6::Zero();
  for_each_material(points, of_any_kind, [&](const auto& law, int first, int last) {
    using L = std::decay_t<decltype(law)>;
    for (int b = first; b < last; ++b) {
      const BlockMeta& m = points.meta[b];
      const vd live = stiff_volume(b);
      for (int j = 0; j < 6; ++j) {
        const Sym3<vd> stress = m.damaged ? law.stress(strains[j][b], state_of<L>(points, b)) : law.elasticity().stress(strains[j][b]);
        for (int i = 0; i <= j; ++i) K(i, j) += sum_lanes(live * contract(stress, strains[i][b]));
      }
    }
  });
  K.triangularView<Eigen::StrictlyLower>() = K.transpose();
  return K;
}

void Film::motion(int b, const BondEnd* ends, double later, vd* x, vd* v) const {
  vd r[2][3];
  Mat3<vd> unused;
  deform(static_cast<std::size_t>(b), turns(ends), ends, r, unused);
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, g = (d + 2) % 3;
    x[d] = v[d] = vd{};
    for (int s = 0; s < 2; ++s) {
      const BondEnd& a = ends[s];
      x[d] += 0.5 * (a.x[d] + r[s][d]);
      v[d] += 0.5 * (a.v[d] + later * a.a[d] + (a.omega[e] + later * a.alpha[e]) * r[s][g] - (a.omega[g] + later * a.alpha[g]) * r[s][e]);
    }
  }
}

}  // namespace mpdem
