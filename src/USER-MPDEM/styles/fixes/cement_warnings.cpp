// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "cement_warnings.h"

#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "../guards/unit_checks.h"
#include "../words/arguments.h"
#include "update.h"

namespace mpdem {

using LAMMPS_NS::LAMMPS;

namespace {

// Averages that are wider than the bonds.
void warn_of_averages(LAMMPS* lmp, const std::string& who, Cement& c) {
  const Law& law = c.law();
  if (law.inert()) return;
  double wide = 0.0;  // diameter of a disc with the attached area
  for (const BondRecord& b : c.bonds().table)
    for (double area : b.attached_area) wide = std::max(wide, 2.0 * std::sqrt(area / M_PI));
  const double length = c.options().length;
  if (c.options().advance.nonlocal && length > wide)
    mpdem::warn(lmp, text_of(who, "'regularization nonlocal ", length, "' averages over more than the width of the widest bond, ", wide,
                             ", so that no crack is narrower than a bond; use a length well below that, in the units of the box"));
  const double band = 2.0 * c.options().half_band;
  int thin = 0;
  double thinnest = band;
  for (const BondRecord& b : c.bonds().table)
    if (b.thickness > 0.0 && b.thickness < band) {
      ++thin;
      thinnest = std::min(thinnest, b.thickness);
    }
  if (thin > 0 && length <= wide && !c.leaves_residue())
    mpdem::warn(lmp, text_of(who, "the band in which cement breaks with 'regularization nonlocal ", length, "' is ", band, " wide, and ",
                             thin, " of ", c.bonds().table.size(), " bonds are thinner, the thinnest ", thinnest,
                             ": all surface on which these separate counts as debonding; a length of ", length * thinnest / band,
                             " or less, with cells of that, would tell"));
}

// Collective. Scatter that has no effect, since films have one energy and their faces one strength.
void warn_of_scatter(LAMMPS* lmp, const std::string& who, Cement& c) {
  const bool faces = c.penalty() && c.penalty()->law->fields() > 0;
  const bool energy = c.law().any_scatter(Scattered::energy), interface = faces && c.law().any_scatter(Scattered::interface);
  if (!energy && !interface) return;
  std::vector<int> has_film(c.bonds().table.size(), 0);
  for (const Bond& b : c.bonds()) has_film[static_cast<std::size_t>(b.row)] = b.film.empty() ? 0 : 1;
  MPI_Allreduce(MPI_IN_PLACE, has_film.data(), static_cast<int>(has_film.size()), MPI_INT, MPI_MAX, lmp->world);
  const auto films = std::count(has_film.begin(), has_film.end(), 1);
  if (films == 0) return;
  mpdem::warn(lmp, text_of(who, "'scatter ", energy ? "energy" : "interface", energy && interface ? "' and 'scatter interface" : "",
                           "' of cement_material leave", energy && interface ? " " : "s ", films, " of ", has_film.size(),
                           " bonds as they are, since these have a film; 'film grid' of create_cement has them drawn everywhere"));
}

}  // namespace

void warn_of_cement(LAMMPS* lmp, const std::string& who, Cement& c) {
  std::set<std::string> told;  // materials may have equal numbers
  for (int n = 0; n < c.law().materials(); ++n) {
    const Law& law = c.law().of_material(n);
    for (const std::string& text : unlike_solids(law, law.density() > 0.0 ? law.density() : c.density(), lmp->update->unit_style))
      if (told.insert(text).second) mpdem::warn(lmp, who + text);
  }
  for (const std::string& text : unlike_grains(c.bonds().table, lmp->update->unit_style)) mpdem::warn(lmp, who + text);
  warn_of_averages(lmp, who, c);
  warn_of_scatter(lmp, who, c);
}

}  // namespace mpdem
