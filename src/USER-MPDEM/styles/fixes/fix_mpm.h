// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// fix mpm: the cement as a continuum on a background grid. Keywords and output are in doc/fix_mpm.md. This class is the
// host of the engine in cement/: it has the hooks of LIGGGHTS, checks the scene, and exchanges data with atoms.
// LIGGGHTS' own fixes move the grains.
#ifdef FIX_CLASS

FixStyle(mpm, FixMpm)

#else

#ifndef MPDEM_STYLES_FIXES_FIX_MPM_H
#define MPDEM_STYLES_FIXES_FIX_MPM_H

#include <memory>
#include <string>
#include <vector>

#include "../../cement/engine/cement.h"
#include "../../parallel/agree.h"
#include "../words/arguments.h"
#include "../atoms/atom_vec_mpdem.h"
#include "auto_step.h"
#include "../atoms/bonded_atoms.h"
#include "../atoms/cement_contacts.h"
#include "cement_report.h"
#include "../guards/coupling_history.h"
#include "failure_log.h"
#include "fix.h"
#include "../atoms/hidden_points.h"
#include "../guards/host_guards.h"
#include "../atoms/leaving_atoms.h"
#include "../atoms/point_ranks.h"
#include "quasistatic_watch.h"
#include "../words/material_words.h"
#include "../words/word_rules.h"

namespace LAMMPS_NS {

class FixMpm : public Fix, private mpdem::CementHost {
 public:
  FixMpm(LAMMPS* lmp, int narg, char** arg);
  ~FixMpm() override;

  void pre_delete(bool by_script) override;
  int setmask() override;
  void init() override;
  void setup_pre_exchange() override;
  void setup_pre_neighbor() override;
  void setup(int vflag) override;
  void pre_initial_integrate() override;
  void initial_integrate(int vflag) override;
  void post_integrate() override;
  void pre_exchange() override;
  void pre_neighbor() override;
  void post_force(int vflag) override;
  void pre_final_integrate() override;
  void final_integrate() override;
  void end_of_step() override;
  void post_run() override;
  void reset_dt() override;
  int modify_param(int narg, char** arg) override;

  void write_restart(FILE* fp) override;
  void restart(char* buf) override;
  double compute_scalar() override;
  double compute_vector(int n) override;
  double memory_usage() override;

  // Has any cement made a step, in this run, in an earlier one or before the restart file?
  bool in_motion() const;
  // Name of the file of events, or empty.
  const std::string& events_name() const { return failures_.file(); }
  bool events_open() const { return failures_.is_open(); }

  // Collective. Sums and states of the bonds at the present step.
  const mpdem::CementTotals& totals() { return report_->totals(*cement_); }
  const mpdem::CementTotals& totals_with_contacts() { return report_->totals_with_contacts(*cement_); }
  const std::vector<mpdem::BondState>& bonds() { return report_->bonds(*cement_); }
  const std::vector<mpdem::BondState>& loads() { return report_->loads(*cement_); }
  // Collective, and once for each force. Adds the forces of the bonds on their grains.
  void add_virials(mpdem::GrainVirial& virial) { cement_->report().add_virials(loads(), virial); }
  // Returns `intact`, `debonding`, `internal` or `mixed`.
  std::string failure_mode(int row) const { return cement_->cracks().mode(static_cast<std::size_t>(row)); }

  // Sets the coupling of fix mpm/couple. There may be one at most. said: its keywords and values.
  void set_coupling(const Fix* coupling, const mpdem::PenaltyParameters& p, const std::vector<std::string>& said);

  // Collective. Sets which grains are elastic, for both grains of each bond.
  void set_grains(const Fix* coupling, const std::vector<mpdem::ElasticPair>& of_rows);

  const mpdem::Law& law() const { return cement_->law(); }
  // Words of the materials of cement_material, known from init() on.
  const std::vector<mpdem::MaterialWords>& materials() const { return materials_; }
  mpdem::Cement& engine() const { return *cement_; }
  // Did fix_modify ask for points that are not made yet?
  bool points_are_wanted() const;
  double cell() const { return cement_->options().cell; }
  const mpdem::CementOptions& options() const { return cement_->options(); }
  AtomVecMpdem* cement() const { return avec_; }  // the atom style, which has the bonds
  // Updates the slots of atoms and the strains of points. Slots are outdated while points change cells, strains while
  // bonds are condensed. Call it before either is read.
  void show_points();
  std::vector<mpdem::PenaltyLinks::LinkTraction> link_tractions(const mpdem::Bond& b) const { return cement_->link_tractions(b); }
  // Collective. Stable step of LIGGGHTS with the present number of sub-steps. of_grains: of grains on their bonds only.
  double stable_step(bool of_grains = false);
  // Number of sub-steps of the cement in a step of LIGGGHTS.
  int substeps() const { return step_->substeps(options()); }
  // Collective. Call it after init() of all fixes. Needs a coupling, but no run.
  std::vector<mpdem::StiffnessOfBond> stiffness_of_bonds();
  // Collective, between runs. Removes all cement of these bonds, ascending, and counts it as dropped.
  void delete_bonds(const std::vector<int>& rows);
  // The fix mpm of the script, or null.
  static FixMpm* of(const Modify& modify);
  bool is_coupled() const { return cement_->penalty().has_value(); }

 private:
  std::array<double, 3> initial_velocity(int tag) override;
  void points_failed(const mpdem::Bond& bond) override { failed(bond, mpdem::Failed::points); }
  void film_failed(const mpdem::Bond& bond) override { failed(bond, mpdem::Failed::film); }
  void links_debonded(const mpdem::Bond& bond) override { failed(bond, mpdem::Failed::links); }
  void refuse(const std::string& who, std::vector<mpdem::SceneOption> others, bool from_here = true);
  void slots_changed(const mpdem::Bond& bond) override;
  void failed(const mpdem::Bond& bond, mpdem::Failed what);

  template <class F>
  void guarded(F f);
  std::string who() const;
  mpdem::StepInput step_input() const;
  bool coupling_follows() const;
  void check_coupling() const;  // stops if there is none and the script does not say so
  void set_time_step(const Fix* running);
  void write_point_atoms();
  void show_homes(bool for_run);
  void watch_outside();
  void watch_loose();
  void remove_leaving(bool points_too);
  void remove(const mpdem::Departing& departing);
  void check_positions();
  void check_unprepared();
  mpdem::HostView host() const { return {lmp, who(), avec_, this, cement_.get(), points_are_wanted()}; }
  void take_density(const mpdem::HostView& view);
  void take_materials();
  std::vector<mpdem::SceneOption> words_of_materials() const;
  void tell_materials();
  void make_points_of_run();
  void make_points(const std::vector<int>& rows);
  void write_events();
  void check_state(bool forces_known = true);

  AtomVecMpdem* avec_ = nullptr;
  std::unique_ptr<mpdem::Cement> cement_;
  std::unique_ptr<mpdem::CementReport> report_;
  std::unique_ptr<mpdem::QuasistaticWatch> watch_;
  std::unique_ptr<mpdem::AutoStep> step_;
  mpdem::BondedAtoms atoms_;
  mpdem::CementContacts contacts_;
  mpdem::FailureLog failures_;
  std::vector<mpdem::SceneOption> words_;  // keywords of the script
  mpdem::CementLawWords law_words_;
  std::shared_ptr<mpdem::Law> law_;  // that of the engine
  std::vector<mpdem::MaterialWords> materials_;
  bool materials_told_ = false;
  mpdem::CouplingHistory coupling_;
  mpdem::HiddenPoints hidden_;
  mpdem::PointRanks ranks_;
  mpdem::LeavingAtoms leaving_;
  std::vector<class FixGravity*> gravities_;  // fixes whose gravity acts on the cement too
  bool prepared_ = false;                     // was the run that begins set up (default), or not (`pre no`)?
  bool all_points_ = false;                   // make the points of all bonds when a run starts
  double memory_limit_ = 0.0;                 // memory of a rank, bytes
};

// Calls the engine. Its errors end the run in the name of this fix.
template <class F>
void FixMpm::guarded(F f) {
  cement_->set_step(step_input());
  try {
    f();
  } catch (const mpdem::OnOneRank& e) {
    mpdem::stop_one(lmp, who() + e.what());
  } catch (const mpdem::BadState& e) {
    mpdem::stop_all(lmp, who() + e.what());
  }
}

}  // namespace LAMMPS_NS

#endif
#endif
