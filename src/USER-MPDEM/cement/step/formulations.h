// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Creates the formulation for the options of fix mpm: total (with or without re-projection) or updated Lagrangian.
#ifndef MPDEM_CEMENT_STEP_FORMULATIONS_H
#define MPDEM_CEMENT_STEP_FORMULATIONS_H

#include <memory>

#include "../bond/formulation.h"

namespace mpdem {

std::unique_ptr<const Formulation> formulation_of(const CementOptions& options);

}  // namespace mpdem

#endif
