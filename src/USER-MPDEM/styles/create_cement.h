// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Command create_cement: fills the cement between two grains with material points, or
// reads them from a file, and attaches them. See doc/create_cement.md.
#ifdef COMMAND_CLASS

CommandStyle(create_cement,CreateCement)

#else

#ifndef MPDEM_CREATE_CEMENT_H
#define MPDEM_CREATE_CEMENT_H

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "../geometry/lattice_fill.h"
#include "../mpm/body.h"
#include "../mpm/point_store.h"
#include "arguments.h"
#include "pointers.h"

namespace LAMMPS_NS {

class CreateCement : protected Pointers {
 public:
  explicit CreateCement(LAMMPS* lmp) : Pointers(lmp) {}
  void command(int narg, char** arg);

 private:
  struct Grain {
    int tag;
    double x[3], unwrapped[3], radius, mass, q[4];
  };
  Grain find_grain(int tag, const mpdem::Arguments& args) const;
  void check_grains_of_file(const std::map<int, int>& line, const mpdem::Arguments& args) const;
  void check_place(const Grain& a, const Grain& b, double length, const mpdem::Arguments& args) const;
  // Dimensions of one shape, as far as they were given.
  struct ShapeWords {
    std::string style;
    double outer = -1.0, filling = -1.0, neck = -1.0, contact = 0.0, thickness = -1.0, cap = 180.0, content = -1.0;
  };
  std::unique_ptr<mpdem::Shape> read_shapes(const mpdem::GrainPair& pair, double grain_mass, mpdem::Arguments& args);
  std::unique_ptr<mpdem::Shape> make_shape(const ShapeWords& w, const mpdem::GrainPair& pair, double grain_mass,
                                           double inner, const mpdem::Arguments& args) const;
  void check_scene(const mpdem::Arguments& args) const;
  void add_points(const std::vector<mpdem::FillPoint>& fill, const mpdem::Body& body, int body_index,
                  const mpdem::Arguments& args);

  // create_cement_file.cpp
  std::vector<mpdem::FillPoint> read_file(const mpdem::GrainPair& pair, const int* tags, const double* first_centre,
                                          mpdem::Body& body, mpdem::Vector3& corner, const mpdem::Arguments& args);
  void set_frame(const mpdem::FillPoint& p, mpdem::PointRecord& r) const;
  double most_points() const;
  void check_overlap(const std::vector<mpdem::FillPoint>& fill, const mpdem::Body& body, const mpdem::Arguments& args) const;

  void check_other_grains(const std::vector<mpdem::FillPoint>& fill, const mpdem::Body& body) const;

  // create_cement_contacts.cpp
  std::vector<std::pair<int, int>> contacts(int groupbit, double gap) const;
  void cement_contacts(char** arg, int narg, int words, mpdem::Arguments& args);

  std::string file_;
  double attach_ = 0;
  int groupbit_ = 0;
  int type_ = 0;
  double spacing_ = 0, density_ = 2710.0;
  double grid_[3] = {0, 0, 0};  // origin of the grid from the middle of the gap
};

}  // namespace LAMMPS_NS

#endif
#endif
