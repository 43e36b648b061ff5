// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "formulation.h"

#include "kinematics.h"
#include "separate_parts.h"

namespace mpdem {

namespace {

constexpr double kLimitOfTransfers = 2.0;

// Points give their velocity to the nodes every so many steps.
class Reprojected : public Formulation {
 public:
  std::unique_ptr<Kinematics> kinematics(const MovingParts& parts) const override { return make_reprojected(parts); }
  std::unique_ptr<Splits> splits() const override { return std::make_unique<SeparateParts>(); }
  double stability_limit() const override { return kLimitOfTransfers; }
};

// They do so when the present becomes their reference.
class Renewed : public Formulation {
 public:
  std::unique_ptr<Kinematics> kinematics(const MovingParts& parts) const override { return make_renewed(parts); }
  std::unique_ptr<Splits> splits() const override { return std::make_unique<SeparateParts>(); }
};

// They do so in every step, since the present is their reference. Points go from cell to cell.
class Moving : public Formulation {
 public:
  std::unique_ptr<Kinematics> kinematics(const MovingParts& parts) const override { return make_updated(parts); }
  std::unique_ptr<Splits> splits() const override { return std::make_unique<JoinedPieces>(); }
  double stability_limit() const override { return kLimitOfTransfers; }
  double lasting_eigenvalue(double bound) const override { return bound; }
  int margin() const override { return UpdatedPass::kMargin; }
  bool joins_cells() const override { return false; }
  bool needs_layout(const Bond&) const override { return true; }  // slots of points were brought up to date for the exchange
  void follow_layout(Bond& b) const override {
    b.updated.bind(b.points, b.grid);
    b.average.let_points_stand(false);
  }
  void start(Bond& b) const override { UpdatedPass::start(b.points, b.grid, 0); }
  bool sort_links(Bond& b) const override {
    b.sort_links();
    return true;
  }
  void share(Bond&, AlikeLists&) const override {}
  void leave_out_dropped(Bond&, const Body&) const override {}  // links go to other blocks with their points
};

}  // namespace

std::unique_ptr<Kinematics> Formulation::kinematics(const MovingParts& parts) const { return make_total(parts); }
std::unique_ptr<Splits> Formulation::splits() const { return std::make_unique<Splits>(); }

std::unique_ptr<const Formulation> formulation_of(const CementOptions& options) {
  if (options.updated) return std::make_unique<Moving>();
  if (options.reproject_every > 0) return std::make_unique<Reprojected>();
  if (options.reproject_distortion > 0.0) return std::make_unique<Renewed>();
  return std::make_unique<Formulation>();
}

}  // namespace mpdem
