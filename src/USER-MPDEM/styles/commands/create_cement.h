// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Command create_cement: fills the cement between two grains with material points, or reads them from a file, and
// attaches them to the grains; or coats grains. See doc/create_cement.md. This class reads the options and exchanges grains and points
// with LIGGGHTS. cement/creation/cement_plan.h plans the bonds, and cement/creation/cement_maker.h makes them.
#ifdef COMMAND_CLASS

CommandStyle(create_cement, CreateCement)

#else

#ifndef MPDEM_STYLES_COMMANDS_CREATE_CEMENT_H
#define MPDEM_STYLES_COMMANDS_CREATE_CEMENT_H

#include <map>
#include <string>
#include <vector>

#include "../../cement/creation/cement_maker.h"
#include "../../mpm/point_store.h"
#include "../words/arguments.h"
#include "../atoms/point_atoms.h"
#include "pointers.h"

namespace mpdem {
class CalcitePatterns;
}

namespace LAMMPS_NS {

class CreateCement : protected Pointers, private mpdem::CementMakerHost {
 public:
  explicit CreateCement(LAMMPS* lmp) : Pointers(lmp) {}
  void command(int narg, char** arg);

 private:
  using Pairs = std::vector<mpdem::GrainTags>;

  // Reading of options.
  void check_scene(const mpdem::Arguments& args) const;
  int group_of_points(const std::string& name) const;
  void read_words(mpdem::Arguments& args, mpdem::CementRequest& wish);
  void read_word_of_shape(const std::string& key, mpdem::Arguments& args, mpdem::CementRequest& wish) const;
  void take_densities(const mpdem::Arguments& args, mpdem::CementRequest& wish) const;
  void check_words(const mpdem::Arguments& args, const mpdem::CementRequest& wish, bool has_inner, bool has_film) const;
  void cement_pair(mpdem::Arguments& args);
  void cement_contacts(mpdem::Arguments& args);
  void report_sums(const mpdem::CementMaker::Sums& sums, int groupbit, const std::string& name);
  static mpdem::Arguments named(const mpdem::GrainTags& pair, const mpdem::Arguments& args);  // copies args, with the pair in its messages

  // Queries of existing grains and bonds.
  std::vector<mpdem::Sphere> spheres(int groupbit) const;  // grains of this rank
  std::vector<mpdem::GrainToBond> grains_of(const Pairs& pairs) const;
  Pairs cemented() const;

  // Creation of the new bonds.
  void plan(mpdem::CementPlan& plan, const Pairs& pairs, const mpdem::Arguments& args);
  mpdem::CementMaker::Scene scene() const;
  mpdem::CementMaker::Sums make(mpdem::CementMaker& maker);
  int template_of(const std::vector<mpdem::FillPoint>& points) override;
  mpdem::TemplateHead head() const;
  std::vector<mpdem::FullPoint> full_points(int rows) override;
  std::size_t create_points(const std::vector<mpdem::NewBond>& bonds, bool more) override;
  void say(const std::string& text) override;
  void warn(const std::string& text) override;
  bool place(const mpdem::BondRecord& record, const mpdem::Mat3<double>& axes, const mpdem::FillPoint& p, double* x, int* image) const;
  static std::array<double, 3> velocity_of(const mpdem::NewBond& bond, const mpdem::Mat3<double>& axes, const mpdem::FillPoint& p);
  int add_point(const mpdem::FillPoint& p, const mpdem::NewBond& bond, int tag, double* x, const int* image);  // returns the atom

  mpdem::CalcitePatterns* patterns_ = nullptr;  // set while bonds of `contacts` are planned
  int groupbit_ = 0, type_ = 0;
  double density_ = 0.0;
  mpdem::SceneBox box_;
  mpdem::PointAtoms* atoms_ = nullptr;                  // set while points are made
  std::map<std::vector<double>, int> known_templates_;  // numbers from 1, by packed template
};

}  // namespace LAMMPS_NS

#endif
#endif
