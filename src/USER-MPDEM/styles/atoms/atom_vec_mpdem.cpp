// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "atom_vec_mpdem.h"

#include <mpi.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <limits>

#include "../../parallel/all_to_all.h"
#include "../../version.h"
#include "../words/arguments.h"
#include "../words/material_words.h"
#include "atom.h"
#include "comm.h"
#include "fix.h"
#include "memory.h"
#include "modify.h"
#include "update.h"

namespace LAMMPS_NS {

namespace {
constexpr int kSphereNumbers = 17;  // numbers of an atom of style sphere, before those of fixes
// Largest number of values of the state of an atom, the first of which is its kind. One more value gives their number.
constexpr int kMostOfState = 1 + std::max(mpdem::kMostNumbers<mpdem::PointRecord>, mpdem::kMostNumbers<mpdem::GrainState>);
constexpr int kBondNumbers = mpdem::kMostNumbers<mpdem::BondRecord>;
constexpr bigint kMostMaterialBytes = 1000000;
constexpr bigint kMostTemplateNumbers = std::numeric_limits<int>::max();  // limit of values of all templates, since MPI counts in int
enum Kind {
  kNoState = 0,
  kPoint = 1,
  kGrainAtom = 2,
  kNodes = 3
};  // kNodes: number of rows of nodes, the rows, then the state of another kind
}  // namespace

// Prints the version once in each log. read_restart constructs the atom style a second time.
AtomVecMpdem::AtomVecMpdem(LAMMPS* lmp) : AtomVecSphere(lmp) {
  mpdem::forget_warnings();
  static FILE* told = nullptr;
  if (comm->me != 0 || (told && told == logfile)) return;
  told = logfile;
  mpdem::tell(lmp, mpdem::text_of("USER-MPDEM ", mpdem::kVersion, "\n"));
}

AtomVecMpdem::~AtomVecMpdem() {
  memory->destroy(slot);
  memory->destroy(bond);
}

void AtomVecMpdem::LastRun::begin(const Modify& modify, std::size_t bonds_now) {
  bonds = bonds_now;
  fixes.clear();
  for (int k = 0; k < modify.nfix; ++k) fixes.push_back({modify.fix[k]->id, modify.fix[k]->style, modify.fix[k]->just_created != 0});
}

AtomVecMpdem* AtomVecMpdem::of(LAMMPS* lmp) { return dynamic_cast<AtomVecMpdem*>(lmp->atom->avec); }

void AtomVecMpdem::track_orientation(int i) {
  if (slot[i] != kPlain) return;
  if (grains.size() == grains.capacity()) drop_grains_that_left();
  grains.emplace_back();
  slot[i] = -2 - (static_cast<int>(grains.size()) - 1);
}

// LIGGGHTS does not report atoms that go to another rank or are deleted. Half of the reserved memory is free
// afterwards, so this is not done at every arrival.
void AtomVecMpdem::drop_grains_that_left() {
  std::vector<GrainState> here;
  for (int i = 0; i < atom->nlocal; ++i) {
    if (slot[i] > -2) continue;
    here.push_back(*grain(i));
    slot[i] = -2 - (static_cast<int>(here.size()) - 1);
  }
  here.reserve(std::max<std::size_t>(64, 2 * here.size()));
  grains.swap(here);
}

// LIGGGHTS calls this at the start of a run. Other commands that initialise all styles call it too.
void AtomVecMpdem::init() {
  AtomVecSphere::init();
  points_excluded = false;
  unclaimed.finish(lmp);
  // `run 0` moves nothing, but LIGGGHTS drops the data of a restart file for fix mpm at the first run
  if (update->whichflag == 0) return;
  if (!coats.empty() && !has_fix("mpm"))
    mpdem::stop_all(
        lmp, mpdem::text_of("atom_style mpdem: grain ", coats.all()[0].grain, " has a coat, and fix mpm is not there, which gives it ",
                            "its moment of inertia and contacts; define fix mpm before the run"));
  if ((update->nsteps == 0 && !is_in_motion()) || bonds.table.empty()) return;
  // If fix mpm is gone, fix mpm/couple reports it.
  if (has_fix("mpm") || has_fix("mpm/couple") || !has_cement()) return;
  mpdem::stop_all(lmp,
                  mpdem::text_of("atom_style mpdem: grains ", bonds.table[0].grain[0], " and ", bonds.table[0].grain[1],
                                 " have cement, but there is no fix mpm, without which it would hang in the air and bond nothing; define "
                                 "fix mpm and fix mpm/couple before the run (after read_restart with the same IDs)"));
}

bool AtomVecMpdem::is_in_motion() const {
  return std::any_of(bonds.table.begin(), bonds.table.end(), [](const mpdem::BondRecord& b) { return b.in_motion; });
}

// Collective. False after a command deleted all points, or all of them left.
bool AtomVecMpdem::has_cement() const {
  int some = !bonds.rows_without_points().empty(), any;
  for (int i = 0; i < atom->nlocal; ++i) some |= is_point(i);
  MPI_Allreduce(&some, &any, 1, MPI_INT, MPI_MAX, world);
  return any != 0;
}

bool AtomVecMpdem::has_fix(const char* style) const {
  return std::any_of(modify->fix, modify->fix + modify->nfix, [&](const Fix* fix) { return std::strcmp(fix->style, style) == 0; });
}

// fix mpm itself checks whether it has the motion.
void AtomVecMpdem::check_motion_is_kept() const {
  if (!is_in_motion() || has_fix("mpm")) return;
  mpdem::stop_all(
      lmp, mpdem::text_of(
               "write_restart: the cement of grains ", bonds.table[0].grain[0], " and ", bonds.table[0].grain[1],
               " has been in motion, and there is no fix mpm, which has the motion of its nodes, so that the file would lose it; after "
               "read_restart define fix mpm with the ID it had and use 'run 0' before write_restart, and 'unfix' it later only"));
}

void AtomVecMpdem::clear_loads_of_points() {
  for (int i = 0; i < atom->nlocal; ++i) {
    if (!is_point(i)) continue;
    std::fill(atom->f[i], atom->f[i] + 3, 0.0);
    std::fill(atom->torque[i], atom->torque[i] + 3, 0.0);
  }
}

void AtomVecMpdem::grow(int n) {
  AtomVecSphere::grow(n);
  memory->grow(slot, nmax, "atom:mpdem_slot");
  memory->grow(bond, nmax, "atom:mpdem_bond");
}

void AtomVecMpdem::copy(int i, int j, int delflag) {
  slot[j] = slot[i];
  bond[j] = bond[i];
  AtomVecSphere::copy(i, j, delflag);
}

int AtomVecMpdem::pack_state(int i, double* buf) const {
  int m = 0;
  if (slot[i] >= 0) {
    buf[m++] = kPoint;
    m = static_cast<int>(mpdem::pack(record_of(i), &buf[m]) - buf);
  } else if (slot[i] <= -2) {
    buf[m++] = kGrainAtom;
    m = static_cast<int>(mpdem::pack(grains[-2 - slot[i]], &buf[m]) - buf);
  } else {
    buf[m++] = kNoState;
  }
  return m;
}

int AtomVecMpdem::unpack_state(int i, const double* buf) {
  slot[i] = kPlain;
  const int kind = static_cast<int>(*buf);
  const double* end = buf + 1;
  if (kind == kPoint) {
    mpdem::PointRecord r;
    end = mpdem::unpack(end, r);
    add_point(i, r, atom->tag[i]);
  } else if (kind == kGrainAtom) {
    track_orientation(i);
    end = mpdem::unpack(end, grains.back());
  }
  return static_cast<int>(end - buf);
}

int AtomVecMpdem::pack_exchange(int i, double* buf) {
  int m = AtomVecSphere::pack_exchange(i, buf);
  m += pack_state(i, &buf[m]);
  buf[0] = m;
  if (is_point(i)) bonds.find(bond[i])->release(slot[i]);
  return m;
}

int AtomVecMpdem::unpack_exchange(double* buf) {
  int m = AtomVecSphere::unpack_exchange(buf);
  m += unpack_state(atom->nlocal - 1, &buf[m]);
  return m;
}

int AtomVecMpdem::size_of_state(int i) const {
  if (slot[i] >= 0) return 1 + mpdem::numbers_of(record_of(i));
  return slot[i] <= -2 ? 1 + mpdem::numbers_of(grains[-2 - slot[i]]) : 1;
}

// Between runs LIGGGHTS may have sent all points of a bond to another rank, while the nodes stay until the next layout.
// Then the rows of the nodes are sent to a rank that has points.
void AtomVecMpdem::send_rows_to_points(std::map<int, std::vector<double>>& of_bonds) const {
  std::vector<int> lost;
  for (const auto& b : of_bonds) {
    const mpdem::Bond* here = bonds.find(b.first);
    if (!b.second.empty() && !(here && here->has_points())) lost.push_back(b.first);
  }
  const std::vector<int> of_all = mpdem::gather_all(world, lost);
  if (of_all.empty()) return;
  std::vector<char> has(bonds.table.size(), 0);
  for (int i = 0; i < atom->nlocal; ++i)
    if (is_point(i)) has[bond[i]] = 1;
  std::vector<int> to(of_all.size());
  for (std::size_t n = 0; n < of_all.size(); ++n) to[n] = has[of_all[n]] ? comm->me : comm->nprocs;
  MPI_Allreduce(MPI_IN_PLACE, to.data(), static_cast<int>(to.size()), MPI_INT, MPI_MIN, world);
  std::vector<std::vector<double>> sent(comm->nprocs);
  for (std::size_t n = 0; n < of_all.size(); ++n) {
    if (to[n] == comm->nprocs || !std::binary_search(lost.begin(), lost.end(), of_all[n])) continue;
    std::vector<double>& rows = of_bonds[of_all[n]];
    sent[to[n]].insert(sent[to[n]].end(), rows.begin(), rows.end());
    rows.clear();
  }
  const std::vector<double> came = mpdem::all_to_all(world, sent).data;
  mpdem::RecordReader in(came.data(), came.data() + came.size());
  for (std::size_t at = 0; at < came.size(); at += kNumbersOfRow) {
    mpdem::NodeRow row;
    in.read(row);
    std::vector<double>& rows = of_bonds[row.row];
    rows.insert(rows.end(), came.begin() + at, came.begin() + at + kNumbersOfRow);
  }
}

void AtomVecMpdem::write_with_points(std::map<int, std::vector<double>> of_bonds) {
  rows_.clear();
  send_rows_to_points(of_bonds);
  for (auto& b : of_bonds)
    if (!b.second.empty()) rows_[b.first].rows = std::move(b.second);
  for (int i = 0; i < atom->nlocal; ++i) {
    const auto of_bond = is_point(i) ? rows_.find(bond[i]) : rows_.end();
    if (of_bond != rows_.end()) ++of_bond->second.points;
  }
  std::string trouble;
  for (const auto& b : rows_)
    if (b.second.rows.size() / kNumbersOfRow > static_cast<std::size_t>(kMostRowsOfPoint) * b.second.points)
      trouble = mpdem::text_of("write_restart: the bond of grains ", bonds.table[b.first].grain[0], " and ", bonds.table[b.first].grain[1],
                               " has ", b.second.rows.size() / kNumbersOfRow, " nodes on a rank, and ", b.second.points,
                               " points, at most ", kMostRowsOfPoint, " nodes a point are allowed; use a larger cell");
  mpdem::stop_if_any(lmp, trouble);
}

int AtomVecMpdem::pack_rows(int i, double* buf) {
  const auto of_bond = is_point(i) ? rows_.find(bond[i]) : rows_.end();
  if (of_bond == rows_.end()) return 0;
  RowsOfBond& b = of_bond->second;
  const auto upto = [&](int points) { return b.rows.size() / kNumbersOfRow * points / b.points * kNumbersOfRow; };  // end of their rows
  const std::size_t from = upto(b.dealt), to = upto(b.dealt + 1);
  ++b.dealt;
  if (from == to) return 0;
  buf[0] = kNodes;
  buf[1] = static_cast<int>((to - from) / kNumbersOfRow);
  std::copy(b.rows.begin() + from, b.rows.begin() + to, buf + 2);
  return static_cast<int>(2 + to - from);
}

// The size must be exact: the file gets as many numbers as it announces.
int AtomVecMpdem::size_restart() {
  check_motion_is_kept();
  int n = AtomVecSphere::size_restart();
  for (int i = 0; i < atom->nlocal; ++i) n += size_of_state(i) + 1;
  for (auto& b : rows_) {
    b.second.dealt = 0;
    const int rows = static_cast<int>(b.second.rows.size()) / kNumbersOfRow;
    n += rows * kNumbersOfRow + 2 * std::min(rows, b.second.points);  // kind and number for each point that gets rows
  }
  return n;
}

// Rows of nodes, state and their length follow the data of the fixes. unpack_restart() removes them again before the base class
// passes the rest to the fixes.
int AtomVecMpdem::pack_restart(int i, double* buf) {
  int m = AtomVecSphere::pack_restart(i, buf);
  int n = pack_rows(i, &buf[m]);
  n += pack_state(i, &buf[m + n]);
  m += n;
  buf[m++] = n + 1;
  buf[0] = m;
  return m;
}

// Returns what is wrong with the data of an atom in a restart file. The last `own` numbers are rows of nodes, the state
// and their length. The first ones are those of AtomVecSphere::pack_restart().
std::string AtomVecMpdem::trouble_in_atom(const double* buf, int total, int own) const {
  const auto whole = [](double v) { return ubuf(v).i; };  // LIGGGHTS stores the bits of integers
  const int fixes = total - own - kSphereNumbers;
  if (fixes < 0 || !unclaimed.fits(lmp, buf + kSphereNumbers, fixes)) return "the state of fixes is not as long as the file says";
  mpdem::FirstTrouble found;
  if (whole(buf[4]) < 1 || whole(buf[4]) > std::numeric_limits<int>::max()) found.tell(mpdem::text_of("its ID is ", whole(buf[4])));
  if (whole(buf[5]) < 1 || whole(buf[5]) > atom->ntypes)
    found.tell(mpdem::text_of("its type is ", whole(buf[5]), ", allowed is 1 to ", atom->ntypes));
  for (int d = 0; d < 3; ++d) {
    found.check("its velocity", buf[8 + d], mpdem::kFinite);
    found.check("its angular velocity", buf[14 + d], mpdem::kFinite);
  }
  found.check("its radius", buf[11], mpdem::kNotNegative);
  found.check("its mass", buf[12], mpdem::kPositive);
  found.check("its density", buf[13], mpdem::kNotNegative);
  if (!found.trouble().empty()) return found.trouble();

  const double *state = buf + total - own, *end = buf + total - 1;
  const double *nodes = state, *nodes_end = state;
  if (state[0] == kNodes) {
    const auto most = std::max<std::ptrdiff_t>(1, (end - state - 3) / kNumbersOfRow);
    if (!found.check_whole("its number of nodes", state[1], mpdem::from(1.0, static_cast<double>(most)))) return found.trouble();
    nodes = state + 2;
    nodes_end = state = nodes + static_cast<int>(state[1]) * kNumbersOfRow;
    if (state >= end) return "its number of nodes is wrong";
  }
  mpdem::RecordReader in(state + 1, end);
  mpdem::PointRecord point;
  if (state[0] == kPoint) {
    in.read(point);
    if (in.trouble().empty()) in.tell(trouble_of(point, bonds.table));
    mpdem::RecordReader of_nodes(nodes, nodes_end);
    for (mpdem::NodeRow row; of_nodes.trouble().empty() && !of_nodes.at_end();) {
      of_nodes.read(row);
      of_nodes.check_whole("the bond of a node", row.row, mpdem::from(point.row, point.row));
    }
    in.tell(of_nodes.trouble());
  } else if (state[0] == kGrainAtom) {
    GrainState grain;
    in.read(grain);
  } else if (state[0] != kNoState) {
    return mpdem::text_of("its state is of kind ", state[0], ", which none is");
  }
  if (!in.at_end()) in.tell("its state is longer than it can be");
  return in.trouble();
}

int AtomVecMpdem::unpack_restart(double* buf) {
  // A seal shows whether the file is as it was written (host/restart_seal.cpp). Files may come without one.
  const double most = kSphereNumbers + atom->nextra_store + kMostOfState + 1 + static_cast<double>(kMostRowsOfPoint) * kNumbersOfRow;
  const int total = buf[0] > kSphereNumbers && buf[0] <= most ? static_cast<int>(buf[0]) : 1;
  const double own_length = buf[total - 1];
  const int own = own_length > 1.0 && own_length < total ? static_cast<int>(own_length) : 0;
  const std::string trouble =
      own == 0 || own != own_length || total != buf[0] ? "its number of numbers is wrong" : trouble_in_atom(buf, total, own);
  if (!trouble.empty())
    mpdem::stop_one(lmp, mpdem::text_of("read_restart: the file is damaged in the data of an atom (ID ", ubuf(buf[4]).i, "): ", trouble,
                                        "; use another restart file"));
  buf[0] = total - own;
  AtomVecSphere::unpack_restart(buf);
  buf[0] = total;
  const double* state = &buf[total - own];
  if (state[0] == kNodes) {
    const double* rows = state + 2;
    state = rows + static_cast<int>(state[1]) * kNumbersOfRow;
    restored_rows.insert(restored_rows.end(), rows, state);
  }
  unpack_state(atom->nlocal - 1, state);
  return total;
}

namespace {

// fwrite and fread accept no null pointer, which an empty vector has.
void write_numbers(FILE* fp, const std::vector<double>& numbers) {
  if (!numbers.empty()) fwrite(numbers.data(), sizeof(double), numbers.size(), fp);
}
bool read_numbers(FILE* fp, std::vector<double>& numbers) {
  return numbers.empty() || fread(numbers.data(), sizeof(double), numbers.size(), fp) == numbers.size();
}

// Returns how many numbers are left in a file at most.
bigint numbers_left(FILE* fp) {
  const long here = std::ftell(fp);
  std::fseek(fp, 0, SEEK_END);
  const bigint left = (std::ftell(fp) - here) / static_cast<bigint>(sizeof(double));
  std::fseek(fp, here, SEEK_SET);
  return left;
}

// Broadcasts the numbers of the first rank. There may be more than MPI can count.
void broadcast(std::vector<double>& numbers, MPI_Comm comm) {
  constexpr std::size_t kMost = std::size_t{1} << 30;
  for (std::size_t at = 0; at < numbers.size(); at += kMost)
    MPI_Bcast(&numbers[at], static_cast<int>(std::min(kMost, numbers.size() - at)), MPI_DOUBLE, 0, comm);
}

}  // namespace

void AtomVecMpdem::write_restart_settings(FILE* fp) {
  const std::vector<double> numbers = packed_bonds();
  fwrite(kRestartMagic, 1, sizeof kRestartMagic, fp);
  const int head[kRestartHead] = {kRestartVersion, kBondNumbers, static_cast<int>(bonds.table.size()),
                                  static_cast<int>(bonds.templates.size()), restart_is_sealed};
  fwrite(head, sizeof(int), kRestartHead, fp);
  write_numbers(fp, numbers);
  fwrite(kRestartMagic, 1, sizeof kRestartMagic, fp);
  const std::vector<double> packed_templates = mpdem::packed(bonds.templates);
  const bigint count = static_cast<bigint>(packed_templates.size());
  if (count > kMostTemplateNumbers)
    mpdem::stop_one(lmp, mpdem::text_of("write_restart: the templates of bonds without points have ", count, " numbers, at most ",
                                        kMostTemplateNumbers, " are allowed; use 'points now' of create_cement where bonds are not equal"));
  fwrite(&count, sizeof count, 1, fp);
  write_numbers(fp, packed_templates);
  fwrite(kRestartMagic, 1, sizeof kRestartMagic, fp);
  const std::string materials = packed_materials();
  const bigint bytes = static_cast<bigint>(materials.size());
  fwrite(&bytes, sizeof bytes, 1, fp);
  fwrite(materials.data(), 1, materials.size(), fp);
  fwrite(kRestartMagic, 1, sizeof kRestartMagic, fp);
  coats.write(fp);
}

// A line with the name and one with the words for each material.
std::string AtomVecMpdem::packed_materials() const {
  std::string bytes;
  for (const mpdem::Bonds::NamedMaterial& m : bonds.materials) bytes += m.name + "\n" + m.words + "\n";
  return bytes;
}

// Returns false if these are not lines of that kind.
bool AtomVecMpdem::unpack_materials(const std::string& bytes) {
  bonds.materials.clear();
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t first = bytes.find('\n', at), second = first == std::string::npos ? first : bytes.find('\n', first + 1);
    if (second == std::string::npos || first == at || bonds.materials.size() + 1 == static_cast<std::size_t>(mpdem::kMostMaterials))
      return false;
    bonds.materials.push_back({bytes.substr(at, first - at), bytes.substr(first + 1, second - first - 1)});
    at = second + 1;
  }
  return true;
}

std::vector<double> AtomVecMpdem::packed_bonds() const {
  std::vector<double> numbers(kBondNumbers * bonds.table.size());
  double* to = numbers.data();
  for (const mpdem::BondRecord& record : bonds.table) to = mpdem::pack(record, to);
  return numbers;
}

// Returns what is wrong with the data of this style in a file, or an empty text; then the table of bonds is that of the
// file.
std::string AtomVecMpdem::read_bonds(FILE* fp) {
  const std::string cure = "; use another restart file", truncated = "the file is truncated in the data of atom_style mpdem" + cure;
  char magic[sizeof kRestartMagic];
  int head[kRestartHead];
  const auto marked = [&] {
    return fread(magic, 1, sizeof magic, fp) == sizeof magic && std::memcmp(magic, kRestartMagic, sizeof magic) == 0;
  };
  if (!marked()) return "the file has no data of atom_style mpdem" + cure;
  if (fread(head, sizeof(int), kRestartHead, fp) != kRestartHead) return truncated;
  const int count = head[2], templates = head[3];
  if (head[0] != kRestartVersion) return mpdem::trouble_with_version("data of atom_style mpdem", head[0], kRestartVersion);
  if (head[1] != kBondNumbers || count < 0 || templates < 0)
    return mpdem::text_of("the file is damaged: it has ", count, " bonds of ", head[1], " numbers, this program writes ", kBondNumbers,
                          " numbers a bond", cure);
  if (static_cast<bigint>(kBondNumbers) * count > numbers_left(fp)) return truncated;
  std::vector<double> numbers(static_cast<std::size_t>(kBondNumbers) * count);
  if (!read_numbers(fp, numbers)) return truncated;
  if (!marked()) return mpdem::text_of("the file is damaged: it says ", count, " bonds, which is not how many it has", cure);
  bigint template_numbers = 0;
  if (fread(&template_numbers, sizeof template_numbers, 1, fp) != 1) return truncated;
  if (template_numbers < templates || template_numbers > std::min(kMostTemplateNumbers, numbers_left(fp)))
    return "the file is damaged in the templates of points" + cure;
  std::vector<double> template_values(template_numbers);
  if (!read_numbers(fp, template_values)) return truncated;
  if (!marked()) return "the file is damaged in the templates of points" + cure;
  bigint bytes = 0;
  if (fread(&bytes, sizeof bytes, 1, fp) != 1) return truncated;
  if (bytes < 0 || bytes > kMostMaterialBytes) return "the file is damaged in the materials" + cure;
  std::string of_materials(static_cast<std::size_t>(bytes), ' ');
  if (fread(&of_materials[0], 1, of_materials.size(), fp) != of_materials.size()) return truncated;
  if (!unpack_materials(of_materials) || !marked()) return "the file is damaged in the materials" + cure;
  if (const std::string why = coats.read_file(fp, numbers_left(fp)); !why.empty()) return why + cure;
  bonds.table.resize(count);
  mpdem::RecordReader in(numbers.data(), numbers.data() + numbers.size());
  for (mpdem::BondRecord& record : bonds.table) {
    in.read(record);
    if (!in.trouble().empty())
      return mpdem::text_of("the file is damaged in the data of the bond of grains ", record.grain[0], " and ", record.grain[1], ": ",
                            in.trouble(), cure);
  }
  mpdem::RecordReader in_templates(template_values.data(), template_values.data() + template_values.size());
  mpdem::read(in_templates, templates, bonds.templates);
  if (!in_templates.at_end()) in_templates.tell("they are longer than they can be");
  if (in_templates.trouble().empty()) in_templates.tell(trouble_of(bonds.templates, bonds.table));
  if (!in_templates.trouble().empty())
    return mpdem::text_of("the file is damaged in the templates of points: ", in_templates.trouble(), cure);
  return "";
}

// Called by every rank; only the first has the file.
void AtomVecMpdem::read_restart_settings(FILE* fp) {
  std::string trouble;
  if (comm->me == 0) trouble = read_bonds(fp);
  mpdem::stop_if_any(lmp, trouble.empty() ? trouble : "read_restart: " + trouble);
  share_bonds();
}

// Broadcasts bond records, point templates and coats of the first rank.
void AtomVecMpdem::share_bonds() {
  int count[3] = {static_cast<int>(bonds.table.size()), static_cast<int>(bonds.templates.size()), 0};
  std::vector<double> templates = mpdem::packed(bonds.templates);
  count[2] = static_cast<int>(templates.size());
  MPI_Bcast(count, 3, MPI_INT, 0, world);
  bonds.table.resize(count[0]);
  std::vector<double> numbers = packed_bonds();
  broadcast(numbers, world);
  const double* from = numbers.data();
  for (mpdem::BondRecord& record : bonds.table) from = mpdem::unpack(from, record);
  templates.resize(count[2]);
  MPI_Bcast(templates.data(), count[2], MPI_DOUBLE, 0, world);
  mpdem::RecordReader in(templates.data(), templates.data() + templates.size());
  mpdem::read(in, count[1], bonds.templates);
  std::string materials = packed_materials();
  int bytes = static_cast<int>(materials.size());
  MPI_Bcast(&bytes, 1, MPI_INT, 0, world);
  materials.resize(static_cast<std::size_t>(bytes));
  MPI_Bcast(&materials[0], bytes, MPI_CHAR, 0, world);
  unpack_materials(materials);
  for (mpdem::Bonds::NamedMaterial& m : bonds.materials) m.density = mpdem::read_material(lmp, m).density;
  coats.share(world);
}

void AtomVecMpdem::create_atom(int itype, double* coord) {
  AtomVecSphere::create_atom(itype, coord);
  slot[atom->nlocal - 1] = kPlain;
}

void AtomVecMpdem::data_atom(double* coord, tagint image, char** values) {
  AtomVecSphere::data_atom(coord, image, values);
  slot[atom->nlocal - 1] = kPlain;
}

// read_data would turn points into ordinary spheres, and lose the bonds.
void AtomVecMpdem::refuse_data_file() const {
  if (bonds.table.empty()) return;
  mpdem::stop_all(
      lmp, mpdem::text_of(
               "write_data: a data file has spheres alone and would lose the cement (of grains ", bonds.table[0].grain[0], " and ",
               bonds.table[0].grain[1],
               ", and so on); use write_restart and read_restart, or write_data before create_cement, and write_cement for the cement"));
}

void AtomVecMpdem::pack_data(double** buf) {
  refuse_data_file();
  AtomVecSphere::pack_data(buf);
}

void AtomVecMpdem::pack_data(double** buf, int tag_offset) {
  refuse_data_file();
  AtomVecSphere::pack_data(buf, tag_offset);
}

bigint AtomVecMpdem::memory_usage() {
  return AtomVecSphere::memory_usage() + 2 * memory->usage(slot, nmax) + static_cast<bigint>(bonds.memory_usage()) +
         static_cast<bigint>(grains.capacity() * sizeof(GrainState));
}

}  // namespace LAMMPS_NS
