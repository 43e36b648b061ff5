// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// atom_style mpdem: spheres as in atom_style sphere, plus the state of material points and the orientation of bonded
// grains. That state is kept once, in the layout of the MPM kernels (cement/bond/bond.h). An atom only holds its bond and
// the number of its slot there. That is all that moves when LIGGGHTS reorders atoms. The state is packed when an atom
// changes rank or is written to a restart file.
#ifdef ATOM_CLASS

AtomStyle(mpdem, AtomVecMpdem)

#else

#ifndef MPDEM_STYLES_ATOMS_ATOM_VEC_MPDEM_H
#define MPDEM_STYLES_ATOMS_ATOM_VEC_MPDEM_H

#include <array>
#include <map>
#include <string>
#include <vector>

#include "../../cement/layout/cement_restart.h"
#include "../../coupling/grain_state.h"
#include "../../cement/bond/bond.h"
#include "atom_vec_sphere.h"
#include "waiting_state.h"

namespace LAMMPS_NS {

class AtomVecMpdem : public AtomVecSphere {
 public:
  explicit AtomVecMpdem(LAMMPS* lmp);
  ~AtomVecMpdem() override;

  // slot[i] of atom i is the place of a point in the points of bond[i]; of a point of its film it is that place in the
  // film and Bond::kFilm. It is -2 - index into `grains` for a bonded grain, and kPlain for any other atom.
  static constexpr int kPlain = -1;
  int *slot = nullptr, *bond = nullptr;
  mpdem::Bonds bonds;
  using GrainState = mpdem::GrainState;
  std::vector<GrainState> grains;
  // State of fixes for points that were made after read_restart and before the first run.
  WaitingState waiting;
  // Does the script keep points out of LIGGGHTS' bins, and so out of all of its lists of neighbours? fix mpm finds out when a run is
  // prepared (host_guards.h). All atoms behind the first group are out of them then.
  bool apart = false;
  // The last run with fix mpm, for runs without a set-up (host_guards.h). With `run ... pre no` LIGGGHTS calls fixes by their places in
  // that run, and calls no init(). It is known here, since fix mpm may be one of the fixes that go.
  struct LastRun {
    struct Known {
      std::string id, style;
      bool created;  // LIGGGHTS clears this flag of a fix at the start of a run, but not of one that is made after that
    };
    std::vector<Known> fixes;  // at its set-up
    std::size_t bonds = 0;     // at its set-up
    bigint atoms = 0;          // at its end
    double dt = 0.0;           // at its end

    void begin(const Modify& modify, std::size_t bonds_now);
  } last_run;

  bool is_point(int i) const { return slot[i] >= 0; }
  // The store of atom i, which has to be a point, and its slot there.
  const mpdem::PointStore& points_of(int i) const { return bonds.find(bond[i])->store_of(slot[i]); }
  mpdem::PointRecord record_of(int i) const { return bonds.find(bond[i])->record(slot[i]); }
  int slot_of(int i) const { return mpdem::Bond::slot_in_store(slot[i]); }
  void add_point(int i, const mpdem::PointRecord& r, int tag) {
    bond[i] = r.row;
    slot[i] = bonds.add(r, tag);
  }
  GrainState* grain(int i) { return slot[i] <= -2 ? &grains[-2 - slot[i]] : nullptr; }
  const GrainState* grain(int i) const { return slot[i] <= -2 ? &grains[-2 - slot[i]] : nullptr; }
  double* orientation(int i) { return slot[i] <= -2 ? grain(i)->q : nullptr; }
  // LIGGGHTS clears forces and torques of the first group alone. Those of points have no meaning, so they show zero.
  void clear_loads_of_points();
  // Gives a grain a state, if it has none. Its orientation is the identity.
  void track_orientation(int i);

  // Head of the data of this style in a restart file: bytes to know it by, its version, the numbers of a body, how many
  // bodies, how many patterns of points, and whether a seal ends the file. Only host/restart_seal.cpp writes the seal.
  // Behind the head come the bodies, the bytes again, the number of numbers of the patterns, these numbers, and the
  // bytes again.
  static constexpr char kRestartMagic[8] = {'M', 'P', 'D', 'E', 'M', 'r', 's', 't'};
  static constexpr int kRestartVersion = 27, kRestartHead = 5, kRestartSealed = 4;  // kRestartSealed: place of the seal in the head
  static inline bool restart_is_sealed = false;

  // Numbers that the next restart file has with the points of a bond of this rank, kNumbersOfRow for each row. They are
  // dealt out to the points evenly, so that no atom has many. After read_restart, restored_rows has the numbers of the
  // file, on the ranks that have these points then.
  static constexpr int kNumbersOfRow = mpdem::kMostNumbers<mpdem::NodeRow>, kMostRowsOfPoint = 4096;
  void write_with_points(std::map<int, std::vector<double> > of_bonds);
  void forget_nodes() { rows_.clear(); }
  // The same on all ranks. Stops if there is cement in motion, and no fix mpm to write the motion of its nodes. Call
  // before a restart file is written.
  void check_motion_is_kept() const;
  std::vector<double> restored_rows;

  // Returns the atom style in use, or null.
  static AtomVecMpdem* of(LAMMPS* lmp);

  void init() override;
  void grow(int n) override;
  void copy(int i, int j, int delflag) override;
  int pack_exchange(int i, double* buf) override;
  int unpack_exchange(double* buf) override;
  int size_restart() override;
  int pack_restart(int i, double* buf) override;
  int unpack_restart(double* buf) override;
  void write_restart_settings(FILE* fp) override;
  void read_restart_settings(FILE* fp) override;
  void create_atom(int itype, double* coord) override;
  void data_atom(double* coord, tagint image, char** values) override;
  // write_data calls one of these, on all ranks.
  void pack_data(double** buf) override;
  void pack_data(double** buf, int tag_offset) override;
  bigint memory_usage() override;

 private:
  struct RowsOfBond {
    std::vector<double> rows;
    int points = 0, dealt = 0;  // points of the bond on this rank; how many of them have their rows already
  };
  std::map<int, RowsOfBond> rows_;  // for the next restart file
  int pack_rows(int i, double* buf);
  void send_rows_to_points(std::map<int, std::vector<double> >& of_bonds) const;
  void drop_grains_that_left();
  void refuse_data_file() const;
  bool is_in_motion() const;
  bool has_fix(const char* style) const;
  bool has_cement() const;
  int pack_state(int i, double* buf) const;
  int unpack_state(int i, const double* buf);
  int size_of_state(int i) const;
  std::vector<double> packed_bonds() const;
  std::string read_bonds(FILE* fp);
  void share_bonds();
  std::string trouble_in_atom(const double* buf, int total, int own) const;
};

}  // namespace LAMMPS_NS

#endif
#endif
