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
#include <utility>
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
  // A bond that is to be made.
  struct Bond {
    int tags[2];
    Grain grain[2];
    double between[3];  // from the first grain to the second
    mpdem::GrainPair pair;
    std::unique_ptr<mpdem::Shape> shape;  // none: points from a file
    // Of the middle of the gap, beside the first grain.
    mpdem::Vector3 middle() const { return mpdem::Vector3(grain[0].x[0], grain[0].x[1], grain[0].x[2]) - pair.centre(0); }
  };
  struct Sums {
    double points = 0, volume = 0, mass = 0;
  };
  // Reads the words that follow the grains.
  Bond plan(const int* tags, mpdem::Arguments& args);
  // No points if the bond was left out.
  Sums make(const Bond& bond, const std::vector<mpdem::Neighbour>& neighbours, std::size_t first, mpdem::Arguments& args);
  static void measure(const std::vector<mpdem::FillPoint>& fill, mpdem::Body& body);
  Grain find_grain(int tag, const mpdem::Arguments& args) const;
  void check_grains_of_file(const std::map<int, int>& line, const mpdem::Arguments& args) const;
  void check_place(const Grain& a, const Grain& b, double length, const mpdem::Arguments& args) const;
  std::unique_ptr<mpdem::Shape> read_shapes(const mpdem::GrainPair& pair, double grain_mass, mpdem::Arguments& args);
  void check_scene(const mpdem::Arguments& args) const;
  void add_points(const std::vector<mpdem::FillPoint>& fill, const mpdem::Body& body, int body_index,
                  const mpdem::Arguments& args);

  // create_cement_file.cpp
  std::vector<mpdem::FillPoint> read_file(const mpdem::GrainPair& pair, const int* tags, const double* first_centre,
                                          mpdem::Body& body, mpdem::Vector3& corner, const mpdem::Arguments& args);
  void set_frame(const mpdem::FillPoint& p, mpdem::PointRecord& r) const;
  double most_points() const;
  std::string overlap_of(const std::vector<mpdem::FillPoint>& fill, const mpdem::Body& body, std::size_t bodies) const;
  void check_other_grains(const std::vector<mpdem::FillPoint>& fill, const mpdem::Body& body) const;

  // create_cement_contacts.cpp
  std::vector<std::pair<int, int>> contacts(int groupbit, double gap) const;
  void cement_contacts(char** arg, int narg, int words, mpdem::Arguments& args);
  std::vector<std::vector<mpdem::Neighbour>> neighbours(const std::vector<Bond>& bonds) const;
  void report_skipped(const std::vector<std::pair<int, int>>& skipped) const;
  void report_sums(const Sums& sums, int groupbit, const std::string& name) const;

  std::string file_, overlap_ = "error";
  double attach_ = 0;
  int groupbit_ = 0;
  int type_ = 0;
  double spacing_ = 0, density_ = 2710.0;
  double grid_[3] = {0, 0, 0};  // origin of the grid from the middle of the gap
};

}  // namespace LAMMPS_NS

#endif
#endif
