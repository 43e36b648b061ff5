// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#ifndef MPDEM_NUMERICS_LENGTH_H
#define MPDEM_NUMERICS_LENGTH_H

#include <cmath>

namespace mpdem {

// Length of a vector of three numbers.
inline double length(const double* d) { return std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]); }

}  // namespace mpdem

#endif
