// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "create_cement.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <unordered_map>
#include <vector>

#include "../geometry/composite.h"
#include "atom.h"
#include "atom_vec_mpdem.h"
#include "comm.h"
#include "domain.h"
#include "group.h"
#include "scene_checks.h"

namespace LAMMPS_NS {

using mpdem::Arguments;
using mpdem::Body;
using mpdem::text_of;

namespace {
// All keywords, those of shapes once each.
std::vector<std::string> keywords() {
  std::vector<std::string> all = {"shape"};
  for (const mpdem::ShapeStyle& s : mpdem::shape_styles())
    for (const mpdem::ShapeWord& w : s.words)
      if (std::find(all.begin(), all.end(), w.name) == all.end()) all.push_back(w.name);
  all.insert(all.end(), {"content", "file", "attach", "inner", "spacing", "density", "type", "grid", "overlap"});
  return all;
}

std::string joined(const std::vector<std::string>& parts, const std::string& between) {
  std::string text;
  for (const std::string& p : parts) text += (text.empty() ? "" : between) + p;
  return text;
}

// Names of all shapes, or of those that have this word.
std::vector<std::string> shapes_with(const std::string& word) {
  std::vector<std::string> names;
  for (const mpdem::ShapeStyle& s : mpdem::shape_styles())
    if (word.empty() || s.word(word)) names.push_back(s.name);
  return names;
}

constexpr double kRounding = 1e-9;  // of lengths that a script computed
}

void CreateCement::check_scene(const Arguments& args) const {
  if (!domain->box_exist) args.complain("the simulation box does not exist yet; use create_box or read_restart before");
  if (domain->dimension != 3 || domain->triclinic) args.complain("needs a three-dimensional orthogonal box");
  if (!AtomVecMpdem::of(lmp))
    args.complain(text_of("atom style '", atom->atom_style, "' cannot hold material points; use 'atom_style mpdem'"));
  if (atom->tag_enable == 0) args.complain("needs atom IDs");
  const std::string trouble = mpdem::trouble_with_units(lmp);
  if (!trouble.empty()) args.complain(trouble);
}

// In the order of the tags, with what is wrong with each. Collective, once for all.
std::vector<CreateCement::Grain> CreateCement::find_grains(const std::vector<int>& tags, std::vector<std::string>& trouble) const {
  AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  // x, unwrapped, radius, mass, q, is a point; the owner is the only one not to add zero.
  constexpr int kNumbers = 13;
  std::vector<double> all(kNumbers * tags.size(), 0.0);
  std::vector<int> found(tags.size(), 0), place(tags.size(), -1);
  std::unordered_map<int, std::size_t> at;
  for (std::size_t g = 0; g < tags.size(); ++g) at[tags[g]] = g;
  for (int i = 0; i < atom->nlocal; ++i) {
    const auto known = at.find(atom->tag[i]);
    if (known == at.end()) continue;
    ++found[known->second];
    place[known->second] = i;
  }
  for (std::size_t g = 0; g < tags.size(); ++g) {
    const int i = place[g];
    if (i < 0) continue;
    double* mine = &all[kNumbers * g];
    double u[3];
    domain->unmap(atom->x[i], atom->image[i], u);
    for (int d = 0; d < 3; ++d) {
      mine[d] = atom->x[i][d];
      mine[3 + d] = u[d];
    }
    mine[6] = atom->radius[i];
    mine[7] = atom->rmass[i];
    mine[12] = avec->is_point(i);
    if (!avec->is_point(i)) {
      avec->track_orientation(i);
      AtomVecMpdem::GrainState& state = *avec->grain(i);
      std::copy(state.q, state.q + 4, &mine[8]);
      // Other cement of the grain knows it where it was.
      if (state.placed == 0.0) std::copy(u, u + 3, state.x);
      state.placed = 1.0;
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, found.data(), static_cast<int>(found.size()), MPI_INT, MPI_SUM, world);
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM, world);
  std::vector<Grain> grains(tags.size());
  trouble.assign(tags.size(), "");
  for (std::size_t n = 0; n < tags.size(); ++n) {
    if (found[n] != 1) trouble[n] = text_of("grain ", tags[n], " does not exist; create both grains before their cement");
    const double* a = &all[kNumbers * n];
    if (found[n] == 1 && a[12] != 0.0) trouble[n] = text_of("atom ", tags[n], " is a material point, not a grain");
    Grain& g = grains[n];
    g.tag = tags[n];
    std::copy(a, a + 3, g.x);
    std::copy(a + 3, a + 6, g.unwrapped);
    g.radius = a[6];
    g.mass = a[7];
    std::copy(a + 8, a + 12, g.q);
  }
  return grains;
}

// Words up to the end of the command: shapes, each with its own, and what holds for all.
void CreateCement::read_words(Arguments& args) {
  bool has_inner = false;
  while (!args.empty()) {
    const std::string key = args.word("a keyword");
    const bool any_shape = key == "content", of_shape = any_shape || !shapes_with(key).empty();
    // words of a shape once for each
    if (key != "shape") args.once(key, !of_shape || shapes_.empty() ? "" : text_of("shape number ", shapes_.size()));
    if (key == "shape") {
      shapes_.emplace_back();
      shapes_.back().style = mpdem::shape_style(args.choice(key, shapes_with("")));
    } else if (of_shape) {
      if (shapes_.empty()) args.complain("'" + key + "' belongs to a shape; write it after 'shape ...'");
      const mpdem::ShapeStyle& style = *shapes_.back().style;
      const mpdem::ShapeWord* word = style.word(key);
      if (!any_shape && !word)
        args.complain("'" + key + "' belongs to 'shape " + joined(shapes_with(key), "' or 'shape ") + "', not to 'shape " + style.name + "'");
      const bool zero = word && word->range == mpdem::ShapeWord::not_negative;
      shapes_.back().given[key] = zero ? args.not_negative(key) : args.positive(key);
    } else if (key == "file") {
      file_ = args.word("a file name for 'file'");
    } else if (key == "attach") {
      attach_ = args.positive(key);
    } else if (key == "inner") {
      inner_ = args.accept("auto") ? -1.0 : args.not_negative(key);
      has_inner = true;
    } else if (key == "grid") {
      for (double& g : grid_) g = args.number(key);
    } else if (key == "overlap") {
      overlap_ = args.choice(key, {"error", "skip", "trim"});
    } else if (key == "spacing") {
      spacing_ = args.positive(key);
    } else if (key == "density") {
      density_ = args.positive(key);
    } else if (key == "type") {
      type_ = args.integer(key, 1);
    } else {
      args.unknown(key, keywords());
    }
  }
  if (spacing_ <= 0.0) args.complain("keyword 'spacing' is missing: the distance of the material points");
  if (!file_.empty()) {
    if (grid_[0] != 0.0 || grid_[1] != 0.0 || grid_[2] != 0.0)
      args.complain("'grid' belongs to shapes; a file says itself where its points lie");
    if (!shapes_.empty() || has_inner)
      args.complain(text_of("'file ", file_, "' and '", has_inner ? "inner" : "shape", "': points are either read or made, use one of them"));
    return;
  }
  if (attach_ > 0.0) args.complain(text_of("'attach ", attach_, "' belongs to 'file'; shapes know what is attached"));
  if (shapes_.empty())
    args.complain("keyword 'shape' is missing; use 'shape " + joined(shapes_with(""), "', 'shape ") + "', or 'file' and a name");
}

void CreateCement::Trouble::tell(std::size_t of_bond, int of_check, const std::string& why) {
  if (why.empty() || std::make_pair(of_bond, of_check) >= std::make_pair(bond, check)) return;
  bond = of_bond;
  check = of_check;
  text = why;
}

// Which rank finds it does not matter.
void CreateCement::stop_at(const Trouble& trouble) const {
  constexpr long long kChecks = 16;
  long long mine = static_cast<long long>(trouble.bond) * kChecks + trouble.check, first;
  MPI_Allreduce(&mine, &first, 1, MPI_LONG_LONG, MPI_MIN, world);
  mpdem::stop_if_any(lmp, mine == first ? trouble.text : "");
}

std::string CreateCement::prefix(const Bond& bond) const { return text_of("create_cement pair ", bond.tags[0], " ", bond.tags[1], ": "); }

Arguments CreateCement::named(const Bond& bond, const Arguments& args) const {
  Arguments copy = args;
  copy.about(text_of("pair ", bond.tags[0], " ", bond.tags[1]));
  return copy;
}

// What rounding of positions takes as strain, bonds must not feel. length: of what is strained.
std::string CreateCement::trouble_of_place(const Bond& bond, double length) const {
  constexpr double kMostStrain = 1e-6;
  double far = 0.0;
  for (const Grain& g : bond.grain)
    for (double x : g.x) far = std::max(far, std::fabs(x));
  const double rounded = std::numeric_limits<double>::epsilon() * far;
  if (!(rounded > kMostStrain * length)) return "";
  return text_of("grains ", bond.tags[0], " and ", bond.tags[1], " are ", far, " from the origin, where positions are rounded to ", rounded,
                 ", too much for a length of ", length, "; place the box nearer to the origin, within ",
                 kMostStrain * length / std::numeric_limits<double>::epsilon());
}

std::vector<CreateCement::Pair> CreateCement::cemented() const {
  std::vector<Pair> pairs;
  for (const Body& b : AtomVecMpdem::of(lmp)->bonds.table) pairs.emplace_back(b.grain[0], b.grain[1]);
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

// Fills what is known of the pair; what is wrong with it, empty if nothing is.
std::string CreateCement::trouble_of_geometry(Bond& bond) const {
  const int* tags = bond.tags;
  const Grain &g0 = bond.grain[0], &g1 = bond.grain[1];
  double* d = bond.between;
  for (int c = 0; c < 3; ++c) d[c] = g1.x[c] - g0.x[c];
  domain->minimum_image(d[0], d[1], d[2]);
  const mpdem::Vector3 centres(d[0], d[1], d[2]);
  bond.pair = mpdem::pair_between(g0.radius, g1.radius, centres);
  const double gap = bond.pair.gap, smaller = std::min(g0.radius, g1.radius), reach = 0.5 * smaller;
  const std::string far = trouble_of_place(bond, smaller);
  if (!far.empty()) return far;
  if (!(centres.norm() > 0.0) || !(gap <= reach * (1.0 + kRounding)))
    return text_of("grains ", tags[0], " and ", tags[1], " are not neighbours: their gap ", gap, " exceeds half the smaller radius, ", reach,
                   "; bring them together or name other grains");
  if (!(gap > -0.2 * reach))
    return text_of("grains ", tags[0], " and ", tags[1], " overlap by ", -gap, ", more than a tenth of the smaller radius, ", 0.2 * reach);
  return "";
}

namespace {
enum Check { geometry, shape, place_of_points, types, thickness };  // of a bond, in their order
}

// Bonds, and which of them are of one shape. The words are read after the first pair has been looked at. Collective.
void CreateCement::plan(const std::vector<Pair>& pairs, const Arguments& args) {
  std::vector<int> tags;
  std::unordered_map<int, std::size_t> index;
  for (const Pair& p : pairs)
    for (int tag : {p.first, p.second})
      if (index.emplace(tag, tags.size()).second) tags.push_back(tag);
  std::vector<std::string> wrong;
  const std::vector<Pair> before = cemented();
  const std::vector<Grain> grains = find_grains(tags, wrong);
  std::unordered_map<std::string, int> kinds;
  Trouble trouble;
  for (std::size_t n = 0; n < pairs.size(); ++n) {
    Bond bond;
    bond.tags[0] = pairs[n].first;
    bond.tags[1] = pairs[n].second;
    std::string why;
    if (std::binary_search(before.begin(), before.end(), pairs[n]))
      why = text_of("grains ", bond.tags[0], " and ", bond.tags[1], " have cement already; it would overlap");
    for (int s = 0; s < 2; ++s) {
      if (why.empty()) why = wrong[index[bond.tags[s]]];
      bond.grain[s] = grains[index[bond.tags[s]]];
    }
    if (why.empty()) why = trouble_of_geometry(bond);
    if (!why.empty()) {
      trouble.tell(n, geometry, prefix(bond) + why);
      break;
    }
    if (n == 0) {
      Arguments words = named(bond, args);
      read_words(words);
      std::string same_type;
      if (type_ == 0) type_ = atom->ntypes;
      if (type_ > atom->ntypes)
        same_type = text_of("'type ", type_, "': the box has ", atom->ntypes, " atom types; raise the number in create_box");
      else
        same_type = mpdem::trouble_with_types(lmp, *AtomVecMpdem::of(lmp), type_);
      if (!same_type.empty()) trouble.tell(n, types, prefix(bond) + same_type);
    }
    const std::string far = trouble_of_place(bond, spacing_);
    if (!far.empty()) trouble.tell(n, place_of_points, prefix(bond) + far);
    const mpdem::GrainPair& p = bond.pair;
    const double numbers[] = {p.R1, p.R2, p.gap, p.n[0], p.n[1], p.n[2], bond.grain[0].mass + bond.grain[1].mass};
    std::string key(reinterpret_cast<const char*>(numbers), sizeof numbers);
    if (!file_.empty()) key += std::to_string(n);  // each has points of its own
    const auto known = kinds.emplace(std::move(key), static_cast<int>(kinds_.size()));
    if (known.second) {
      kinds_.emplace_back();
      kinds_.back().first = n;
    }
    bond.kind = known.first->second;
    bonds_.push_back(bond);
  }
  if (file_.empty()) measure_kinds(trouble);
  stop_at(trouble);
  share_kinds();
}

// Each rank its share of the kinds: their shapes and sizes.
void CreateCement::measure_kinds(Trouble& trouble) {
  for (std::size_t k = comm->me; k < kinds_.size(); k += comm->nprocs) {
    const Bond& bond = bonds_[kinds_[k].first];
    try {
      Kind& kind = kinds_[k];
      const mpdem::Shape& made = shape_of(static_cast<int>(k));
      kind.volume = made.volume();
      for (int s = 0; s < 2; ++s) kind.area[s] = made.attached_area(s);
      kind.thickness = made.largest_thickness();
      kind.thinnest = made.smallest_thickness();
      if (kind.thickness < 2.0 * spacing_)
        trouble.tell(kind.first, thickness,
                     prefix(bond) + text_of("the cement is at most ", kind.thickness, " thick, less than a cell of two points of spacing ", spacing_,
                                            "; use a spacing of at most ", 0.5 * kind.thickness, " or more cement"));
    } catch (const mpdem::ShapeError& e) {
      trouble.tell(kinds_[k].first, shape, prefix(bond) + e.what());
    }
  }
}

void CreateCement::share_kinds() {
  constexpr int kNumbers = 5;
  std::vector<double> shared(kNumbers * kinds_.size(), 0.0);
  for (std::size_t k = comm->me; k < kinds_.size(); k += comm->nprocs) {
    const Kind& kind = kinds_[k];
    const double numbers[kNumbers] = {kind.volume, kind.area[0], kind.area[1], kind.thickness, kind.thinnest};
    std::copy(numbers, numbers + kNumbers, &shared[kNumbers * k]);
  }
  MPI_Allreduce(MPI_IN_PLACE, shared.data(), static_cast<int>(shared.size()), MPI_DOUBLE, MPI_SUM, world);
  for (std::size_t k = 0; k < kinds_.size(); ++k) {
    const double* v = &shared[kNumbers * k];
    Kind& kind = kinds_[k];
    kind.volume = v[0];
    std::copy(v + 1, v + 3, kind.area);
    kind.thickness = v[3];
    kind.thinnest = v[4];
  }
}

// Made where it is asked for. Throws ShapeError.
const mpdem::Shape& CreateCement::shape_of(int kind) {
  Kind& k = kinds_[kind];
  if (k.shape) return *k.shape;
  const Bond& bond = bonds_[k.first];
  const double grain_mass = bond.grain[0].mass + bond.grain[1].mass;
  // Where the grains come closer than a cell no grid can resolve the film between them
  // (and between rigid touching spheres its stiffness has no bound).
  const double inner = inner_ < 0.0 ? bond.pair.radius_of_thickness(2.0 * spacing_) : inner_;
  std::vector<std::unique_ptr<mpdem::Shape>> made;
  for (const mpdem::ShapeWords& w : shapes_) {
    const auto content = w.given.find("content");
    const double volume = content == w.given.end() ? 0.0 : content->second * grain_mass / density_;
    made.push_back(mpdem::make_shape(w, bond.pair, volume, inner));
  }
  if (made.size() == 1) k.shape = std::move(made.front());
  else k.shape = std::make_unique<mpdem::Composite>(std::move(made));
  return *k.shape;
}

void CreateCement::command(int narg, char** arg) {
  Arguments args(lmp, "create_cement", narg, arg, 0);
  check_scene(args);
  const std::string group_name = args.word("a group for the points");
  int igroup = group->find(group_name.c_str());
  if (igroup < 0) {
    // An empty group. Not by Input::one, which would overwrite the words still to be read.
    std::string words[] = {group_name, "subtract", "all", "all"};
    char* list[] = {&words[0][0], &words[1][0], &words[2][0], &words[3][0]};
    group->assign(4, list);
    igroup = group->find(group_name.c_str());
  }
  groupbit_ = group->bitmask[igroup];
  if (args.choice("pair", {"pair", "contacts"}) == "contacts") {
    cement_contacts(args);
    return;
  }
  int tags[2];
  tags[0] = args.integer("pair", 1);
  tags[1] = args.integer("pair", 1);
  if (tags[0] == tags[1]) args.complain(text_of("'pair ", tags[0], " ", tags[1], "': two different grains are needed"));
  std::sort(tags, tags + 2);
  plan({{tags[0], tags[1]}}, args);
  if (overlap_ == "trim")
    named(bonds_[0], args).complain("'overlap trim' belongs to 'contacts', whose bonds are shared out together; use 'overlap skip', or 'contacts' with a group of these grains");
  std::vector<Pair> skipped;
  make(args, skipped);
  report_skipped(skipped);
}

}  // namespace LAMMPS_NS
