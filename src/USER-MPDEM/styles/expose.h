// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Members of LIGGGHTS' classes that have no accessor, without changing its headers: the arguments of an
// explicit template instantiation may name private members ([temp.spec]).
// In namespace mpdem, where the functions `member` are:
//   struct Tag { using Type = int Class::*; friend Type member(Tag); };
//   template struct Expose<Tag, &Class::name>;      then   object->*member(Tag{})
#ifndef MPDEM_EXPOSE_H
#define MPDEM_EXPOSE_H

namespace mpdem {

template <class Tag, typename Tag::Type Member>
struct Expose {
  friend typename Tag::Type member(Tag) { return Member; }
};

}  // namespace mpdem

#endif
