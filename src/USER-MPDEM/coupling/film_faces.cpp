// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The faces of a film: the interfaces of its columns with the grains.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "../mpm/material_runs.h"
#include "../mpm/point_scatter.h"
#include "../mpm/point_state.h"
#include "../mpm/point_stress.h"
#include "film.h"
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

// The force of a column on its face at grain 1 with the present damage, in the axes of the creation. Each grain gives a
// rotation to these axes. They differ by the order of the strain, so the mean of both results is taken.
template <class L>
void Film::force_of_column(const L& law, std::size_t b, const Rotations& turns, const Mat3<vd>& F, const Frame& q, const Sym3<vd>& strain,
                           vd* f) const {
  const BlockMeta& m = points.meta[b];
  const Column& c = columns_[b];
  vd g[3];
  const Sym3<vd> stress = m.damaged ? law.stress(strain, state_of<L>(points, static_cast<int>(b))) : law.elasticity().stress(strain);
  const Mat3<vd> weighted = weighted_piola(F, q, stress, stiff_volume(static_cast<int>(b)));
  for (int i = 0; i < 3; ++i) g[i] = c.inverse_t * (weighted.a[i][0] * c.N[0] + weighted.a[i][1] * c.N[1] + weighted.a[i][2] * c.N[2]);
  for (int i = 0; i < 3; ++i) {
    const auto back = [&](int s) { return turns.Q[s].a[0][i] * g[0] + turns.Q[s].a[1][i] * g[1] + turns.Q[s].a[2][i] * g[2]; };
    f[i] = 0.5 * (back(0) + back(1));
  }
}

// The same at the present positions of the grains, with the present openings of the faces. Returns the deformation gradient.
template <class L>
Mat3<vd> Film::force_on_face(const L& law, std::size_t b, const Rotations& turns, const BondEnd* bond_ends, vd* f) const {
  const PointBlock& p = points.blocks[b];
  vd r[2][3];
  Mat3<vd> F, dF;
  deform(b, turns, bond_ends, r, F);
  F = blend(lanes(carrying(b)), F, p.F);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) dF.a[i][j] = F.a[i][j] - p.F.a[i][j];
  Frame q = p.q;
  Sym3<vd> strain = p.strain;
  advance_strain(p.F, dF, q, strain);
  force_of_column(law, b, turns, F, q, strain, f);
  return F;
}

// The grain (0 or 1) that is behind, as grain_behind() of mpm/bond_record.h defines it for the whole bond.
int Film::grain_behind_of(const Column& c, std::uint8_t live) {
  BondRecord along;
  const int l = __builtin_ctz(live);
  for (int d = 0; d < 3; ++d) along.centre[1][d] = c.N[d][l];
  return grain_behind(along);
}

// Finds the openings of the faces of block b in balance with its columns, and the damage of the faces. f: force of the columns
// on the faces at grain 1 with the openings as they are. The column is approximated by a spring along N and one across,
// which the next step corrects.
template <class L, class T>
Film::Softening Film::balance_faces(std::size_t b, const L& law, const T& traction, vd* f) {
  constexpr int kIterations = 6;
  constexpr double kClosed = 1e-10;    // largest difference of the forces of column and faces at the end, over the force
  constexpr double kSoftening = 1e-3;  // tangent of a face that softens, over its secant: negligible beside the column
  const std::uint8_t live = carrying(b);
  const Column& c = columns_[b];
  Faces& faces = faces_[b];
  const vd per_length = select(lanes(live), stiff_volume(static_cast<int>(b)) * c.inverse_t * c.inverse_t, splat(1.0)),
           floor = 1e-12 * law.elasticity().C44 * per_length;  // per_length: A/t; floor: keeps compliances finite
  const Mat3<vd> soft = along_and_across(1.0 / (law.elasticity().C33 * per_length), 1.0 / (law.elasticity().C44 * per_length), c.N);
  Softening result;
  const int behind = grain_behind_of(c, live);
  vmask softens[2] = {}, goes_on = lanes(live);
  for (int k = 0; k < kIterations; ++k) {
    vd rest[2][3], step[2][3], grows_by[3], square{}, square_of_force = splat(1e-300);
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
    for (int i = 0; i < 3; ++i) {
      square += rest[0][i] * rest[0][i] + rest[1][i] * rest[1][i];
      square_of_force += f[i] * f[i];
    }
    // A lane ends by itself, so that its result does not depend on the others. A face that debonded keeps the opening at which it did.
    goes_on = goes_on & ~lanes(result.gone) & (softens[0] | softens[1] | (square > kClosed * kClosed * square_of_force));
    if (!any(goes_on)) break;
    solve_in_series(soft, of_face, rest, step, grows_by);
    for (int i = 0; i < 3; ++i) {
      f[i] -= select(goes_on, grows_by[i], vd{});
      for (int s = 0; s < 2; ++s) faces.open[s][i] += select(goes_on, step[s][i], vd{});
    }
    // Of two faces in series only the more damaged one softens, and the other closes. Of equal ones that of grain `behind` does.
    typename T::State state[2] = {{faces.damage[0]}, {faces.damage[1]}};
    TractionUpdate u[2];
    for (int s = 0; s < 2; ++s) u[s] = traction.update(separation(faces.open[s], c.normal[s]), state[s]);
    const vmask second_first = (faces.damage[1] > faces.damage[0]) | ((faces.damage[1] == faces.damage[0]) & splat_mask(behind == 1));
    const vmask grows[2] = {u[0].grown & ~(second_first & u[1].grown) & goes_on, u[1].grown & ~(~second_first & u[0].grown) & goes_on};
    for (int s = 0; s < 2; ++s) {
      softens[s] = grows[s];
      faces.damage[s] = select(grows[s], state[s].d, faces.damage[s]);
      result.spent += select(grows[s], c.area[s] * u[s].dissipated, vd{});
      result.grown = result.grown | grows[s];
      result.gone |= static_cast<std::uint8_t>(bits(u[s].debond & grows[s]));
    }
  }
  return result;
}

// What the columns of block b give up as their faces soften and these do not take: in a jump, and where a face debonds. Call it
// before the columns advance. F_unopened: with the openings at the start.
template <class L, class T>
vd Film::released_by_faces(std::size_t b, const L& law, const T& traction, const Rotations& turns, const BondEnd* ends,
                           const Faces& at_start, const Mat3<vd>& F_unopened, const Softening& now) const {
  const PointBlock& p = points.blocks[b];
  const Column& c = columns_[b];
  vd before[3], after[3], work{};
  force_of_column(law, b, turns, p.F, p.q, p.strain, before);
  force_on_face(law, b, turns, ends, after);
  for (int s = 0; s < 2; ++s)
    for (int i = 0; i < 3; ++i) work += (s == 1 ? 0.5 : -0.5) * (before[i] + after[i]) * (faces_[b].open[s][i] - at_start.open[s][i]);
  const vd energy_at_start = energy_of(traction, c, at_start),
           left_over = work - (energy_of(traction, c, faces_[b]) - energy_at_start) - now.spent;
  const Sym3<vd> stress = stress_of(points, static_cast<int>(b), law);
  const Mat3<vd> weighted = weighted_piola(p.F, p.q, stress, p.volume);
  vd all = energy_at_start + 0.5 * p.volume * contract(stress, p.strain);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) all -= 0.5 * weighted.a[i][j] * (F_unopened.a[i][j] - p.F.a[i][j]);
  return select(now.grown, select(lanes(now.gone), all - now.spent, left_over), vd{});
}

template <class L, class T>
void Film::open_faces(std::size_t b, const L& law, const T& traction, const Rotations& turns, const BondEnd* ends, AdvanceResult& result) {
  if constexpr (T::kFields > 0) {
    static_assert(T::kFields == 1, "a face keeps its damage");
    vd f[3];
    const Mat3<vd> F_unopened = force_on_face(law, b, turns, ends, f);
    const Faces at_start = faces_[b];
    const Softening now = balance_faces(b, law, traction, f);
    write_faces(static_cast<int>(b));
    if (!any(now.grown)) return;
    result.dissipated += sum_lanes(now.spent);
    result.released += sum_lanes(released_by_faces(b, law, traction, turns, ends, at_start, F_unopened, now));
    for (int l = 0; l < kLanes; ++l)
      if (now.gone >> l & 1) debond(kLanes * static_cast<int>(b) + l, true);
  }
}

void Film::open_faces(const Law& of_any_kind, const TractionLaw& faces, const Rotations& turns, const BondEnd* ends,
                      AdvanceResult& result) {
  if (faces.fields() == 0) return;
  if (faces_.empty()) faces_.assign(points.blocks.size(), Faces{});
  for_each_material(points, of_any_kind, [&](const auto& law, int first, int last) {
    with_traction(faces.of_material(points.meta[first].material), [&](const auto& traction) {
      for (int b = first; b < last; ++b)
        if (carrying(static_cast<std::size_t>(b))) open_faces(static_cast<std::size_t>(b), law, traction, turns, ends, result);
    });
  });
}

// Energy of the faces of these columns.
template <class T>
vd Film::energy_of(const T& traction, const Column& c, const Faces& faces) {
  vd sum{};
  if constexpr (T::kFields > 0)
    for (int s = 0; s < 2; ++s)
      sum += c.area[s] * traction.energy(separation(faces.open[s], c.normal[s]), typename T::State{faces.damage[s]});
  return sum;
}

double Film::energy_of_faces(const TractionLaw* of_any_kind) const {
  double sum = 0.0;
  if (!of_any_kind || faces_.empty()) return sum;
  with_traction(*of_any_kind, [&](const auto& traction) {
    for (std::size_t b = 0; b < faces_.size(); ++b)
      sum += sum_lanes(masked(carrying(b), energy_of(traction.same_kind(points.meta[b].material), columns_[b], faces_[b])));
  });
  return sum;
}

double Film::energy_of_faces_at(const std::vector<int>& slots, const TractionLaw& of_any_kind) const {
  double sum = 0.0;
  if (faces_.empty()) return sum;
  with_traction(of_any_kind, [&](const auto& traction) {
    for (int slot : slots) {
      const std::size_t b = static_cast<std::size_t>(slot / kLanes);
      sum += energy_of(traction.same_kind(points.meta[b].material), columns_[b], faces_[b])[slot % kLanes];
    }
  });
  return sum;
}

// Restart files and other ranks get the state of the faces with the links.
void Film::write_faces(int b) {
  for (int l = 0; l < kLanes; ++l)
    for (int s = 0; s < 2; ++s) {
      if (columns_[b].link[s][l] < 0) continue;
      Link& k = points.links[static_cast<std::size_t>(columns_[b].link[s][l])];
      for (int d = 0; d < 3; ++d) k.moved[d] = faces_[b].open[s][d][l];
      k.state[0] = faces_[b].damage[s][l];
    }
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

}  // namespace mpdem
