// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "cement_checks.h"

#include <algorithm>
#include <cmath>

#include "../words/arguments.h"
#include "comm.h"

namespace mpdem {

using namespace LAMMPS_NS;

namespace {
constexpr double kMostSpacings = 4.0;  // largest cell without a warning, in spacings
}

std::string axis_name(AxisRule rule, const double* direction) {
  if (rule == AxisRule::global) return text_of("global ", direction[0], " ", direction[1], " ", direction[2]);
  return rule == AxisRule::bond ? "bond" : "radial";
}

// Checks the cell against the cement of each bond. Warnings name the worst bond.
void check_cell(LAMMPS* lmp, const std::string& who, const std::vector<BondRecord>& table, double cell) {
  double widest = 0.0, finest = 1e300;
  for (const BondRecord& b : table) {
    if (b.thickness == 0.0) continue;  // all film
    if (b.is_thinner_than(cell) && b.thickness >= 2.0 * b.spacing)
      stop_all(lmp, who + text_of("'cell ", cell, "' is larger than the cement between grains ", b.grain[0], " and ", b.grain[1],
                                  " is thick (", b.thickness, "); use a smaller cell and spacing"));
    if (b.spacing > 1.5 * cell)
      stop_all(lmp, who + text_of("'cell ", cell, "' leaves cells without points between those of spacing ", b.spacing, " between grains ",
                                  b.grain[0], " and ", b.grain[1], ", which would not hold together; use a cell of at least ", b.spacing,
                                  ", better two spacings, or create the cement with a smaller spacing"));
    if (cell > (kMostAcross + 0.5) * b.spacing * (1.0 - 1e-9))
      stop_all(lmp, who + text_of("'cell ", cell, "' is ", cell / b.spacing, " spacings of the cement between grains ", b.grain[0], " and ",
                                  b.grain[1], " wide, at most ", kMostAcross + 0.5, " are allowed; use a cell of two spacings, ",
                                  2.0 * b.spacing));
    widest = std::max(widest, b.spacing);
    finest = std::min(finest, b.spacing);
  }
  if (lmp->comm->me != 0) return;
  if (widest > 0.75 * cell)
    mpdem::warn(lmp, text_of("one point a cell: spacing ", widest, " with cell ", cell,
                             " makes the cement some per cent too soft; use a cell of at least two spacings"));
  if (cell > kMostSpacings * finest * (1.0 + 1e-9))
    mpdem::warn(lmp,
                text_of("'cell ", cell, "' is ", cell / finest, " spacings of ", finest, " wide. More than ", kMostSpacings,
                        " cost time for nothing: the cell limits what is resolved. Use a cell of two spacings, or create the cement with "
                        "spacing ",
                        0.5 * cell));
}

// Frames stay those of the first run, even if a new fix has another rule.
void check_axis(LAMMPS* lmp, const std::string& who, const std::vector<BondRecord>& table, const CementOptions& o) {
  for (const BondRecord& b : table) {
    double along = 0.0;
    for (int d = 0; d < 3; ++d) along += b.axis[d] * o.axis_direction[d];
    if (b.axis_rule == AxisRule::none || (b.axis_rule == o.axis && (o.axis != AxisRule::global || std::fabs(along) > 1.0 - 1e-12)))
      continue;
    stop_all(lmp, text_of(who, "'axis ", axis_name(o.axis, o.axis_direction), "' but the axes of the cement of grains ", b.grain[0],
                          " and ", b.grain[1], " were set in its first run, by 'axis ", axis_name(b.axis_rule, b.axis),
                          "'; use that, or create the cement anew"));
  }
}

void check_links(LAMMPS* lmp, const std::string& who, const AtomVecMpdem& avec, const TractionLaw& law) {
  std::string trouble;
  if (law.fields() > 0) return;
  for (const Bond& bond : avec.bonds)
    for (const Link& k : bond.points.links) {
      std::string of_other_laws;
      if (k.attached && bond.points.has_failed(k.slot)) of_other_laws = " holds a point that failed";
      else if (k.state[0] != 0.0) of_other_laws = text_of(" has the damage ", k.state[0]);
      if (of_other_laws.empty() || !trouble.empty()) continue;
      const BondRecord& record = avec.bonds.record(bond);
      trouble = text_of(who, "a link of the cement of grains ", record.grain[0], " and ", record.grain[1], of_other_laws,
                        ", of which 'interface ", law.name(),
                        "' does not know; use 'interface cohesive', or leave the columns 'damage_i damage_j' out of the file");
    }
  stop_if_any(lmp, trouble);
}

}  // namespace mpdem
