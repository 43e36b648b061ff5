// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// atom_style mpdem: spheres as in atom_style sphere, plus the state of material points and the orientation of bonded
// grains. The state is stored once, in the layout of the MPM kernels (cement/bond/bond.h). An atom stores only the row
// of its bond and the index of its slot there, so only these move when LIGGGHTS reorders atoms. The state is packed
// when an atom changes rank or is written to a restart file.
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
#include "grain_coats.h"
#include "unclaimed_state.h"

namespace LAMMPS_NS {

class AtomVecMpdem : public AtomVecSphere {
 public:
  explicit AtomVecMpdem(LAMMPS* lmp);
  ~AtomVecMpdem() override;

  // slot[i] of atom i is the index of a material point in the points of bond[i]. For a point of a film it is
  // Bond::kFilm plus the index in the film. For a bonded grain it is -2 - index into `grains`, and for any other atom
  // kPlain.
  static constexpr int kPlain = -1;
  int *slot = nullptr, *bond = nullptr;
  mpdem::Bonds bonds;
  using GrainState = mpdem::GrainState;
  std::vector<GrainState> grains;
  mpdem::GrainCoats coats;
  // State of other fixes for points made between read_restart and the first run.
  UnclaimedState unclaimed;
  // True if the script keeps points out of LIGGGHTS' bins, and so out of all neighbour lists. All atoms behind the
  // first group are out of the bins then. fix mpm sets it when it prepares a run, after the check in host_guards.h.
  bool points_excluded = false;
  // The last run with fix mpm, to check `run ... pre no` (host_guards.h). LIGGGHTS then calls fixes by their indices in
  // that run and calls no init(). It is stored here since fix mpm itself may be among the fixes that were removed.
  struct LastRun {
    struct Known {
      std::string id, style;
      bool created;  // just_created; LIGGGHTS clears it at the start of a run only
    };
    std::vector<Known> fixes;  // at its set-up
    std::size_t bonds = 0;     // at its set-up
    bigint atoms = 0;          // at its end
    double dt = 0.0;           // at its end

    void begin(const Modify& modify, std::size_t bonds_now);
  } last_run;

  bool is_point(int i) const { return slot[i] >= 0; }
  // The store of atom i, which must be a point, and the index of its slot there.
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
  // Sets forces and torques of points to zero. They have no meaning, and LIGGGHTS clears those of the first group only.
  void clear_loads_of_points();
  // Gives a grain a state with the identity as orientation, if it has none.
  void track_orientation(int i);

  // Head of the data of this style in a restart file: magic bytes, then version, values per bond record, number of
  // records, number of point templates, and whether a seal ends the file (only host/restart_seal.cpp writes it). Then
  // follow the records, the magic bytes, the count of the values of the templates, these values, the magic bytes again,
  // the number of bytes of the names and words of the materials, these bytes, the magic bytes again, and the coats of the
  // grains (grain_coats.h).
  static constexpr char kRestartMagic[8] = {'M', 'P', 'D', 'E', 'M', 'r', 's', 't'};
  static constexpr int kRestartVersion = 30, kRestartHead = 5, kRestartSealed = 4;  // kRestartSealed: index in the head
  static inline bool restart_is_sealed = false;  // set by host/restart_seal.cpp: the file that is written will get a seal

  // Rows of nodes, kNumbersOfRow values each, that the next restart file stores with the points of a bond on this rank.
  // They are spread evenly over the points, so that no atom has many. After read_restart, restored_rows has the rows of
  // the file, on the ranks that have these points then.
  static constexpr int kNumbersOfRow = mpdem::kMostNumbers<mpdem::NodeRow>, kMostRowsOfPoint = 4096;
  void write_with_points(std::map<int, std::vector<double> > of_bonds);
  void forget_nodes() { rows_.clear(); }
  // Same result on all ranks. Stops if cement is in motion and there is no fix mpm to write the motion of its nodes.
  // Call it before a restart file is written.
  void check_motion_is_kept() const;
  std::vector<double> restored_rows;  // rows of the restart file, kNumbersOfRow numbers each

  // Returns the atom style in use, or null if it is another.
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
  // write_data calls one of these on all ranks.
  void pack_data(double** buf) override;
  void pack_data(double** buf, int tag_offset) override;
  bigint memory_usage() override;

 private:
  struct RowsOfBond {
    std::vector<double> rows;
    int points = 0, dealt = 0;  // points of the bond on this rank, and how many of them have their rows
  };
  std::map<int, RowsOfBond> rows_;  // rows for the next restart file
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
  std::string packed_materials() const;
  bool unpack_materials(const std::string& bytes);
  std::string read_bonds(FILE* fp);
  void share_bonds();
  std::string trouble_in_atom(const double* buf, int total, int own) const;
};

}  // namespace LAMMPS_NS

#endif
#endif
