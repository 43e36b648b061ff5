// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// fix mpm/couple: bonds the cement of a fix mpm to its grains by the links of coupling/penalty_links.h, and reports the
// bonds. See doc/fix_mpm_couple.md.
#ifdef FIX_CLASS

FixStyle(mpm / couple, FixMpmCouple)

#else

#ifndef MPDEM_STYLES_FIXES_FIX_MPM_COUPLE_H
#define MPDEM_STYLES_FIXES_FIX_MPM_COUPLE_H

#include <memory>
#include <string>

#include "fix.h"
#include "fix_mpm.h"
#include "../words/law_words.h"

namespace mpdem {

// The elasticity of grains of an atom type; 0: of all other types.
struct ElasticType {
  int type;
  GrainElasticity elasticity;
};

struct CouplingOptions {
  double kn = -1.0, kt = -1.0, length = -1.0;  // negative: auto for kn and kt, the cell for the length
  Choice<TractionEntry> interface {
    &traction_entries().front(), {}
  };
  std::vector<ElasticType> grains;  // empty: all are rigid
  double damping = 0.0;
  double friction = -1.0;  // negative: debonded cement has no contact
  bool at_surface = true;
  int table_every = 0;
  std::string table_name;
};

}  // namespace mpdem

namespace LAMMPS_NS {

class FixMpmCouple : public Fix {
 public:
  FixMpmCouple(LAMMPS* lmp, int narg, char** arg);

  // Returns the keywords, one per line, see keywords.h.
  static std::string listed_words();

  int setmask() override;
  void init() override;
  void setup(int vflag) override;
  void end_of_step() override;
  double compute_scalar() override;
  double compute_vector(int n) override;
  double compute_array(int row, int column) override;

  // Sets the number of rows of the array to that of the bonds. Call it after bonds are made, since thermo output and
  // fix ave/time read it when they are defined.
  void count_bonds();
  // Name of the file of the table, or empty.
  const std::string& table_name() const { return words_.table_name; }
  bool table_open() const { return table_open_; }

 private:
  FixMpm* find_cement() const;
  void take_cement();
  void check_bond(int bond_row);
  std::vector<mpdem::ElasticPair> elastic_grains() const;
  std::shared_ptr<const mpdem::TractionLaw> traction_laws(double per_length) const;
  void warn_of_length(const mpdem::TractionLaw& law);
  void check_rounding(const char* keyword, double given, double per_length) const;
  double value(int bond_row, int column);
  void open_table();
  void write_table();
  void stop_if_not_written(const std::string& trouble);

  std::string cement_id_;
  FixMpm* cement_ = nullptr;
  mpdem::CouplingOptions words_;
  std::vector<std::string> said_;  // the same as text of the script, see keywords.h
  mpdem::TableFile table_;
  bool table_open_ = false, length_reported_ = false;
  bigint table_last_ = -1;  // step of the last rows
};

}  // namespace LAMMPS_NS

#endif
#endif
