// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Holds what keeps nodes of a bond apart: crevices from the start, nodes that split, and parts that came apart. Layouts
// follow it (layout.h), and Parting changes it.
#ifndef MPDEM_CEMENT_DIVISIONS_H
#define MPDEM_CEMENT_DIVISIONS_H

#include "cracks.h"
#include "sheets.h"
#include "splits.h"

namespace mpdem {

struct Divisions {
  Sheets sheets;
  Splits splits;  // with `cracks split` only
  Cracks cracks;
};

}  // namespace mpdem

#endif
