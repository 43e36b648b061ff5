// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The values of the vector of fix mpm. A value is one line of the list in cement_values.cpp, and a row of
// doc/fix_mpm.md. Scripts use the numbers of values, so a new one must be the last.
#ifndef MPDEM_CEMENT_ENGINE_CEMENT_VALUES_H
#define MPDEM_CEMENT_ENGINE_CEMENT_VALUES_H

#include <vector>

#include "bond_table.h"

namespace mpdem {

struct CementValue {
  const char *name, *description;
  double (*of)(const CementTotals&);  // null: the host provides it
  bool of_contacts = false;           // needs the contact forces of the host
};
const std::vector<CementValue>& cement_values();

}  // namespace mpdem

#endif
