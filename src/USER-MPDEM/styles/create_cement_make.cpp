// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// create_cement: points of the planned bonds, part by part.
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <unordered_map>

#include "../parallel/all_to_all.h"
#include "../parallel/memory_limit.h"
#include "atom.h"
#include "atom_vec_mpdem.h"
#include "comm.h"
#include "create_cement.h"
#include "domain.h"
#include "fix.h"
#include "force.h"
#include "modify.h"
#include "pair.h"

namespace LAMMPS_NS {

using mpdem::Arguments;
using mpdem::Body;
using mpdem::FillPoint;
using mpdem::text_of;
using mpdem::Vector3;

namespace {
// Points of fills that a part makes, and that are kept for later parts: some 25 MB of them.
constexpr double kPointsOfAPart = 100000.0;
constexpr int kListed = 20;  // bonds told of one by one
// Checks of a bond, in their order.
enum Check { cells, overlap, other_grains, numbers, box };

long long whole(double count) { return std::llround(count); }
}  // namespace

// Bonds of the same points. What is compared is compared to the bit.
void CreateCement::group_fills() {
  std::unordered_map<std::string, int> known;
  for (std::size_t n = 0; n < bonds_.size(); ++n) {
    std::string key(reinterpret_cast<const char*>(&bonds_[n].kind), sizeof(int));
    if (!near_.empty())
      for (const Near& other : near_[n]) {
        key.append(reinterpret_cast<const char*>(&bonds_[other.bond].kind), sizeof(int));
        key.append(reinterpret_cast<const char*>(other.apart.data()), 3 * sizeof(double));
      }
    const auto found = known.emplace(std::move(key), static_cast<int>(fills_.size()));
    if (found.second) {
      fills_.emplace_back();
      fills_.back().first = n;
      fills_.back().sent.assign(comm->nprocs, 0);
    }
    bonds_[n].fill = found.first->second;
  }
}

// Points of a file are read bond by bond.
std::size_t CreateCement::end_of_part(std::size_t from) const {
  if (!file_.empty()) return from + 1;
  std::vector<char> counted(fills_.size(), 0);
  double points = 0.0;
  std::size_t to = from;
  for (; to < bonds_.size(); ++to) {
    const int fill = bonds_[to].fill;
    if (!counted[fill]) points += kinds_[bonds_[to].kind].volume / std::pow(spacing_, 3);
    counted[fill] = 1;
    if (points > kPointsOfAPart && to > from) break;
  }
  return to;
}

CreateCement::Sums CreateCement::make(const Arguments& args, std::vector<Pair>& skipped) {
  const std::size_t first_body = AtomVecMpdem::of(lmp)->bonds.table.size();
  int largest = 0;
  for (int i = 0; i < atom->nlocal; ++i) largest = std::max(largest, atom->tag[i]);
  MPI_Allreduce(&largest, &last_tag_, 1, MPI_INT, MPI_MAX, world);
  const int before = atom->nlocal, first_tag = last_tag_ + 1;
  group_fills();
  gather_grains();
  Sums sums;
  for (std::size_t from = 0; from < bonds_.size();) {
    Part part;
    part.from = from;
    part.to = from = end_of_part(from);
    sums = make_part(part, first_body, args, skipped, sums);
  }
  if (created_ > 0.0) finish(before, first_tag);
  return sums;
}

// Bodies from `first_body` on are of this command.
CreateCement::Sums CreateCement::make_part(Part& part, std::size_t first_body, const Arguments& args, std::vector<Pair>& skipped, Sums sums) {
  AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  Trouble trouble;
  make_fills(part, trouble, args);
  for (std::size_t n = part.from; n < part.to; ++n) part.bodies.push_back(body_of(bonds_[n]));
  part.kept.assign(part.bodies.size(), 1);
  const bool shared_out = overlap_ == "trim";
  const int bodies = static_cast<int>(shared_out ? first_body : avec->bonds.table.size() + part.bodies.size());
  resolve(part, overlaps(part, bodies), trouble, skipped);
  check_other_grains(part, trouble);
  check_numbers(part, trouble);
  stop_at(trouble);
  create_points(part, args);
  report(part);
  for (std::size_t n = 0; n < part.bodies.size(); ++n) {
    if (!part.kept[n]) continue;
    const Body& b = part.bodies[n];
    avec->bonds.table.push_back(b);
    sums.points += b.points;
    sums.volume += b.volume;
    sums.mass += b.volume * density_;
  }
  if (live_ > kPointsOfAPart || !file_.empty())
    for (Fill& f : fills_) {
      f.known = false;
      std::vector<FillPoint>().swap(f.points);
      std::fill(f.sent.begin(), f.sent.end(), 0);
      live_ = 0.0;
    }
  return sums;
}

// How many more points the memory holds: ranks list them while they are made, and keep their own. more: that are planned already.
double CreateCement::most_points(double memory, double more) const {
  constexpr double kListed = 500.0, kKept = 700.0;  // bytes, measured
  const double kept = kKept / comm->nprocs;
  return std::max(1.0, (memory - kept * (static_cast<double>(atom->natoms) + created_ + more)) / (kListed + kept));
}

void CreateCement::fill_one(int fill, double most, Trouble& trouble, const Arguments& args) {
  Fill& f = fills_[fill];
  const Bond& bond = bonds_[f.first];
  Body& body = f.body;
  body = Body();
  try {
    if (file_.empty()) {
      const Kind& kind = kinds_[bond.kind];
      std::vector<mpdem::Neighbour> neighbours;
      if (!near_.empty())
        for (const Near& other : near_[f.first]) neighbours.push_back({&shape_of(bonds_[other.bond].kind), other.apart});
      f.points = mpdem::fill_with_points(shape_of(bond.kind), spacing_, most, neighbours);
      f.corner = Vector3(grid_[0], grid_[1], grid_[2]);
      for (FillPoint& p : f.points) {
        p.X -= f.corner;
        for (int k = 0; k < p.links; ++k) p.link[k].foot -= f.corner;
      }
      for (int c = 0; c < 3; ++c) body.lattice[c] = -f.corner[c];
      std::copy(kind.area, kind.area + 2, body.attached_area);
      body.volume = kind.volume;
      if (!neighbours.empty()) measure(f.points, body);
      body.thickness = kind.thickness;
    } else {
      f.points = read_file(bond.pair, bond.tags, bond.grain[0].x, body, f.corner, named(bond, args));
    }
  } catch (const mpdem::ShapeError& e) {
    f.points.clear();
    trouble.tell(f.first, cells, prefix(bond) + e.what());
  }
  body.spacing = spacing_;
  body.points = static_cast<double>(f.points.size());
  f.box.setEmpty();
  for (const FillPoint& p : f.points) f.box.extend(p.X);
}

// Points of the bonds of a part on the ranks that need them. Collective.
void CreateCement::make_fills(const Part& part, Trouble& trouble, const Arguments& args) {
  const double memory = mpdem::memory_limit(world);
  double planned = 0.0;
  std::vector<int> used, fresh;
  std::vector<double> most;
  std::vector<char> seen(fills_.size(), 0);
  for (std::size_t n = part.from; n < part.to; ++n) {
    const int fill = bonds_[n].fill;
    const double expected = kinds_[bonds_[n].kind].volume / std::pow(spacing_, 3), room = most_points(memory, planned);
    if (!seen[fill]) {
      used.push_back(fill);
      if (!fills_[fill].known) {
        fresh.push_back(fill);
        most.push_back(room);
      }
    } else if (!(expected < room)) {
      try {
        mpdem::fill_with_points(shape_of(bonds_[n].kind), spacing_, room);
      } catch (const mpdem::ShapeError& e) {
        trouble.tell(n, cells, prefix(bonds_[n]) + e.what());
      }
    }
    seen[fill] = 1;
    planned += expected;
  }
  // One alone every rank makes for itself: none has another to make meanwhile.
  const bool each = comm->nprocs == 1 || fresh.size() == 1;
  for (std::size_t k = 0; k < fresh.size(); ++k)
    if (each || fresh[k] % comm->nprocs == comm->me) fill_one(fresh[k], most[k], trouble, args);
  if (!each) share_numbers(fresh);
  for (const int f : fresh) {
    fills_[f].known = true;
    live_ += fills_[f].body.points;
    if (each) std::fill(fills_[f].sent.begin(), fills_[f].sent.end(), 1);
    else fills_[f].sent[f % comm->nprocs] = 1;
  }
  if (comm->nprocs > 1) send_fills(part, used);
}

// What all ranks know of a fill. Numbers come from the rank that made it, the others add zero.
void CreateCement::share_numbers(const std::vector<int>& fills) {
  constexpr int kNumbers = 11;
  std::vector<double> all(kNumbers * fills.size(), 0.0);
  for (std::size_t k = 0; k < fills.size(); ++k) {
    const Fill& f = fills_[fills[k]];
    if (fills[k] % comm->nprocs != comm->me) continue;
    double* v = &all[kNumbers * k];
    v[0] = f.body.points;
    v[1] = f.body.volume;
    std::copy(f.body.attached_area, f.body.attached_area + 2, v + 2);
    v[4] = f.body.thickness;
    if (f.points.empty()) continue;
    for (int d = 0; d < 3; ++d) {
      v[5 + d] = f.box.min()[d];
      v[8 + d] = f.box.max()[d];
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM, world);
  for (std::size_t k = 0; k < fills.size(); ++k) {
    if (fills[k] % comm->nprocs == comm->me) continue;
    const double* v = &all[kNumbers * k];
    Fill& f = fills_[fills[k]];
    f.body = Body();
    f.body.points = v[0];
    f.body.volume = v[1];
    std::copy(v + 2, v + 4, f.body.attached_area);
    f.body.thickness = v[4];
    f.body.spacing = spacing_;
    f.corner = Vector3(grid_[0], grid_[1], grid_[2]);
    for (int c = 0; c < 3; ++c) f.body.lattice[c] = -f.corner[c];
    f.box = v[0] > 0.0 ? mpdem::Box(Vector3(v[5], v[6], v[7]), Vector3(v[8], v[9], v[10])) : mpdem::Box();
  }
}

// Of each fill: the ranks in whose sub-domains, or near them, some bond of the part has it.
std::vector<std::vector<char>> CreateCement::needed(const Part& part, const std::vector<int>& fills) const {
  const double mine[6] = {domain->sublo[0], domain->sublo[1], domain->sublo[2], domain->subhi[0], domain->subhi[1], domain->subhi[2]};
  std::vector<double> all(6 * comm->nprocs);
  MPI_Allgather(mine, 6, MPI_DOUBLE, all.data(), 6, MPI_DOUBLE, world);
  std::vector<mpdem::Box> domains;
  const Vector3 margin = Vector3::Constant(1.001 * reach_of_cells());
  for (int r = 0; r < comm->nprocs; ++r) {
    const double* v = &all[6 * r];
    domains.emplace_back(Vector3(v[0], v[1], v[2]) - margin, Vector3(v[3], v[4], v[5]) + margin);
  }
  const mpdem::BoxSearch search(domains);
  std::vector<std::vector<char>> need(fills_.size());
  for (const int f : fills) need[f].assign(comm->nprocs, 0);
  const std::vector<Vector3> shifts = images();
  for (std::size_t n = part.from; n < part.to; ++n) {
    const Fill& f = fills_[bonds_[n].fill];
    if (f.box.isEmpty()) continue;
    const Body body = body_of(bonds_[n]);
    const Vector3 origin(body.origin[0], body.origin[1], body.origin[2]);
    for (const Vector3& shift : shifts)
      search.meeting(mpdem::Box(f.box).translate(origin + shift), [&](int r) { need[bonds_[n].fill][r] = 1; });
  }
  return need;
}

// From the ranks that made them to those that need them and do not have them yet: both know which these are.
void CreateCement::send_fills(const Part& part, const std::vector<int>& fills) {
  const std::vector<std::vector<char>> need = needed(part, fills);
  std::vector<std::vector<FillPoint>> out(comm->nprocs);
  std::vector<std::vector<int>> from(comm->nprocs);
  for (const int n : fills) {
    Fill& f = fills_[n];
    const int maker = n % comm->nprocs;
    for (int r = 0; r < comm->nprocs; ++r) {
      if (!need[n][r] || f.sent[r]) continue;
      f.sent[r] = 1;
      if (maker == comm->me) out[r].insert(out[r].end(), f.points.begin(), f.points.end());
      if (r == comm->me) from[maker].push_back(n);
    }
  }
  const mpdem::Received<FillPoint> in = mpdem::all_to_all(world, out);
  auto next = in.data.begin();
  for (int r = 0; r < comm->nprocs; ++r)
    for (const int n : from[r]) {
      const auto end = next + static_cast<std::ptrdiff_t>(fills_[n].body.points);
      fills_[n].points.assign(next, end);
      next = end;
    }
}

// Of a bond whose fill is known.
Body CreateCement::body_of(const Bond& bond) const {
  const Fill& f = fills_[bond.fill];
  Body body = f.body;
  const Grain &g0 = bond.grain[0], &g1 = bond.grain[1];
  for (int s = 0; s < 2; ++s) {
    const Grain& g = bond.grain[s];
    body.grain[s] = bond.tags[s];
    body.radius[s] = g.radius;
    std::copy(g.q, g.q + 4, body.orientation[s]);
    const Vector3 centre = bond.pair.centre(s) - f.corner;
    for (int c = 0; c < 3; ++c) body.centre[s][c] = centre[c];
  }
  for (int c = 0; c < 3; ++c) {
    body.origin[c] = g0.x[c] - body.centre[0][c];
    body.shift[0][c] = g0.x[c] - g0.unwrapped[c];
    // A multiple of the box; taken from integers, not from a difference of coordinates.
    const double boxes = std::round((g0.x[c] + bond.between[c] - g1.unwrapped[c]) / domain->prd[c]);
    body.shift[1][c] = domain->periodicity[c] ? boxes * domain->prd[c] : 0.0;
    const double first_boxes = std::round(body.shift[0][c] / domain->prd[c]);
    body.shift[0][c] = domain->periodicity[c] ? first_boxes * domain->prd[c] : 0.0;
    body.box[c] = domain->periodicity[c] ? domain->prd[c] : 0.0;
  }
  return body;
}

// Volume and attached areas as the points have them, for bodies that neighbours have cut.
void CreateCement::measure(const std::vector<FillPoint>& fill, Body& body) {
  body.volume = body.attached_area[0] = body.attached_area[1] = 0.0;
  for (const FillPoint& p : fill) {
    body.volume += p.volume;
    for (int k = 0; k < p.links; ++k) body.attached_area[p.link[k].side] += p.link[k].area;
  }
}

// Numbers of bonds and of IDs, and points outside the box.
void CreateCement::check_numbers(const Part& part, Trouble& trouble) const {
  std::size_t bodies = AtomVecMpdem::of(lmp)->bonds.table.size();
  double last = last_tag_;
  for (std::size_t k = 0; k < part.bodies.size(); ++k) {
    if (!part.kept[k]) continue;
    const std::size_t n = part.from + k;
    const Body& body = part.bodies[k];
    const Fill& f = fills_[bonds_[n].fill];
    if (bodies++ == mpdem::kMaxBodies) trouble.tell(n, numbers, prefix(bonds_[n]) + text_of("there are ", mpdem::kMaxBodies, " bonds, which is the most"));
    last += body.points;
    if (last > 2147483647.0)
      trouble.tell(n, numbers, prefix(bonds_[n]) + text_of(whole(body.points), " points exceed the number of atom IDs; use a larger spacing"));
    bool crosses = false;
    for (int c = 0; c < 3; ++c)
      crosses = crosses || (!domain->periodicity[c] && !(body.origin[c] + f.box.min()[c] >= domain->boxlo[c] && body.origin[c] + f.box.max()[c] < domain->boxhi[c]));
    if (!crosses || f.points.empty()) continue;
    int outside = 0;
    for (const FillPoint& p : f.points) {
      bool in = true;
      for (int c = 0; c < 3; ++c) {
        const double x = body.origin[c] + p.X[c];
        in = in && (domain->periodicity[c] || (x >= domain->boxlo[c] && x < domain->boxhi[c]));
      }
      outside += !in;
    }
    if (outside > 0)
      trouble.tell(n, box, prefix(bonds_[n]) + text_of(outside, " of ", f.points.size(), " points lie outside the simulation box; use a larger box or move the grains"));
  }
}

// Each rank those in its sub-domain, in the order of the bonds and of their lattices.
void CreateCement::create_points(const Part& part, const Arguments& args) {
  AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  // The list of neighbours has the history of contacts, by places of ghosts that the points will take: grains in
  // contact across ranks or a periodic boundary would forget how far they have slid. It is kept by IDs instead.
  if (created_ == 0.0 && force->pair && force->pair->list)
    for (int m = 0; m < modify->nfix; ++m)
      if (std::string(modify->fix[m]->style) == "contacthistory") modify->fix[m]->setup_pre_exchange();

  int body_index = static_cast<int>(avec->bonds.table.size());
  const mpdem::Box mine(Vector3(domain->sublo[0], domain->sublo[1], domain->sublo[2]), Vector3(domain->subhi[0], domain->subhi[1], domain->subhi[2]));
  double x[3], at_most = 0.0;
  tagint image;
  for (std::size_t k = 0; k < part.bodies.size(); ++k) {
    const Fill& f = fills_[bonds_[part.from + k].fill];
    if (!part.kept[k]) continue;
    const Body& body = part.bodies[k];
    if (mine.contains(mpdem::Box(f.box).translate(Vector3(body.origin[0], body.origin[1], body.origin[2])))) at_most += f.points.size();
    else
      for (const FillPoint& p : f.points) at_most += place(body, p, x, image);
  }
  if (atom->nlocal + at_most > atom->nmax)
    avec->grow(static_cast<int>(std::min(2147483646.0, std::max(atom->nlocal + at_most, part.to < bonds_.size() ? 1.5 * atom->nmax : 0.0))));

  bigint local = 0, created, expected = 0;
  for (std::size_t k = 0; k < part.bodies.size(); ++k) {
    if (!part.kept[k]) continue;
    const Body& body = part.bodies[k];
    const Fill& f = fills_[bonds_[part.from + k].fill];
    for (std::size_t n = 0; n < f.points.size(); ++n) {
      if (!place(body, f.points[n], x, image)) continue;
      add_point(f.points[n], body, body_index, last_tag_ + 1 + static_cast<int>(n), x, image);
      ++local;
    }
    ++body_index;
    expected += static_cast<bigint>(body.points);
    last_tag_ += static_cast<int>(body.points);
  }
  MPI_Allreduce(&local, &created, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (created != expected)
    args.complain(text_of(expected - created, " of ", expected, " points lie outside the simulation box; use a larger box or move the grains"));
  created_ += static_cast<double>(created);
}

// What LIGGGHTS has to know of all points that were made, local atoms from `before` on, of IDs from first_tag on. Collective.
void CreateCement::finish(int before, int first_tag) {
  atom->natoms += static_cast<bigint>(created_);
  AtomVecMpdem::of(lmp)->waiting.add(lmp, before, first_tag);
  for (int m = 0; m < modify->nfix; ++m) {
    Fix* fix = modify->fix[m];
    if (!fix->create_attribute) continue;
    fix->pre_set_arrays();
    for (int i = before; i < atom->nlocal; ++i) fix->set_arrays(i);
  }
  if (atom->map_style) {
    atom->nghost = 0;
    atom->map_init();
    atom->map_set();
  }
}

// The first bonds are told of one by one.
void CreateCement::report(const Part& part) {
  if (comm->me != 0) return;
  for (std::size_t k = 0; k < part.bodies.size(); ++k) {
    if (!part.kept[k]) continue;
    const Bond& bond = bonds_[part.from + k];
    const Body& body = part.bodies[k];
    const Kind& kind = kinds_[bond.kind];
    const bool thin = file_.empty() && kind.thinnest < 2.0 * spacing_ * (1.0 - 1e-9);
    if (thin && listed_ >= kListed) {
      ++thin_;
      thinnest_ = std::min(thinnest_, kind.thinnest);
    }
    ++listed_;
    if (listed_ > kListed) continue;
    std::string what = file_.empty() ? shape_of(bond.kind).describe() : "file '" + file_ + "'";
    if (file_.empty() && body.volume < kind.volume) what += text_of(", trimmed from a volume of ", kind.volume);
    const std::string text =
        text_of("Cement between grains ", bond.tags[0], " and ", bond.tags[1], ": ", what, "\n  volume ", body.volume,
                ", content (mass over mass of the grains) ", body.volume * density_ / (bond.grain[0].mass + bond.grain[1].mass), ", attached area ",
                body.attached_area[0], " + ", body.attached_area[1], ", ", whole(body.points), " points\n");
    for (FILE* f : {screen, logfile})
      if (f) std::fprintf(f, "%s", text.c_str());
    if (thin)
      error->warning("create_cement", 0,
                     text_of("pair ", bond.tags[0], " ", bond.tags[1], ": the cement is ", kind.thinnest, " thin at its inner rim, less than two spacings: "
                             "the film there is too soft and will not break; use 'inner auto' or a larger 'inner'").c_str());
  }
  if (part.to < bonds_.size() || listed_ <= kListed) return;
  const std::string text = text_of("  ... and ", listed_ - kListed, " more bonds\n");
  for (FILE* f : {screen, logfile})
    if (f) std::fprintf(f, "%s", text.c_str());
  if (thin_ > 0)
    error->warning("create_cement", 0,
                   text_of(thin_, " of these bonds are less than two spacings thin at their inner rim, the thinnest ", thinnest_,
                           ": the film there is too soft and will not break; use 'inner auto' or a larger 'inner'").c_str());
}

}  // namespace LAMMPS_NS
