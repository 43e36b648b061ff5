// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Memory in pages of 2 MiB. Many bonds take more pages of 4 KiB than the address cache of a processor (TLB) has entries. The
// misses take time in every step. doc/performance.md has the gain.
#ifndef MPDEM_PARALLEL_HUGE_PAGES_H
#define MPDEM_PARALLEL_HUGE_PAGES_H

namespace mpdem {

// Puts the heap of this process (`[heap]` in /proc/self/maps) into huge pages, as far as malloc() has taken it by now.
// Memory that malloc() mapped elsewhere is left out. Uses MADV_COLLAPSE of madvise(2), Linux 6.1 and later. If the
// system has no huge pages, or not enough of them, the rest stays as it is. The contents of the memory do not change.
void gather_into_huge_pages();

}  // namespace mpdem

#endif
