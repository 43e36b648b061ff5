// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "write_cement.h"

#include <mpi.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <map>
#include <vector>

#include "../../mpm/point_row.h"
#include "../../mpm/point_state.h"
#include "../../parallel/gather_ranks.h"
#include "../words/arguments.h"
#include "atom.h"
#include "../atoms/atom_vec_mpdem.h"
#include "comm.h"
#include "domain.h"
#include "../fixes/files_in_use.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::Arguments;
using mpdem::text_of;

namespace {

using Vector3 = Eigen::Vector3d;

struct GrainNow {
  int tag;
  double x[3], q[4];
};
struct PointNow {
  int tag;
  double x[3];
  mpdem::PointRecord record;
};

Eigen::Quaterniond quaternion(const double* q) { return {q[0], q[1], q[2], q[3]}; }

// Writes the line of column names, or the numbers of a row.
class TextLine : public mpdem::record_detail::Visitor<TextLine> {
 public:
  TextLine(std::FILE* file, bool of_names) : file_(file), of_names_(of_names) {}
  template <class T>
  void put(const char* name, const T& number, mpdem::Range) {
    if (!first_) std::fputc(' ', file_);
    first_ = false;
    if (of_names_) std::fputs(name, file_);
    else if constexpr (mpdem::record_detail::kWhole<T>) std::fprintf(file_, "%d", static_cast<int>(number));
    else std::fprintf(file_, "%.17g", number);
  }

 private:
  std::FILE* file_;
  bool of_names_, first_ = true;
};

void write_line(std::FILE* file, const mpdem::PointRow& row, bool of_names) {
  TextLine line(file, of_names);
  mpdem::PointRow::describe(row, line);
  std::fputc('\n', file);
}

// Returns the row of a point in its present state. Foot points rotate with their grains.
mpdem::PointRow row_of(const PointNow& p, const mpdem::BondRecord& record, const std::map<int, GrainNow>& grains,
                       const mpdem::PointRow& names) {
  const mpdem::PointRecord& r = p.record;
  mpdem::PointRow row;
  std::copy(record.grain, record.grain + 2, row.grain);
  std::copy(p.x, p.x + 3, row.x);
  row.volume = r.volume;
  const bool has_axis = row.has_axis = names.has_axis;
  row.has_link_damage = names.has_link_damage;
  row.has_material = names.has_material;
  row.material = r.material;
  row.failed = r.failed;
  const double* D = r.damage;
  Eigen::Matrix3d m;
  m << D[0], D[5], D[4], D[5], D[1], D[3], D[4], D[3], D[2];
  // A point without an axis has its damage in the axes of the bond.
  const Eigen::Quaterniond axes = has_axis ? quaternion(record.axes) * quaternion(r.q) : quaternion(record.axes);
  const Eigen::Matrix3d R = axes.toRotationMatrix();
  m = R * m * R.transpose();
  for (int d = 0; has_axis && d < 3; ++d) row.axis[d] = R(d, 2);
  const double turned[6] = {m(0, 0), m(1, 1), m(2, 2), m(1, 2), m(0, 2), m(0, 1)};
  std::copy(turned, turned + 6, row.damage);
  for (int s = 0; s < 2; ++s) {
    const mpdem::Link* link = nullptr;
    for (int k = 0; k < r.links; ++k)
      if (r.link[k].grain == record.grain[s]) link = &r.link[k];
    if (!link) continue;
    const GrainNow& g = grains.at(record.grain[s]);
    const Vector3 from =
        Vector3(link->foot[0], link->foot[1], link->foot[2]) - Vector3(record.centre[s][0], record.centre[s][1], record.centre[s][2]);
    const Vector3 foot = Vector3(g.x[0], g.x[1], g.x[2]) + quaternion(g.q) * (quaternion(record.orientation[s]).conjugate() * from);
    row.side[s].area = link->area;
    std::copy(foot.data(), foot.data() + 3, row.side[s].foot);
    row.side[s].attached = link->attached;
    row.side[s].damage = link->state[0];
  }
  return row;
}

}  // namespace

// Grains and points of the chosen bonds in the order of their IDs. Only the first rank has them, see gather().
struct WriteCement::Now {
  std::map<int, GrainNow> grains;
  std::vector<PointNow> points;
  bool axes = false;         // do all points have an axis?
  bool link_damage = false;  // does any link have damage, or any point residue?
};

void WriteCement::command(int narg, char** arg) {
  Arguments args(lmp, "write_cement", narg, arg, 0);
  AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  if (!domain->box_exist) args.complain("the simulation box does not exist yet; use create_box or read_restart before");
  if (!avec) args.complain(text_of("atom style '", atom->atom_style, "' has no cement; use 'atom_style mpdem'"));
  const std::string name = args.word("a file name");
  std::array<int, 2> wanted = {0, 0};
  while (!args.empty()) {
    if (!args.accept("pair")) args.unknown(args.word(""), {"pair"});
    args.once("pair");
    wanted = args.pair();
    std::sort(wanted.begin(), wanted.end());
  }
  std::vector<char> chosen;
  std::size_t made = 0;
  for (const mpdem::BondRecord& b : avec->bonds.table) {
    chosen.push_back(b.points > 0 && (wanted[0] == 0 || (b.grain[0] == wanted[0] && b.grain[1] == wanted[1])));
    if (chosen.back() && (b.left[0] || b.left[1]))
      args.complain(text_of("the cement of grains ", b.grain[0], " and ", b.grain[1], " has lost grain ", b.grain[b.left[0] ? 0 : 1],
                            ", which left the scene, and cannot be made again without it; ",
                            wanted[0] == 0 ? "name other pairs" : "name another pair"));
    if (chosen.back() && b.point_template > 0)
      args.complain(text_of("the cement of grains ", b.grain[0], " and ", b.grain[1],
                            " has no points yet; use 'fix_modify' with 'points all' for fix mpm, and 'run 0', before"));
    if (chosen.back()) made += b.points;
  }
  if (std::count(chosen.begin(), chosen.end(), 1) == 0)
    args.complain(wanted[0] == 0
                      ? std::string("there is no cement; use create_cement before")
                      : text_of("grains ", wanted[0], " and ", wanted[1], " have no cement; name a pair given to create_cement"));
  const Now now = gather(chosen, args);
  std::string trouble;
  if (comm->me == 0)
    trouble = now.points.size() == made
                  ? write(name, chosen, now)
                  : text_of("write_cement: ", made - now.points.size(), " of ", made,
                            " material points were deleted or left the box; use 'run 0' before, which takes fragments "
                            "and the cement of separated bonds out of the scene, or keep them");
  mpdem::stop_if_any(lmp, trouble);
}

// Collective.
WriteCement::Now WriteCement::gather(const std::vector<char>& chosen, const Arguments& args) const {
  AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  std::vector<GrainNow> grains;
  std::vector<PointNow> points;
  double count[3] = {0, 0, 0}, all[3];  // numbers of points without an axis, of points with one, and of columns of a film
  std::string unknown_law;
  for (int i = 0; i < atom->nlocal; ++i) {
    if (avec->is_point(i)) {
      PointNow p;
      p.tag = atom->tag[i];
      std::copy(atom->x[i], atom->x[i] + 3, p.x);
      p.record = avec->record_of(i);
      try {
        const std::array<double, 6> damage = mpdem::damage_tensor_of(avec->points_of(i), avec->slot_of(i));
        std::copy(damage.begin(), damage.end(), p.record.damage);
      } catch (const std::domain_error& e) {
        unknown_law = text_of("write_cement: the damage of the points cannot be told, since ", e.what());
      }
      if (!chosen[p.record.row]) continue;
      ++count[p.record.has_frame];
      count[2] += p.record.film;
      points.push_back(p);
    } else if (avec->orientation(i)) {
      GrainNow g;
      g.tag = atom->tag[i];
      std::copy(atom->x[i], atom->x[i] + 3, g.x);
      std::copy(avec->orientation(i), avec->orientation(i) + 4, g.q);
      grains.push_back(g);
    }
  }
  mpdem::stop_if_any(lmp, unknown_law);
  MPI_Allreduce(count, all, 3, MPI_DOUBLE, MPI_SUM, world);
  if (all[2] > 0.0)
    args.complain(text_of(all[2], " of ", all[0] + all[1],
                          " points are columns of a film, and a file has points of cells alone; use 'inner auto' or 'film grid' of "
                          "create_cement for cement that is to be written"));
  if (all[0] > 0.0 && all[1] > 0.0)
    args.complain(text_of(all[0], " of ", all[0] + all[1], " points have no axis of elasticity yet; use 'run 0' before"));
  Now now;
  now.axes = all[1] > 0.0;
  for (const GrainNow& g : mpdem::gather_on_first(world, grains)) now.grains[g.tag] = g;
  now.points = mpdem::gather_on_first(world, points);
  for (const PointNow& p : now.points)
    for (int k = 0; k < p.record.links; ++k)
      now.link_damage = now.link_damage || p.record.link[k].state[0] > 0.0 || (p.record.failed && p.record.link[k].attached);
  std::sort(now.points.begin(), now.points.end(), [](const PointNow& a, const PointNow& b) { return a.tag < b.tag; });
  return now;
}

// Call it on the first rank. Returns an error message, or an empty text.
std::string WriteCement::write(const std::string& name, const std::vector<char>& chosen, const Now& now) const {
  const std::vector<mpdem::BondRecord>& table = AtomVecMpdem::of(lmp)->bonds.table;
  for (std::size_t b = 0; b < chosen.size(); ++b)
    for (int t : table[b].grain)
      if (chosen[b] && !now.grains.count(t))
        return text_of("write_cement: grain ", t, " was deleted, but its cement is there; keep bonded grains");
  std::vector<std::array<int, 4>> cells;  // bond, cell of its lattice
  for (const PointNow& p : now.points) {
    const mpdem::BondRecord& b = table[p.record.row];
    if (b.regular) continue;
    std::array<int, 4> cell{p.record.row, 0, 0, 0};
    for (int d = 0; d < 3; ++d) cell[static_cast<std::size_t>(d) + 1] = mpdem::lattice_cell(b, d, p.record.X[d]);
    cells.push_back(cell);
  }
  std::sort(cells.begin(), cells.end());
  if (const auto twice = std::adjacent_find(cells.begin(), cells.end()); twice != cells.end()) {
    const mpdem::BondRecord& b = table[(*twice)[0]];
    return text_of("write_cement: the cement of grains ", b.grain[0], " and ", b.grain[1],
                   " is a seam, and a file has at most one point in a cell of a lattice; use a spacing of at most ", 0.5 * b.thickness,
                   " of create_cement for cement that is to be written");
  }
  const std::string other = mpdem::writer_of(lmp, name, nullptr);
  if (!other.empty()) return text_of("write_cement: file '", name, "' is written by ", other, "; name another");
  std::FILE* f = std::fopen(name.c_str(), "w");
  if (!f) return text_of("write_cement: file '", name, "' cannot be written: ", std::strerror(errno), "; check name and folder");
  std::fprintf(f, "# cement of USER-MPDEM at step %lld, to be read by create_cement ... file\n", static_cast<long long>(update->ntimestep));
  for (std::size_t b = 0; b < chosen.size(); ++b)
    if (chosen[b]) std::fprintf(f, "# grains %d and %d: spacing %.17g\n", table[b].grain[0], table[b].grain[1], table[b].spacing);
  mpdem::PointRow names;
  names.has_axis = now.axes;
  names.has_link_damage = now.link_damage;
  names.has_material = !AtomVecMpdem::of(lmp)->bonds.materials.empty();
  write_line(f, names, true);
  for (const PointNow& p : now.points) write_line(f, row_of(p, table[p.record.row], now.grains, names), false);
  const bool bad = std::ferror(f) != 0;
  if (std::fclose(f) == 0 && !bad) return "";
  return text_of("write_cement: file '", name, "' could not be written whole: ", std::strerror(errno));
}

}  // namespace LAMMPS_NS
