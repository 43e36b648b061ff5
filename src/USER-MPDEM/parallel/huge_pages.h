// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Memory in pages of 2 MiB. Points and nodes of many bonds lie in more pages of 4 KiB than a processor knows the places of, and
// looking these up takes time in every step. What it brings: doc/performance.md.
#ifndef MPDEM_HUGE_PAGES_H
#define MPDEM_HUGE_PAGES_H

namespace mpdem {

// Puts what this rank has from malloc() by now into huge pages (MADV_COLLAPSE of madvise(2), Linux 6.1 and later). Where the system has
// none, or not enough of them, the rest stays as it is. What the memory holds does not change.
void gather_into_huge_pages();

}  // namespace mpdem

#endif
