// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "create_cement.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "../geometry/composite.h"
#include "../geometry/shape_styles.h"
#include "../parallel/memory_limit.h"
#include "atom.h"
#include "atom_vec_mpdem.h"
#include "comm.h"
#include "domain.h"
#include "fix.h"
#include "force.h"
#include "group.h"
#include "modify.h"
#include "pair.h"
#include "scene_checks.h"
#include "update.h"

namespace LAMMPS_NS {

using mpdem::Arguments;
using mpdem::Body;
using mpdem::FillPoint;
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

CreateCement::Grain CreateCement::find_grain(int tag, const Arguments& args) const {
  AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  // x, unwrapped, radius, mass, q, is a point; the owner is the only one not to add zero.
  double mine[13] = {0}, all[13];
  int count = 0, found;
  for (int i = 0; i < atom->nlocal; ++i) {
    if (atom->tag[i] != tag) continue;
    ++count;
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
      AtomVecMpdem::GrainState& g = *avec->grain(i);
      std::copy(g.q, g.q + 4, &mine[8]);
      // Other cement of the grain knows it where it was.
      if (g.placed == 0.0) std::copy(u, u + 3, g.x);
      g.placed = 1.0;
    }
  }
  MPI_Allreduce(&count, &found, 1, MPI_INT, MPI_SUM, world);
  MPI_Allreduce(mine, all, 13, MPI_DOUBLE, MPI_SUM, world);
  if (found != 1) args.complain(text_of("grain ", tag, " does not exist; create both grains before their cement"));
  if (all[12] != 0.0) args.complain(text_of("atom ", tag, " is a material point, not a grain"));
  Grain g;
  g.tag = tag;
  for (int d = 0; d < 3; ++d) {
    g.x[d] = all[d];
    g.unwrapped[d] = all[3 + d];
  }
  g.radius = all[6];
  g.mass = all[7];
  std::copy(all + 8, all + 12, g.q);
  return g;
}

// Words up to the end of the command: shapes, each with its own, and what holds for all.
std::unique_ptr<mpdem::Shape> CreateCement::read_shapes(const mpdem::GrainPair& pair, double grain_mass,
                                                        Arguments& args) {
  double inner = -1.0;
  bool has_inner = false;
  std::vector<mpdem::ShapeWords> shapes;
  while (!args.empty()) {
    const std::string key = args.word("a keyword");
    const bool any_shape = key == "content", of_shape = any_shape || !shapes_with(key).empty();
    // words of a shape once for each
    if (key != "shape") args.once(key, !of_shape || shapes.empty() ? "" : text_of("shape number ", shapes.size()));
    if (key == "shape") {
      shapes.emplace_back();
      shapes.back().style = mpdem::shape_style(args.choice(key, shapes_with("")));
    } else if (of_shape) {
      if (shapes.empty()) args.complain("'" + key + "' belongs to a shape; write it after 'shape ...'");
      const mpdem::ShapeStyle& style = *shapes.back().style;
      const mpdem::ShapeWord* word = style.word(key);
      if (!any_shape && !word)
        args.complain("'" + key + "' belongs to 'shape " + joined(shapes_with(key), "' or 'shape ") + "', not to 'shape " + style.name + "'");
      const bool zero = word && word->range == mpdem::ShapeWord::not_negative;
      shapes.back().given[key] = zero ? args.not_negative(key) : args.positive(key);
    } else if (key == "file") {
      file_ = args.word("a file name for 'file'");
    } else if (key == "attach") {
      attach_ = args.positive(key);
    } else if (key == "inner") {
      inner = args.accept("auto") ? -1.0 : args.not_negative(key);
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
    if (!shapes.empty() || has_inner)
      args.complain(text_of("'file ", file_, "' and '", has_inner ? "inner" : "shape", "': points are either read or made, use one of them"));
    return nullptr;
  }
  if (attach_ > 0.0) args.complain(text_of("'attach ", attach_, "' belongs to 'file'; shapes know what is attached"));
  if (shapes.empty())
    args.complain("keyword 'shape' is missing; use 'shape " + joined(shapes_with(""), "', 'shape ") + "', or 'file' and a name");
  try {
    // Where the grains come closer than a cell no grid can resolve the film between them
    // (and between rigid touching spheres its stiffness has no bound).
    if (inner < 0.0) inner = pair.radius_of_thickness(2.0 * spacing_);
    std::vector<std::unique_ptr<mpdem::Shape>> made;
    for (const mpdem::ShapeWords& w : shapes) {
      const auto content = w.given.find("content");
      const double volume = content == w.given.end() ? 0.0 : content->second * grain_mass / density_;
      made.push_back(mpdem::make_shape(w, pair, volume, inner));
    }
    if (made.size() == 1) return std::move(made.front());
    return std::make_unique<mpdem::Composite>(std::move(made));
  } catch (const mpdem::ShapeError& e) {
    args.complain(e.what());
  }
}

// What rounding of positions takes as strain, bonds must not feel. length: of what is strained.
void CreateCement::check_place(const Grain& a, const Grain& b, double length, const Arguments& args) const {
  constexpr double kMostStrain = 1e-6;
  double far = 0.0;
  for (const Grain* g : {&a, &b})
    for (double x : g->x) far = std::max(far, std::fabs(x));
  const double rounded = std::numeric_limits<double>::epsilon() * far;
  if (rounded > kMostStrain * length)
    args.complain(text_of("grains ", a.tag, " and ", b.tag, " are ", far, " from the origin, where positions are rounded to ", rounded,
                          ", too much for a length of ", length, "; place the box nearer to the origin, within ",
                          kMostStrain * length / std::numeric_limits<double>::epsilon()));
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
    constexpr int kWords = 5;  // the group of the points, contacts, the group of the grains, gap, its value
    cement_contacts(arg, narg, kWords, args);
    return;
  }
  int tags[2];
  tags[0] = args.integer("pair", 1);
  tags[1] = args.integer("pair", 1);
  if (tags[0] == tags[1]) args.complain(text_of("'pair ", tags[0], " ", tags[1], "': two different grains are needed"));
  args.about(text_of("pair ", tags[0], " ", tags[1]));
  std::sort(tags, tags + 2);
  const Bond bond = plan(tags, args);
  if (overlap_ == "trim")
    args.complain("'overlap trim' belongs to 'contacts', whose bonds are shared out together; use 'overlap skip', or 'contacts' with a group of these grains");
  if (make(bond, {}, AtomVecMpdem::of(lmp)->bodies.size(), args).points == 0.0) report_skipped({{tags[0], tags[1]}});
}

CreateCement::Bond CreateCement::plan(const int* tags, Arguments& args) {
  AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  for (const Body& b : avec->bodies)
    if (b.grain[0] == tags[0] && b.grain[1] == tags[1])
      args.complain(text_of("grains ", tags[0], " and ", tags[1], " have cement already; it would overlap"));
  Bond bond;
  std::copy(tags, tags + 2, bond.tags);
  for (int s = 0; s < 2; ++s) bond.grain[s] = find_grain(tags[s], args);
  const Grain &g0 = bond.grain[0], &g1 = bond.grain[1];
  double* d = bond.between;
  for (int c = 0; c < 3; ++c) d[c] = g1.x[c] - g0.x[c];
  domain->minimum_image(d[0], d[1], d[2]);
  const mpdem::Vector3 centres(d[0], d[1], d[2]);
  const mpdem::GrainPair pair{g0.radius, g1.radius, centres.norm() - g0.radius - g1.radius, centres.normalized()};
  const double smaller = std::min(g0.radius, g1.radius), reach = 0.5 * smaller;
  check_place(g0, g1, smaller, args);
  if (!(centres.norm() > 0.0) || !(pair.gap <= reach * (1.0 + kRounding)))
    args.complain(text_of("grains ", tags[0], " and ", tags[1], " are not neighbours: their gap ", pair.gap,
                          " exceeds half the smaller radius, ", reach, "; bring them together or name other grains"));
  if (!(pair.gap > -0.2 * reach))
    args.complain(text_of("grains ", tags[0], " and ", tags[1], " overlap by ", -pair.gap,
                          ", more than a tenth of the smaller radius, ", 0.2 * reach));
  bond.pair = pair;
  bond.shape = read_shapes(pair, g0.mass + g1.mass, args);
  check_place(g0, g1, spacing_, args);
  if (type_ == 0) type_ = atom->ntypes;
  if (type_ > atom->ntypes)
    args.complain(text_of("'type ", type_, "': the box has ", atom->ntypes, " atom types; raise the number in create_box"));
  const std::string same_type = mpdem::trouble_with_types(lmp, *avec, type_);
  if (!same_type.empty()) args.complain(same_type);
  if (bond.shape && bond.shape->largest_thickness() < 2.0 * spacing_)
    args.complain(text_of("the cement is at most ", bond.shape->largest_thickness(), " thick, less than a cell of two points of spacing ",
                          spacing_, "; use a spacing of at most ", 0.5 * bond.shape->largest_thickness(), " or more cement"));
  return bond;
}

// Bodies from `first` on are shared out among each other, by `neighbours`.
CreateCement::Sums CreateCement::make(const Bond& bond, const std::vector<mpdem::Neighbour>& neighbours, std::size_t first, Arguments& args) {
  AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  if (avec->bodies.size() == mpdem::kMaxBodies) args.complain(text_of("there are ", mpdem::kMaxBodies, " bonds, which is the most"));
  const int* tags = bond.tags;
  const Grain &g0 = bond.grain[0], &g1 = bond.grain[1];
  const mpdem::GrainPair& pair = bond.pair;
  const std::unique_ptr<mpdem::Shape>& shape = bond.shape;
  Body body;
  std::vector<FillPoint> fill;
  mpdem::Vector3 corner = mpdem::Vector3::Zero();
  std::string what;
  try {
    if (shape) {
      fill = mpdem::fill_with_points(*shape, spacing_, most_points(), neighbours);
      corner = mpdem::Vector3(grid_[0], grid_[1], grid_[2]);
      for (FillPoint& p : fill) {
        p.X -= corner;
        for (int k = 0; k < p.links; ++k) p.link[k].foot -= corner;
      }
      for (int c = 0; c < 3; ++c) body.lattice[c] = -corner[c];
      for (int s = 0; s < 2; ++s) body.attached_area[s] = shape->attached_area(s);
      body.volume = shape->volume();
      if (!neighbours.empty()) measure(fill, body);
      body.thickness = shape->largest_thickness();
      what = shape->describe();
      if (body.volume < shape->volume()) what += text_of(", trimmed from a volume of ", shape->volume());
    } else {
      fill = read_file(pair, tags, g0.x, body, corner, args);
      what = "file '" + file_ + "'";
    }
  } catch (const mpdem::ShapeError& e) {
    args.complain(e.what());
  }

  for (int s = 0; s < 2; ++s) {
    const Grain& g = bond.grain[s];
    body.grain[s] = tags[s];
    body.radius[s] = g.radius;
    std::copy(g.q, g.q + 4, body.orientation[s]);
    const mpdem::Vector3 centre = pair.centre(s) - corner;
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
  body.spacing = spacing_;
  body.points = static_cast<double>(fill.size());
  const std::string overlap = overlap_of(fill, body, overlap_ == "trim" ? first : avec->bodies.size());
  if (!overlap.empty()) {
    if (overlap_ == "skip") return {};
    args.complain(overlap + (overlap_ == "trim" ? ", which is of an earlier command and stays as it is; use 'overlap skip'"
                                                : "; make one of them smaller (a coating: 'cap'), leave the second out by 'overlap skip', or "
                                                  "share out the bonds of a 'contacts' by 'overlap trim'"));
  }
  check_other_grains(fill, body);
  avec->bodies.push_back(body);
  add_points(fill, body, static_cast<int>(avec->bodies.size()) - 1, args);

  if (comm->me == 0) {
    const double content = body.volume * density_ / (g0.mass + g1.mass);
    const std::string text =
        text_of("Cement between grains ", tags[0], " and ", tags[1], ": ", what, "\n  volume ",
                body.volume, ", content (mass over mass of the grains) ", content, ", attached area ",
                body.attached_area[0], " + ", body.attached_area[1], ", ", fill.size(), " points\n");
    for (FILE* f : {screen, logfile})
      if (f) std::fprintf(f, "%s", text.c_str());
    if (shape && shape->smallest_thickness() < 2.0 * spacing_ * (1.0 - 1e-9))
      error->warning("create_cement", 0,
                     text_of("pair ", tags[0], " ", tags[1], ": the cement is ", shape->smallest_thickness(), " thin at its inner rim, less than two spacings: "
                             "the film there is too soft and will not break; use 'inner auto' or a larger 'inner'")
                         .c_str());
  }
  return {body.points, body.volume, body.volume * density_};
}

// Volume and attached areas as the points have them, for bodies that neighbours have cut.
void CreateCement::measure(const std::vector<FillPoint>& fill, Body& body) {
  body.volume = body.attached_area[0] = body.attached_area[1] = 0.0;
  for (const FillPoint& p : fill) {
    body.volume += p.volume;
    for (int k = 0; k < p.links; ++k) body.attached_area[p.link[k].side] += p.link[k].area;
  }
}

// How many more points the memory holds: every rank lists them while they are made, and keeps its own.
double CreateCement::most_points() const {
  constexpr double kListed = 500.0, kKept = 700.0;  // bytes, measured
  const double kept = kKept / comm->nprocs;
  return std::max(1.0, (mpdem::memory_limit(world) - kept * static_cast<double>(atom->natoms)) / (kListed + kept));
}

void CreateCement::add_points(const std::vector<FillPoint>& fill, const Body& body, int body_index,
                              const Arguments& args) {
  AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  int largest = 0, first_tag;
  for (int i = 0; i < atom->nlocal; ++i) largest = std::max(largest, atom->tag[i]);
  MPI_Allreduce(&largest, &first_tag, 1, MPI_INT, MPI_MAX, world);
  if (fill.size() + static_cast<double>(first_tag) > 2147483647.0)
    args.complain(text_of(fill.size(), " points exceed the number of atom IDs; use a larger spacing"));

  // The list of neighbours has the history of contacts, by places of ghosts that the points will take: grains in
  // contact across ranks or a periodic boundary would forget how far they have slid. It is kept by IDs instead.
  if (force->pair && force->pair->list)
    for (int m = 0; m < modify->nfix; ++m)
      if (std::string(modify->fix[m]->style) == "contacthistory") modify->fix[m]->setup_pre_exchange();

  const int before = atom->nlocal;
  for (std::size_t n = 0; n < fill.size(); ++n) {
    const FillPoint& p = fill[n];
    double x[3];
    for (int c = 0; c < 3; ++c) x[c] = body.origin[c] + p.X[c];
    tagint image = ((tagint)IMGMAX << IMG2BITS) | ((tagint)IMGMAX << IMGBITS) | IMGMAX;
    domain->remap(x, image);
    bool mine = true;
    for (int c = 0; c < 3; ++c) mine = mine && x[c] >= domain->sublo[c] && x[c] < domain->subhi[c];
    if (!mine) continue;
    avec->create_atom(type_, x);
    const int i = atom->nlocal - 1;
    atom->tag[i] = first_tag + 1 + static_cast<int>(n);
    atom->image[i] = image;
    atom->mask[i] = 1 | groupbit_;
    atom->radius[i] = std::cbrt(0.75 * p.volume / M_PI);
    atom->density[i] = density_;
    atom->rmass[i] = density_ * p.volume;

    mpdem::PointRecord r;
    r.body = body_index;
    for (int c = 0; c < 3; ++c) r.X[c] = p.X[c];
    r.volume = p.volume;
    r.links = p.links;
    for (int k = 0; k < p.links; ++k) {
      r.link[k].grain = body.grain[p.link[k].side];
      for (int c = 0; c < 3; ++c) r.link[k].foot[c] = p.link[k].foot[c];
      r.link[k].area = p.link[k].area;
      r.link[k].attached = p.link[k].attached;
    }
    r.failed = p.failed;
    std::copy(p.damage, p.damage + 6, r.damage);
    if (p.axis.squaredNorm() > 0.0) set_frame(p, r);
    avec->slot[i] = avec->points.add(r, atom->tag[i]);
  }

  bigint local = atom->nlocal - before, created;
  MPI_Allreduce(&local, &created, 1, MPI_LMP_BIGINT, MPI_SUM, world);
  if (created != static_cast<bigint>(fill.size()))
    args.complain(text_of(fill.size() - created, " of ", fill.size(),
                          " points lie outside the simulation box; use a larger box or move the grains"));
  atom->natoms += created;
  avec->waiting.add(lmp, before, first_tag + 1);
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

}  // namespace LAMMPS_NS
