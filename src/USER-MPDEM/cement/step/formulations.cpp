// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "formulations.h"

#include "kinematics.h"
#include "../failure/separate_pieces.h"

namespace mpdem {

namespace {

constexpr double kLimitOfTransfers = 2.0;

// The reference is fixed, and velocities belong to the nodes.
class TotalFormulation : public Formulation {
 public:
  std::unique_ptr<Kinematics> kinematics(const KinematicsContext& context) const override { return make_total(context); }
  std::unique_ptr<NodeSplitting> splits() const override { return std::make_unique<NodeSplitting>(); }
};

// The reference is fixed, and velocities go to the points and back every so many steps.
class ReprojectedFormulation : public Formulation {
 public:
  std::unique_ptr<Kinematics> kinematics(const KinematicsContext& context) const override { return make_reprojected(context); }
  std::unique_ptr<NodeSplitting> splits() const override { return std::make_unique<SeparatePieces>(); }
  double stability_limit() const override { return kLimitOfTransfers; }
};

// Velocities go to the points and back when the present becomes the reference.
class RenewedFormulation : public Formulation {
 public:
  std::unique_ptr<Kinematics> kinematics(const KinematicsContext& context) const override { return make_renewed_reference(context); }
  std::unique_ptr<NodeSplitting> splits() const override { return std::make_unique<SeparatePieces>(); }
};

// The present is the reference, and velocities go to the points and back in every step. Points move from cell to cell.
class UpdatedFormulation : public Formulation {
 public:
  std::unique_ptr<Kinematics> kinematics(const KinematicsContext& context) const override { return make_updated(context); }
  std::unique_ptr<NodeSplitting> splits() const override { return std::make_unique<JoinedPieces>(); }
  double stability_limit() const override { return kLimitOfTransfers; }
  double lasting_eigenvalue(double bound) const override { return bound; }
  int margin() const override { return UpdatedPass::kMargin; }
  bool joins_cells() const override { return false; }
  bool needs_layout(const Bond&) const override { return true; }  // slots were brought up to date for the exchange
  void follow_layout(Bond& b) const override {
    b.updated.bind(b.points, b.grid);
    b.average.set_points_fixed(false);
  }
  void start(Bond& b) const override { UpdatedPass::start(b.points, b.grid, 0); }
  bool sort_links(Bond& b) const override {
    b.sort_links();
    return true;
  }
  void share(Bond&, AlikeLists&) const override {}
  void remove_dropped(Bond&, const BondRecord&) const override {}  // links move to other blocks with their points
};

}  // namespace

std::unique_ptr<const Formulation> formulation_of(const CementOptions& options) {
  if (options.updated) return std::make_unique<UpdatedFormulation>();
  if (options.reproject_every > 0) return std::make_unique<ReprojectedFormulation>();
  if (options.reproject_distortion > 0.0) return std::make_unique<RenewedFormulation>();
  return std::make_unique<TotalFormulation>();
}

}  // namespace mpdem
