// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "create_cement.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <unordered_set>

#include "../../cement/creation/contacts.h"
#include "../../parallel/gather_ranks.h"
#include "atom.h"
#include "../atoms/atom_vec_mpdem.h"
#include "calcite_patterns.h"
#include "coat_grains.h"
#include "comm.h"
#include "content_words.h"
#include "domain.h"
#include "../fixes/fix_mpm_couple.h"
#include "group.h"
#include "../guards/host_guards.h"
#include "../words/material_words.h"
#include "modify.h"
#include "../atoms/point_atoms.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::Arguments;
using mpdem::BondRecord;
using mpdem::CementMaker;
using mpdem::CementPlan;
using mpdem::CementRequest;
using mpdem::FillPoint;
using mpdem::GrainTags;
using mpdem::GrainToBond;
using mpdem::NewBond;
using mpdem::Sphere;
using mpdem::text_of;
using mpdem::Vector3;

namespace {
constexpr double kLeastLeftOut = 0.05, kMostLeftOut = 0.9;  // limits of 'inner share'
constexpr double kManyLeftOut = 0.2;                        // it warns if more than this share of the bonds is left out
constexpr double kMostShift = 1000.0;                       // largest shift of the origin of the grid, in spacings

// All keywords. Those of shapes come once each.
std::vector<std::string> command_keywords() {
  std::vector<std::string> all = {"shape"};
  for (const mpdem::ShapeStyle& s : mpdem::shape_styles())
    for (const mpdem::ShapeOption& w : s.words)
      if (std::find(all.begin(), all.end(), w.name) == all.end()) all.push_back(w.name);
  all.insert(all.end(),
             {"content", "file", "attach", "inner", "film", "spacing", "material", "density", "grid", "overlap", "points", "type"});
  const std::vector<std::string> contents = mpdem::content_words();
  all.insert(all.end(), contents.begin(), contents.end());
  return all;
}

std::string joined(const std::vector<std::string>& parts, const std::string& between) {
  std::string text;
  for (const std::string& p : parts) text += (text.empty() ? "" : between) + p;
  return text;
}

// Names of all shapes, or of those that have this keyword.
std::vector<std::string> shapes_with(const std::string& word) {
  std::vector<std::string> names;
  for (const mpdem::ShapeStyle& s : mpdem::shape_styles())
    if (word.empty() || s.word(word)) names.push_back(s.name);
  return names;
}

}  // namespace

void CreateCement::check_scene(const Arguments& args) const {
  if (!domain->box_exist) args.complain("the simulation box does not exist yet; use create_box or read_restart before");
  if (!AtomVecMpdem::of(lmp))
    args.complain(text_of("atom style '", atom->atom_style, "' cannot hold material points; use 'atom_style mpdem'"));
  if (atom->tag_enable == 0) args.complain("needs atom IDs");
  mpdem::check_host(mpdem::kCreation, {lmp, args.command() + ": "});
}

int CreateCement::group_of_points(const std::string& name) const {
  int igroup = group->find(name.c_str());
  if (igroup < 0) {
    // Makes an empty group. Input::one cannot be used, since it would overwrite the arguments still to be read.
    std::string words[] = {name, "subtract", "all", "all"};
    char* list[] = {&words[0][0], &words[1][0], &words[2][0], &words[3][0]};
    group->assign(4, list);
    igroup = group->find(name.c_str());
  }
  return group->bitmask[igroup];
}

std::vector<Sphere> CreateCement::spheres(int groupbit) const {
  const AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  std::vector<Sphere> mine;
  for (int i = 0; i < atom->nlocal; ++i)
    if ((atom->mask[i] & groupbit) && !avec->is_point(i))
      mine.push_back(
          {atom->tag[i], Vector3(atom->x[i][0], atom->x[i][1], atom->x[i][2]), avec->coats.bare_radius(atom->tag[i], atom->radius[i])});
  return mine;
}

// Returns the grains of this rank that the pairs name.
std::vector<GrainToBond> CreateCement::grains_of(const Pairs& pairs) const {
  AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  std::unordered_set<int> tags;
  for (const GrainTags& p : pairs) tags.insert({p.first, p.second});
  std::vector<GrainToBond> mine;
  for (int i = 0; i < atom->nlocal; ++i) {
    if (!tags.count(atom->tag[i])) continue;
    GrainToBond g;
    g.tag = atom->tag[i];
    g.is_point = avec->is_point(i);
    std::copy(atom->x[i], atom->x[i] + 3, g.x);
    domain->unmap(atom->x[i], atom->image[i], g.unwrapped);
    g.radius = avec->coats.bare_radius(g.tag, atom->radius[i]);
    g.mass = avec->coats.bare_mass(g.tag, atom->rmass[i]);
    std::copy(atom->v[i], atom->v[i] + 3, g.v);
    std::copy(atom->omega[i], atom->omega[i] + 3, g.omega);
    if (!g.is_point) {
      avec->track_orientation(i);
      AtomVecMpdem::GrainState& state = *avec->grain(i);
      std::copy(state.q, state.q + 4, g.q);
      // Other cement of the grain refers to the position that is known already.
      if (!state.position_known) std::copy(g.unwrapped, g.unwrapped + 3, state.x);
      state.position_known = true;
      state.tag = atom->tag[i];
    }
    mine.push_back(g);
  }
  return mine;
}

CreateCement::Pairs CreateCement::cemented() const {
  Pairs pairs;
  for (const BondRecord& b : AtomVecMpdem::of(lmp)->bonds.table)
    if (b.has_grain(0) && b.has_grain(1)) pairs.emplace_back(b.grain[0], b.grain[1]);
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

// Reads a keyword that belongs to the last shape.
void CreateCement::read_word_of_shape(const std::string& key, Arguments& args, CementRequest& wish) const {
  if (wish.shapes.empty()) args.complain("'" + key + "' belongs to a shape; write it after 'shape ...'");
  const mpdem::ShapeStyle& style = *wish.shapes.back().style;
  const mpdem::ShapeOption* word = style.word(key);
  if (key != "content" && !word)
    args.complain("'" + key + "' belongs to 'shape " + joined(shapes_with(key), "' or 'shape ") + "', not to 'shape " + style.name + "'");
  if (key == "content" && mpdem::read_spread(args, wish.contents)) {
    wish.shapes.back().given[key] = 1.0;
    return;
  }
  const bool zero = word && word->range == mpdem::ShapeOption::not_negative;
  wish.shapes.back().given[key] = zero ? args.not_negative(key) : args.positive(key);
}

// Reads the rest of the command: shapes, each with its own keywords, and keywords for all of them.
void CreateCement::read_words(Arguments& args, CementRequest& wish) {
  bool has_inner = false, has_film = false;
  while (!args.empty()) {
    const std::string key = args.word("a keyword");
    const bool of_shape = key == "content" || !shapes_with(key).empty(), for_each_shape = of_shape || key == "material";
    // Keywords of a shape may come once for each shape.
    if (key != "shape") args.once(key, !for_each_shape || wish.shapes.empty() ? "" : text_of("shape number ", wish.shapes.size()));
    if (key == "shape") {
      wish.shapes.emplace_back();
      wish.shapes.back().style = mpdem::shape_style(args.choice(key, shapes_with("")));
    } else if (of_shape) {
      read_word_of_shape(key, args, wish);
    } else if (key == "file") {
      wish.file = args.word("a file name for 'file'");
    } else if (key == "attach") {
      wish.attach = args.positive(key);
    } else if (key == "inner") {
      const bool share = args.accept("share");
      wish.inner_rule = share ? CementRequest::usual : args.accept("auto") ? CementRequest::two_spacings : CementRequest::given;
      if (share) wish.share = args.between("inner share", kLeastLeftOut, kMostLeftOut, "of the smaller radius");
      else if (wish.inner_rule == CementRequest::given) wish.inner = args.not_negative(key, ", 'share' or 'auto'");
      has_inner = true;
    } else if (key == "film") {
      wish.film = args.choice(key, {"joined", "grid"}) == "joined";
      has_film = true;
    } else if (key == "grid") {
      const std::vector<double> v =
          args.numbers(key, {{"X", "x of the origin of the grid from the middle of the gap"}, {"Y", "y"}, {"Z", "z"}}, "0 0 0");
      std::copy(v.begin(), v.end(), wish.grid);
    } else if (key == "overlap") {
      const std::string how = args.choice(key, {"error", "skip", "trim"});
      wish.overlap = how == "skip" ? CementRequest::skip : how == "trim" ? CementRequest::trim : CementRequest::error;
    } else if (key == "spacing") {
      wish.spacing = args.positive(key);
    } else if (key == "points") {
      wish.later = args.choice(key, {"now", "later"}) == "later";
    } else if (key == "material") {
      mpdem::take_material(args, AtomVecMpdem::of(lmp)->bonds.materials, wish);
    } else if (key == "density") {
      wish.density = args.positive(key);
    } else if (mpdem::read_content_word(key, args, wish.contents)) {
    } else if (key == "type") {
      type_ = args.integer(key, 1);
    } else {
      args.unknown(key, command_keywords());
    }
  }
  wish.materials = 1 + static_cast<int>(AtomVecMpdem::of(lmp)->bonds.materials.size());
  check_words(args, wish, has_inner, has_film);
  mpdem::check_contents(args, wish, patterns_ != nullptr);
  take_densities(args, wish);
  density_ = wish.density;
  if (type_ == 0) type_ = atom->ntypes;
  if (type_ > atom->ntypes)
    args.complain(text_of("'type ", type_, "': the box has ", atom->ntypes, " atom types; raise the number in create_box"));
  mpdem::HostView view{lmp, args.command() + ": ", AtomVecMpdem::of(lmp)};
  view.new_type = type_;
  mpdem::check_host(mpdem::kPoints, view);
}

// Density of the materials. One is needed for those without a density of their own.
void CreateCement::take_densities(const Arguments& args, CementRequest& wish) const {
  for (const mpdem::Bonds::NamedMaterial& m : AtomVecMpdem::of(lmp)->bonds.materials) wish.own_densities.push_back(m.density);
  bool open = !wish.file.empty();  // a column may name any material
  for (std::size_t n = 0; n < std::max<std::size_t>(wish.shapes.size(), 1); ++n)
    open = open || wish.own_density(wish.material_of(static_cast<int>(n))) == 0.0;
  if (open) {
    if (wish.density == 0.0) wish.density = mpdem::density_of_calcite(lmp, args);
    return;
  }
  if (wish.density > 0.0)
    args.complain(text_of("'density ", wish.density, "' has no effect, since the materials have densities of their own, ",
                          wish.own_density(wish.material_of(0)), "; leave the word out, or change 'density' of cement_material"));
  wish.density = wish.own_density(wish.material_of(0));
}

void CreateCement::check_words(const Arguments& args, const CementRequest& wish, bool has_inner, bool has_film) const {
  if (wish.spacing <= 0.0) args.complain("keyword 'spacing' is missing: the distance of the material points");
  if (!wish.file.empty()) {
    if (wish.later) args.complain(text_of("'points later' belongs to shapes; those of 'file ", wish.file, "' are made now"));
    if (wish.grid[0] != 0.0 || wish.grid[1] != 0.0 || wish.grid[2] != 0.0)
      args.complain("'grid' belongs to shapes; a file says itself where its points lie");
    const char* of_shapes = has_inner ? "inner" : has_film ? "film" : wish.shapes.empty() ? nullptr : "shape";
    if (of_shapes) args.complain(text_of("'file ", wish.file, "' and '", of_shapes, "': points are either read or made, use one of them"));
    return;
  }
  for (double g : wish.grid)
    if (std::fabs(g) > kMostShift * wish.spacing)
      args.complain(text_of("'grid ", wish.grid[0], " ", wish.grid[1], " ", wish.grid[2], "': each must lie within ", kMostShift,
                            " spacings, ", kMostShift * wish.spacing, ", of the middle of the gap; parts of a cell are enough"));
  if (wish.attach > 0.0) args.complain(text_of("'attach ", wish.attach, "' belongs to 'file'; shapes know what is attached"));
  if (wish.shapes.empty())
    args.complain("keyword 'shape' is missing; use 'shape " + joined(shapes_with(""), "', 'shape ") + "', or 'file' and a name");
}

void CreateCement::command(int narg, char** arg) {
  Arguments args(lmp, "create_cement", narg, arg, 0);
  check_scene(args);
  const std::string name = args.word("a group for the points");
  groupbit_ = group_of_points(name);
  if (const std::size_t grains = mpdem::gather_all(world, spheres(groupbit_)).size(); grains > 0)
    args.complain(text_of("group '", name, "' holds ", grains, " grains; name a group for the cement alone, such as 'calcite'"));
  box_ = mpdem::scene_box(*domain);
  try {
    const std::string what = args.keyword({"pair", "contacts", "coat"});
    if (what == "coat") mpdem::coat_grains(lmp, args, box_);
    else if (what == "contacts") cement_contacts(args);
    else cement_pair(args);
  } catch (const mpdem::BadState& e) {
    mpdem::stop_all(lmp, e.what());
  }
  AtomVecMpdem::of(lmp)->coats.touch_bare(cemented());
  for (int k = 0; k < modify->nfix; ++k)
    if (FixMpmCouple* fix = dynamic_cast<FixMpmCouple*>(modify->fix[k])) fix->count_bonds();
}

Arguments CreateCement::named(const GrainTags& pair, const Arguments& args) {
  Arguments copy = args;
  copy.name_object(text_of("pair ", pair.first, " ", pair.second));
  return copy;
}

// Collective. Plans bonds of these pairs. The keywords are read after the first pair was checked.
void CreateCement::plan(CementPlan& plan, const Pairs& pairs, const Arguments& args) {
  Arguments words = named(pairs[0], args);
  plan.make(
      pairs, grains_of(pairs), cemented(), [&](CementRequest& wish) { read_words(words, wish); },
      [&](const CementPlan& bonds) { return patterns_->choose(bonds); });
}

void CreateCement::cement_pair(Arguments& args) {
  const std::array<int, 2> tags = args.pair();
  if (tags[0] == tags[1]) args.complain(text_of("'pair ", tags[0], " ", tags[1], "': two different grains are needed"));
  const GrainTags pair = std::minmax(tags[0], tags[1]);
  CementPlan bonds(world, box_);
  plan(bonds, {pair}, args);
  if (bonds.wish().overlap == CementRequest::trim)
    named(pair, args)
        .complain(
            "'overlap trim' belongs to 'contacts', whose bonds are shared out together; use 'overlap skip', or 'contacts' with a group of "
            "these grains");
  CementMaker maker(world, bonds, AtomVecMpdem::of(lmp)->bonds.table, scene(), *this);
  make(maker);
  say(maker.text_of_skipped());
}

// Reads the arguments after `contacts`, and makes the cement.
void CreateCement::cement_contacts(Arguments& args) {
  const std::string name = args.word("a group of grains for 'contacts'");
  const int igroup = group->find(name.c_str());
  if (igroup < 0) args.complain(text_of("'contacts ", name, "': there is no such group; define it by 'group' before"));
  const int groupbit = group->bitmask[igroup];
  args.keyword({"gap"});
  const double gap = args.not_negative("gap");
  const std::vector<mpdem::Sphere> all = mpdem::gather_all(world, spheres(groupbit));
  const Pairs found = mpdem::contacts(all, box_, gap), before = cemented();
  if (found.empty())
    args.complain(
        text_of("no two grains of group '", name, "' are closer than 'gap ", gap, "'; use a wider gap, or bring them together before"));
  Pairs pairs;
  std::set_difference(found.begin(), found.end(), before.begin(), before.end(), std::back_inserter(pairs));
  CementMaker::Sums sums;
  std::string left_out;
  std::size_t made = 0;
  std::size_t planned = 0;
  mpdem::CalcitePatterns patterns(lmp, groupbit, name, box_);
  if (!pairs.empty()) {
    CementPlan bonds(world, box_);
    patterns_ = &patterns;
    plan(bonds, pairs, args);
    patterns_ = nullptr;
    planned = bonds.bonds().size();
    if (bonds.wish().overlap == CementRequest::trim && !bonds.wish().file.empty())
      args.complain("'overlap trim' belongs to shapes; points of a file stay as they are, use 'overlap skip'");
    CementMaker maker(world, bonds, AtomVecMpdem::of(lmp)->bonds.table, scene(), *this);
    sums = make(maker);
    left_out = maker.text_of_skipped();
    made = planned - maker.skipped().size();
    patterns.finish(bonds, maker.skipped(), cemented());
  }
  if (const int twice = mpdem::contacts_twice(all, found, box_, gap); twice > 0 && comm->me == 0)
    warn(text_of("create_cement contacts ", name, ": ", twice,
                 " pairs of grains are in contact at more than one place, across a periodic boundary, and have cement at "
                 "one of them only; use a box that is wider along its periodic directions"));
  say(text_of("Cement at ", made, " contacts of group '", name, "' of a gap of at most ", gap, "; ", found.size() - pairs.size(),
              " had cement before\n"));
  report_sums(sums, groupbit, name);
  say(patterns.report());
  say(left_out);
  if (const std::size_t kept = planned - made; comm->me == 0 && static_cast<double>(kept) > kManyLeftOut * static_cast<double>(planned))
    warn(text_of("create_cement contacts ", name, ": ", kept, " of ", planned,
                 " bonds were left out; 'content' is the mass of a bond over that of its two grains, not the calcite content of the "
                 "specimen; use a smaller 'content' or 'outer', or 'overlap trim'"));
}

// Collective. Reports the sums over all bonds of the command.
void CreateCement::report_sums(const CementMaker::Sums& sums, int groupbit, const std::string& name) {
  const AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  double mine[2] = {0.0, 0.0}, grains[2];
  for (int i = 0; i < atom->nlocal; ++i)
    if ((atom->mask[i] & groupbit) && !avec->is_point(i)) {
      mine[0] += 1.0;
      mine[1] += avec->coats.bare_mass(atom->tag[i], atom->rmass[i]);
    }
  MPI_Allreduce(mine, grains, 2, MPI_DOUBLE, MPI_SUM, world);
  say(text_of("  in all ", std::llround(sums.points), " points, volume ", sums.volume, ", mass ", sums.mass,
              ", content (mass over that of the ", grains[0], " grains of group '", name, "', ", grains[1], ") ", sums.mass / grains[1],
              "\n"));
}

void CreateCement::say(const std::string& text) { mpdem::tell(lmp, text); }

void CreateCement::warn(const std::string& text) { error->warning("create_cement", 0, text.c_str()); }

// Collective. Returns the grains, the number of atoms and the largest ID before the cement is made.
CementMaker::Scene CreateCement::scene() const {
  CementMaker::Scene scene;
  scene.grains = spheres(~0);
  scene.atoms = static_cast<double>(atom->natoms);
  scene.last_tag = mpdem::last_tag(lmp);
  return scene;
}

CementMaker::Sums CreateCement::make(CementMaker& maker) {
  const int first_tag = maker.last_tag() + 1;
  mpdem::keep_contact_history(lmp);
  mpdem::PointAtoms atoms(lmp);
  atoms_ = &atoms;
  const CementMaker::Sums sums = maker.make();
  if (maker.created() > 0.0) atoms.finish(first_tag, maker.created());
  return sums;
}

// Bonds of one geometry share a template, whichever command makes them.
int CreateCement::template_of(const std::vector<FillPoint>& points) {
  std::vector<mpdem::PointTemplate>& templates = AtomVecMpdem::of(lmp)->bonds.templates;
  mpdem::PointTemplate point_template;
  point_template.head = head();
  point_template.head.points = static_cast<int>(points.size());
  for (const FillPoint& p : points) {
    point_template.points.emplace_back();
    mpdem::TemplatePoint& to = point_template.points.back();
    std::copy(p.X.data(), p.X.data() + 3, to.X);
    to.volume = p.volume;
    to.links = p.link_count;
    to.film = p.film;
    to.material = p.material;
    for (int k = 0; k < p.link_count; ++k) {
      to.link[k].side = p.link[k].side;
      std::copy(p.link[k].foot.data(), p.link[k].foot.data() + 3, to.link[k].foot);
      to.link[k].area = p.link[k].area;
    }
  }
  const std::vector<double> numbers = mpdem::packed({point_template});
  if (known_templates_.empty())
    for (std::size_t n = 0; n < templates.size(); ++n) known_templates_.emplace(mpdem::packed({templates[n]}), static_cast<int>(n) + 1);
  const auto known = known_templates_.emplace(numbers, static_cast<int>(templates.size()) + 1);
  if (known.second) templates.push_back(std::move(point_template));
  return known.first->second;
}

mpdem::TemplateHead CreateCement::head() const {
  mpdem::TemplateHead head;
  head.type = type_;
  head.mask = 1 | groupbit_;
  head.density = density_;
  return head;
}

}  // namespace LAMMPS_NS
