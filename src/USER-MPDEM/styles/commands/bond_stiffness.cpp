// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "bond_stiffness.h"

#include <mpi.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "../words/arguments.h"
#include "atom.h"
#include "../atoms/atom_vec_mpdem.h"
#include "comm.h"
#include "domain.h"
#include "../fixes/files_in_use.h"
#include "../fixes/fix_mpm.h"
#include "modify.h"
#include "../fixes/table_file.h"

namespace LAMMPS_NS {

using mpdem::Arguments;
using mpdem::text_of;

void BondStiffness::command(int narg, char** arg) {
  Arguments args(lmp, "bond_stiffness", narg, arg, 0);
  AtomVecMpdem* avec = AtomVecMpdem::of(lmp);
  if (!domain->box_exist) args.complain("the simulation box does not exist yet; use create_box or read_restart before");
  if (!avec) args.complain(text_of("atom style '", atom->atom_style, "' has no cement; use 'atom_style mpdem'"));
  const std::string name = args.word("a file name");
  if (!args.empty()) args.complain("'" + args.word("") + "' is one word too many; the form is 'bond_stiffness FILE'");
  if (avec->bonds.table.empty()) args.complain("there is no cement; use create_cement before");
  FixMpm* cement = FixMpm::of(*modify);
  if (!cement) args.complain("there is no fix mpm, which has the elasticity and the cell; define one before");
  lmp->init();
  if (!cement->is_coupled()) args.complain("there is no fix mpm/couple, so that the cement bonds nothing; define one before");
  const double start = MPI_Wtime();
  const std::vector<mpdem::StiffnessOfBond> bonds = cement->stiffness_of_bonds();
  mpdem::stop_if_any(lmp, comm->me == 0 ? write(name, bonds) : "");
  if (comm->me != 0) return;
  const auto solved = std::count_if(bonds.begin(), bonds.end(), [](const mpdem::StiffnessOfBond& b) { return b.products > 0.0; });
  double products = 0.0;
  for (const mpdem::StiffnessOfBond& b : bonds) products += b.products;
  mpdem::tell(lmp, text_of("bond_stiffness: ", bonds.size(), " bonds, ", solved, " solved, others are equal to one of these, ", products,
                           " products, ", MPI_Wtime() - start, " s", "\n"));
}

// Call it on the first rank. Returns an error message, or an empty text.
std::string BondStiffness::write(const std::string& name, const std::vector<mpdem::StiffnessOfBond>& bonds) const {
  const std::vector<mpdem::BondRecord>& table = AtomVecMpdem::of(lmp)->bonds.table;
  const std::string other = mpdem::writer_of(lmp, name, nullptr);
  if (!other.empty()) return text_of("bond_stiffness: file '", name, "' is written by ", other, "; name another");
  std::string text = "bond,grain1,grain2,tension,shear_min,shear_max,torsion,bending_min,bending_max,x,y,z,nx,ny,nz";
  for (int i = 0; i < 36; ++i) text += text_of(",k", i / 6 + 1, i % 6 + 1);
  text += "\n";
  for (std::size_t b = 0; b < bonds.size(); ++b) {
    const mpdem::StiffnessOfBond& s = bonds[b];
    const Eigen::Map<const mpdem::Matrix6> K(s.K);
    const mpdem::PrincipalStiffness p = mpdem::principal_stiffness(K, Eigen::Map<const Eigen::Vector3d>(s.axis));
    double x[3] = {s.middle[0], s.middle[1], s.middle[2]};
    domain->remap(x);
    mpdem::append(text, "%zu,%d,%d", b + 1, table[b].grain[0], table[b].grain[1]);
    for (double v : {p.tension, p.shear[0], p.shear[1], p.torsion, p.bending[0], p.bending[1]}) mpdem::append(text, ",%.12g", v);
    for (double v : {x[0], x[1], x[2], s.axis[0], s.axis[1], s.axis[2]}) mpdem::append(text, ",%.12g", v);
    for (double k : s.K) mpdem::append(text, ",%.12g", k);
    text += "\n";
  }
  std::FILE* f = std::fopen(name.c_str(), "w");
  if (!f) return text_of("bond_stiffness: file '", name, "' cannot be written: ", std::strerror(errno), "; check name and folder");
  const bool whole = std::fwrite(text.data(), 1, text.size(), f) == text.size();
  if (std::fclose(f) == 0 && whole) return "";
  return text_of("bond_stiffness: file '", name, "' could not be written whole: ", std::strerror(errno));
}

}  // namespace LAMMPS_NS
