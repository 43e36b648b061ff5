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

namespace {

LinkSeparation separation(const vd* open, const vd* normal) {
  return {open[0] * normal[0] + open[1] * normal[1] + open[2] * normal[2], open[0] * open[0] + open[1] * open[1] + open[2] * open[2]};
}

// Stiffness k along the unit vector n and kt across it, or such a compliance.
Mat3<vd> along_and_across(vd k, vd kt, const vd* n) {
  Mat3<vd> m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m.a[i][j] = (k - kt) * n[i] * n[j] + (i == j ? kt : vd{});
  return m;
}

void multiply(const Mat3<vd>& m, const vd* x, vd* y) {
  for (int i = 0; i < 3; ++i) y[i] = m.a[i][0] * x[0] + m.a[i][1] * x[1] + m.a[i][2] * x[2];
}

// Displacements e of the two ends of a spring under the loads r. soft: compliance of the spring; of_end: compliances of
// the springs that support its ends. grows: by how much the force of the spring grows.
void solve_in_series(const Mat3<vd>& soft, const Mat3<vd>* of_end, const vd (*r)[3], vd (*e)[3], vd* grows) {
  Mat3<vd> all = soft;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) all.a[i][j] += of_end[0].a[i][j] + of_end[1].a[i][j];
  vd apart[2][3], load[3];
  for (int s = 0; s < 2; ++s) multiply(of_end[s], r[s], apart[s]);
  for (int i = 0; i < 3; ++i) apart[1][i] -= apart[0][i];
  multiply(inverse(all), apart[1], grows);
  for (int s = 0; s < 2; ++s) {
    for (int i = 0; i < 3; ++i) load[i] = r[s][i] + (s == 1 ? -grows[i] : grows[i]);
    multiply(of_end[s], load, e[s]);
  }
}

}  // namespace

// Sums over columns, one column a lane.
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
  second_grain_ = record.grain[1];
  for (int s = 0; s < 2; ++s) orientation_[s] = rotation_of(record.orientation[s]);
  columns_.assign(points.blocks.size(), Column{});
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

// Both links debond, whatever the cause. With a debonded face the column also loses its strain.
void Film::debond(int slot, bool by_face) {
  columns_[slot / kLanes].cut |= static_cast<std::uint8_t>(1u << slot % kLanes);
  const auto [first, last] = of_slot(points.links, slot);
  for (auto k = first; k != last; ++k) {
    if (by_face && k->state[0] >= 1.0 && k->attached) debonded.push_back(static_cast<int>(k - points.links.begin()));
    k->attached = false;
  }
  if (!by_face) return;
  double* strain = reinterpret_cast<double*>(&points.blocks[slot / kLanes].strain) + slot % kLanes;
  for (int i = 0; i < 6; ++i) strain[kLanes * i] = 0.0;
}

// The force of a column on its face at grain 1 with the present damage and the present openings of the faces, in the
// axes of the creation. Each grain gives a rotation to these axes. They differ by the order of the strain, so the mean
// of both results is taken.
template <class L>
void Film::force_on_face(const L& law, std::size_t b, const Rotations& turns, const BondEnd* bond_ends, vd* f) const {
  const PointBlock& p = points.blocks[b];
  const BlockMeta& m = points.meta[b];
  const Column& c = columns_[b];
  vd r[2][3], g[3];
  Mat3<vd> F, dF;
  deform(b, turns, bond_ends, r, F);
  F = blend(lanes(carrying(b)), F, p.F);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) dF.a[i][j] = F.a[i][j] - p.F.a[i][j];
  Frame q = p.q;
  Sym3<vd> strain = p.strain;
  advance_strain(p.F, dF, q, strain);
  const Sym3<vd> stress = m.damaged ? law.stress(strain, state_of<L>(points, static_cast<int>(b))) : law.elasticity().stress(strain);
  const Mat3<vd> weighted = weighted_piola(F, q, stress, stiff_volume(static_cast<int>(b)));
  for (int i = 0; i < 3; ++i) g[i] = c.inverse_t * (weighted.a[i][0] * c.N[0] + weighted.a[i][1] * c.N[1] + weighted.a[i][2] * c.N[2]);
  for (int i = 0; i < 3; ++i) {
    const auto back = [&](int s) { return turns.Q[s].a[0][i] * g[0] + turns.Q[s].a[1][i] * g[1] + turns.Q[s].a[2][i] * g[2]; };
    f[i] = 0.5 * (back(0) + back(1));
  }
}

// The grain (0 or 1) that is behind, as grain_behind() of mpm/bond_record.h defines it for the whole bond.
int Film::grain_behind_of(const Column& c, std::uint8_t live) {
  BondRecord along;
  const int l = __builtin_ctz(live);
  for (int d = 0; d < 3; ++d) along.centre[1][d] = c.N[d][l];
  return grain_behind(along);
}

// The column is approximated by a spring along N and one across, which the next step corrects.
template <class L, class T>
void Film::open_faces(int first, int last, const L& law, const T& traction, const Rotations& turns, const BondEnd* ends,
                      AdvanceResult& result) {
  if constexpr (T::kFields > 0) {
    static_assert(T::kFields == 1, "a face keeps its damage");
    constexpr int kIterations = 6;
    constexpr double kSoftening = 1e-3;  // tangent of a face that softens, over its secant: negligible beside the column
    if (faces_.empty()) faces_.assign(points.blocks.size(), Faces{});
    for (std::size_t b = static_cast<std::size_t>(first); b < static_cast<std::size_t>(last); ++b) {
      const std::uint8_t live = carrying(b);
      if (!live) continue;
      const PointBlock& p = points.blocks[b];
      const Column& c = columns_[b];
      Faces& faces = faces_[b];
      const vd per_length = select(lanes(live), stiff_volume(static_cast<int>(b)) * c.inverse_t * c.inverse_t, splat(1.0)),
               floor = 1e-12 * law.elasticity().C44 * per_length;  // per_length: A/t; floor: keeps compliances finite
      const Mat3<vd> soft = along_and_across(1.0 / (law.elasticity().C33 * per_length), 1.0 / (law.elasticity().C44 * per_length), c.N);
      vd f[3];
      force_on_face(law, b, turns, ends, f);
      const int behind = grain_behind_of(c, live);
      std::uint8_t gone = 0;
      vmask softens[2] = {};
      for (int k = 0; k < kIterations; ++k) {
        vd rest[2][3], step[2][3], grows_by[3];
        Mat3<vd> of_face[2];
        for (int s = 0; s < 2; ++s) {
          const LinkSeparation delta = separation(faces.open[s], c.normal[s]);
          const TractionSecant secant = traction.secant(delta, typename T::State{faces.damage[s]});
          const vd kn = c.area[s] * secant.kn, kt = c.area[s] * secant.kt;
          for (int i = 0; i < 3; ++i) rest[s][i] = (s == 1 ? f[i] : -f[i]) - (kt * faces.open[s][i] + (kn - kt) * delta.n * c.normal[s][i]);
          of_face[s] = along_and_across(1.0 / (kn + floor), 1.0 / (kt + floor), c.normal[s]);
          // A face that softens is compliant only along its opening, and not where it is closed.
          const vd closed = min(delta.n, vd{}), energy = kt * delta.tangential_square() + kn * (delta.n - closed) * (delta.n - closed);
          const vd softening_compliance = select(softens[s] & (energy > 0.0), splat(1.0 / kSoftening) / max(energy, splat(1e-300)), vd{});
          vd open[3];
          for (int i = 0; i < 3; ++i) open[i] = faces.open[s][i] - closed * c.normal[s][i];
          for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) of_face[s].a[i][j] += softening_compliance * open[i] * open[j];
        }
        solve_in_series(soft, of_face, rest, step, grows_by);
        for (int i = 0; i < 3; ++i) {
          f[i] -= masked(static_cast<std::uint8_t>(live & ~gone), grows_by[i]);  // a face that debonded keeps the opening at which it did
          for (int s = 0; s < 2; ++s) faces.open[s][i] += masked(static_cast<std::uint8_t>(live & ~gone), step[s][i]);
        }
        // Of two faces in series only the more damaged one softens, and the other closes. Of equal ones that of grain `behind` does.
        typename T::State state[2] = {{faces.damage[0]}, {faces.damage[1]}};
        TractionUpdate u[2];
        for (int s = 0; s < 2; ++s) u[s] = traction.update(separation(faces.open[s], c.normal[s]), state[s]);
        const vmask second_first = (faces.damage[1] > faces.damage[0]) | ((faces.damage[1] == faces.damage[0]) & splat_mask(behind == 1));
        const vmask grows[2] = {u[0].grown & ~(second_first & u[1].grown) & lanes(live),
                                u[1].grown & ~(~second_first & u[0].grown) & lanes(live)};
        for (int s = 0; s < 2; ++s) {
          softens[s] = grows[s];
          faces.damage[s] = select(grows[s], state[s].d, faces.damage[s]);
          result.dissipated += sum_lanes(select(grows[s], c.area[s] * u[s].dissipated, vd{}));
          gone |= static_cast<std::uint8_t>(bits(u[s].debond & grows[s]));
        }
      }
      write_faces(static_cast<int>(b));
      if (!gone) continue;
      // The column releases its energy, and so does the other face.
      result.released += sum_lanes(
          masked(gone, energy_of_faces(traction, b) + 0.5 * p.volume * contract(stress_of(points, static_cast<int>(b), law), p.strain)));
      for (int l = 0; l < kLanes; ++l)
        if (gone >> l & 1) debond(kLanes * static_cast<int>(b) + l, true);
    }
  }
}

template <class T>
vd Film::energy_of_faces(const T& traction, std::size_t b) const {
  vd sum{};
  if constexpr (T::kFields > 0)
    for (int s = 0; s < 2; ++s)
      sum += columns_[b].area[s] *
             traction.energy(separation(faces_[b].open[s], columns_[b].normal[s]), typename T::State{faces_[b].damage[s]});
  return sum;
}

double Film::energy_of_faces(const TractionLaw* of_any_kind) const {
  double sum = 0.0;
  if (!of_any_kind || faces_.empty()) return sum;
  with_traction(*of_any_kind, [&](const auto& traction) {
    for (std::size_t b = 0; b < faces_.size(); ++b)
      sum += sum_lanes(masked(carrying(b), energy_of_faces(traction.same_kind(points.meta[b].material), b)));
  });
  return sum;
}

// Restart files and other ranks get the state of the faces with the links.
void Film::write_faces(int b) {
  for (int l = 0; l < kLanes; ++l) {
    if (!(points.meta[b].occupied >> l & 1)) continue;
    const auto [first, last] = of_slot(points.links, kLanes * b + l);
    for (auto k = first; k != last; ++k) {
      const int s = k->grain == second_grain_;
      for (int d = 0; d < 3; ++d) k->moved[d] = faces_[b].open[s][d][l];
      k->state[0] = faces_[b].damage[s][l];
    }
  }
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
  for_each_material(points, of_any_kind, [&](const auto& law, int first, int last) {
    using L = std::decay_t<decltype(law)>;
    if (faces)
      with_traction(faces->of_material(points.meta[first].material),
                    [&](const auto& traction) { open_faces(first, last, law, traction, rotations_now, ends, result); });
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
  if (faces && !faces_.empty() && !failed.empty())
    with_traction(*faces, [&](const auto& traction) {
      for (int slot : failed) {
        const std::size_t b = static_cast<std::size_t>(slot / kLanes);
        result.released += energy_of_faces(traction.same_kind(points.meta[b].material), b)[slot % kLanes];
      }
    });
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

Film::FaceResponse Film::put_faces_in_series(Strains& strains, const BondEnd* ends, const Eigen::Vector3d& middle, const Law& of_any_kind,
                                             const TractionLaw& faces) const {
  using Matrix3 = Eigen::Matrix3d;
  using Vector3 = Eigen::Vector3d;
  FaceResponse response;
  if (empty()) return response;
  for (auto& of_motion : response.open) of_motion.assign(points.blocks.size(), {});
  for (std::size_t b = 0; b < points.blocks.size(); ++b) {
    const PointBlock& p = points.blocks[b];
    const Column& c = columns_[b];
    const VtiElasticity& elasticity = law_of_block(points, of_any_kind, static_cast<int>(b)).elasticity();
    const TractionStiffness& of_faces = faces.of_material(points.meta[b].material).stiffness();
    const double kn = of_faces.kn, kt = of_faces.kt;
    const vd stiff = stiff_volume(static_cast<int>(b));
    for (int l = 0; l < kLanes; ++l) {
      if (!(carrying(b) >> l & 1)) continue;
      const auto at = [l](const vd* v) { return Vector3(v[0][l], v[1][l], v[2][l]); };
      const Eigen::Quaterniond q(p.q.w[l], p.q.x[l], p.q.y[l], p.q.z[l]);
      const Matrix3 frame = q.toRotationMatrix();
      const Vector3 N = at(c.N);
      const double inverse_t = c.inverse_t[l], volume = stiff[l];
      // Strain in the frame of the point due to the end at grain 1 moving by w, and the force that this takes.
      const auto strain_of = [&](const Vector3& w) {
        const Matrix3 G = inverse_t * w * N.transpose();
        return Matrix3(frame.transpose() * (0.5 * (G + G.transpose())) * frame);
      };
      const auto force_of = [&](const Matrix3& e) {
        const auto in_lanes = [](double x) { return splat(x); };
        const Sym3<vd> s = elasticity.stress(
            Sym3<vd>{in_lanes(e(0, 0)), in_lanes(e(1, 1)), in_lanes(e(2, 2)), in_lanes(e(1, 2)), in_lanes(e(0, 2)), in_lanes(e(0, 1))});
        Matrix3 stress;
        stress << s.xx[0], s.xy[0], s.xz[0], s.xy[0], s.yy[0], s.yz[0], s.xz[0], s.yz[0], s.zz[0];
        return Vector3(volume * inverse_t * (frame * stress * frame.transpose() * N));
      };
      Matrix3 A, compliance[2];
      for (int d = 0; d < 3; ++d) A.col(d) = force_of(strain_of(Vector3::Unit(d)));
      for (int s = 0; s < 2; ++s) {
        const Vector3 n = at(c.normal[s]);
        compliance[s] = (Matrix3::Identity() / kt + (1.0 / kn - 1.0 / kt) * n * n.transpose()) / c.area[s][l];
      }
      const Matrix3 both = compliance[0] + compliance[1];
      const Matrix3 kept = (Matrix3::Identity() + both * A).inverse();  // of w, by the column
      Vector3 forces[6];
      for (int j = 0; j < 6; ++j) {
        Vector3 turn = Vector3::Zero(), w = Vector3::Zero();
        if (j < 3) w[j] = 1.0;
        else turn[j - 3] = 1.0;
        const Vector3 from_middle = at(c.arm[1]) + Vector3(ends[1].x[0], ends[1].x[1], ends[1].x[2]) - middle;
        w += turn.cross(from_middle);
        const Vector3 stretch = kept * w;
        forces[j] = A * stretch;
        const Matrix3 less = strain_of(w - stretch);
        const double change[6] = {less(0, 0), less(1, 1), less(2, 2), less(1, 2), less(0, 2), less(0, 1)};
        double* to = reinterpret_cast<double*>(&strains[j][b]) + l;
        for (int i = 0; i < 6; ++i) to[kLanes * i] -= change[i];
        const Vector3 open[2] = {compliance[0] * forces[j], -compliance[1] * forces[j]};
        for (int s = 0; s < 2; ++s)
          for (int d = 0; d < 3; ++d) response.open[j][b][static_cast<std::size_t>(3 * s + d)][l] = open[s][d];
        for (int i = 0; i <= j; ++i) response.stiffness(i, j) += forces[i].dot(both * forces[j]);
      }
    }
  }
  response.stiffness.triangularView<Eigen::StrictlyLower>() = response.stiffness.transpose();
  return response;
}

void Film::set_open(const FaceResponse& response, const double* d) {
  if (response.empty()) return;
  faces_.assign(points.blocks.size(), Faces{});
  for (std::size_t b = 0; b < faces_.size(); ++b) {
    for (int s = 0; s < 2; ++s)
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 6; ++j) faces_[b].open[s][i] += splat(d[j]) * response.open[j][b][static_cast<std::size_t>(3 * s + i)];
    write_faces(static_cast<int>(b));
  }
}

void Film::close_faces() {
  for (Link& k : points.links)
    if (k.attached) std::fill(k.moved, k.moved + 3, 0.0);
  for (Faces& f : faces_)
    for (int s = 0; s < 2; ++s)
      for (int i = 0; i < 3; ++i) f.open[s][i] = vd{};
}

double Film::largest_onset_share(const FaceResponse& response, const TractionLaw& of_any_kind, const double* d) const {
  double most = 0.0;
  if (response.empty()) return most;
  with_traction(of_any_kind, [&](const auto& of_first) {
    if constexpr (std::decay_t<decltype(of_first)>::kFields > 0)
      for (std::size_t b = 0; b < columns_.size(); ++b)
        for (int s = 0; s < 2; ++s) {
          const auto& traction = of_first.same_kind(points.meta[b].material);
          vd open[3] = {};
          for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 6; ++j) open[i] += splat(d[j]) * response.open[j][b][static_cast<std::size_t>(3 * s + i)];
          most = std::max(most, largest_lane(masked(carrying(b), traction.onset_share(separation(open, columns_[b].normal[s])))));
        }
  });
  return most;
}

void Film::largest_onset_shares(const FaceResponse& response, const TractionLaw& faces, double* of_motion) const {
  for (int j = 0; j < 6; ++j) {
    double d[6] = {};
    of_motion[j] = 0.0;
    for (double sign : {-1.0, 1.0}) {
      d[j] = sign;
      of_motion[j] = std::max(of_motion[j], largest_onset_share(response, faces, d));
    }
  }
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
