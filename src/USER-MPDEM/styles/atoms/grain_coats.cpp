// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "grain_coats.h"

#include <algorithm>

#include "atom.h"

namespace mpdem {

using namespace LAMMPS_NS;

namespace {
struct CoatCounts {
  int coats = 0, pairs = 0;
  template <class Self, class Visitor>
  static constexpr void describe(Self& c, Visitor& visit) {
    visit("its number of coats", c.coats, kCount);
    visit("its number of pairs that touch without coats", c.pairs, kCount);
  }
};
}  // namespace

void GrainCoats::add(const std::vector<Coat>& coats) {
  coats_.insert(coats_.end(), coats.begin(), coats.end());
  std::sort(coats_.begin(), coats_.end(), [](const Coat& a, const Coat& b) { return a.grain < b.grain; });
  row_.clear();
  for (std::size_t n = 0; n < coats_.size(); ++n) row_.emplace(coats_[n].grain, static_cast<int>(n));
  new_ = true;
}

void GrainCoats::touch_bare(const Pairs& pairs) {
  for (const auto& p : pairs)
    if ((find(p.first) || find(p.second)) && bare_.insert(key(p.first, p.second)).second) pairs_.push_back({{p.first, p.second}});
}

std::vector<double> GrainCoats::packed() const {
  std::vector<double> numbers;
  append(CoatCounts{static_cast<int>(coats_.size()), static_cast<int>(pairs_.size())}, numbers);
  for (const Coat& c : coats_) append(c, numbers);
  for (const BarePair& p : pairs_) append(p, numbers);
  return numbers;
}

void GrainCoats::read(RecordReader& in) {
  *this = GrainCoats();
  CoatCounts counts;
  in.read(counts);
  std::vector<Coat> coats;
  for (int n = 0; n < counts.coats && in.trouble().empty(); ++n) in.read(coats.emplace_back());
  add(coats);
  new_ = false;
  if (row_.size() != coats_.size()) in.tell("a grain has two coats");
  Pairs pairs;
  for (int n = 0; n < counts.pairs && in.trouble().empty(); ++n) {
    BarePair p;
    in.read(p);
    pairs.emplace_back(p.grain[0], p.grain[1]);
  }
  touch_bare(pairs);
}

// An overlap of less is that of grains that rest at a wall.
void GrainCoats::note_at_wall(const Coat& coat, double overlap) {
  constexpr double kAtRest = 0.01;
  const double share = overlap / coat.thickness;
  if (!new_ || share < kAtRest) return;
  at_walls_.insert(coat.grain);
  deepest_ = std::max(deepest_, share);
}

GrainCoats::AtWalls GrainCoats::take_at_walls(MPI_Comm comm) {
  AtWalls all{static_cast<int>(at_walls_.size()), deepest_};
  MPI_Allreduce(MPI_IN_PLACE, &all.grains, 1, MPI_INT, MPI_SUM, comm);
  MPI_Allreduce(MPI_IN_PLACE, &all.deepest, 1, MPI_DOUBLE, MPI_MAX, comm);
  new_ = false;
  at_walls_.clear();
  deepest_ = 0.0;
  return all;
}

// The number of numbers, the numbers, and their number again.
void GrainCoats::write(std::FILE* fp) const {
  const std::vector<double> numbers = packed();
  const long long count = static_cast<long long>(numbers.size());
  std::fwrite(&count, sizeof count, 1, fp);
  std::fwrite(numbers.data(), sizeof(double), numbers.size(), fp);
  std::fwrite(&count, sizeof count, 1, fp);
}

std::string GrainCoats::read_file(std::FILE* fp, long long most) {
  const std::string damaged = "the file is damaged in the coats of grains";
  long long count = 0, again = 0;
  if (std::fread(&count, sizeof count, 1, fp) != 1 || count < numbers_of(CoatCounts()) || count > most) return damaged;
  std::vector<double> numbers(static_cast<std::size_t>(count));
  if (std::fread(numbers.data(), sizeof(double), numbers.size(), fp) != numbers.size()) return damaged;
  if (std::fread(&again, sizeof again, 1, fp) != 1 || again != count) return damaged;
  RecordReader in(numbers.data(), numbers.data() + numbers.size());
  read(in);
  if (!in.at_end()) in.tell("they are longer than they can be");
  return in.trouble().empty() ? "" : damaged + ": " + in.trouble();
}

void GrainCoats::share(MPI_Comm comm) {
  std::vector<double> numbers = packed();
  int count = static_cast<int>(numbers.size());
  MPI_Bcast(&count, 1, MPI_INT, 0, comm);
  numbers.resize(static_cast<std::size_t>(count));
  MPI_Bcast(numbers.data(), count, MPI_DOUBLE, 0, comm);
  RecordReader in(numbers.data(), numbers.data() + numbers.size());
  read(in);
}

void GrainCoats::find_atoms(const Atom& atom) {
  atoms_.clear();
  if (empty()) return;
  for (int i = 0; i < atom.nlocal + atom.nghost; ++i)
    if (const Coat* c = find(atom.tag[i])) {
      const double of_liggghts = 0.4 * atom.rmass[i] * atom.radius[i] * atom.radius[i];
      atoms_.push_back({i, c->radius, atom.radius[i], of_liggghts / c->inertia()});
    }
}

void GrainCoats::scale_torques(Atom& atom) {
  torques_.clear();
  for (const CoatedAtom& a : atoms_) {
    if (a.i >= atom.nlocal) break;
    double* const torque = atom.torque[a.i];
    torques_.insert(torques_.end(), torque, torque + 3);
    for (int d = 0; d < 3; ++d) torque[d] *= a.torque_factor;
  }
}

void GrainCoats::restore_torques(Atom& atom) {
  for (std::size_t n = 0; 3 * n < torques_.size(); ++n) std::copy_n(&torques_[3 * n], 3, atom.torque[atoms_[n].i]);
  torques_.clear();
}

BareRadii::BareRadii(const GrainCoats& coats, Atom& atom) : coats_(coats), atom_(atom) {
  for (const GrainCoats::CoatedAtom& a : coats_.atoms()) atom_.radius[a.i] = a.bare;
}

BareRadii::~BareRadii() {
  for (const GrainCoats::CoatedAtom& a : coats_.atoms()) atom_.radius[a.i] = a.outer;
}

}  // namespace mpdem
