// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Transfer of velocity from the grid to the points and back. With S the interpolation from nodes to points, S+ the
// mass-weighted projection back and a the nodal acceleration, the velocity V of the points becomes
//   flip A      A (V + dt S a) + (1 - A) S (v + dt a)                 (Brackbill & Ruppel 1986)
//   apic        S (v + dt a), with an affine velocity field in each point    (Jiang et al. 2015)
//   xpic m      S (q v + dt a), where 1 - (1 - S+S)^m = S+S q(S+S)   (Hammerquist & Nairn 2017)
// xpic 1 is pic, S (v + dt a). All conserve momentum. apic also conserves angular momentum.
#ifndef MPDEM_MPM_TRANSFER_H
#define MPDEM_MPM_TRANSFER_H

namespace mpdem {

struct Transfer {
  enum Method { flip, apic, xpic } method = apic;
  double flip_share = 1.0;  // A in [0, 1]
  int order = 2;            // m, at least 1
};

}  // namespace mpdem

#endif
