// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// The arguments of an explicit template instantiation may name private members ([temp.spec]). Each instantiation below
// defines a function that returns a pointer to one member.
#include "private_access.h"

#include <algorithm>

#include "comm.h"
#include "dump.h"
#include "fix_gravity.h"
#include "fix_move.h"
#include "fix_setforce.h"
#include "input.h"
#include "modify.h"
#include "output.h"
#include "pair_gran_proxy.h"
#include "variable.h"

namespace mpdem {

using namespace LAMMPS_NS;

template <class Tag, typename Tag::Type Member>
struct Expose {
  friend typename Tag::Type pointer(Tag) { return Member; }
};

#define MPDEM_EXPOSE(CLASS, TYPE, MEMBER)  \
  struct CLASS##_##MEMBER {                \
    using Type = TYPE CLASS::*;            \
    friend Type pointer(CLASS##_##MEMBER); \
  };                                       \
  template struct Expose<CLASS##_##MEMBER, &CLASS::MEMBER>;

MPDEM_EXPOSE(Modify, FixStyles*, fix_map)
MPDEM_EXPOSE(Modify, ComputeStyles*, compute_map)
MPDEM_EXPOSE(Modify, int*, list_pre_exchange)
MPDEM_EXPOSE(Modify, int*, list_initial_integrate)
MPDEM_EXPOSE(Modify, int*, list_pre_final_integrate)
MPDEM_EXPOSE(Modify, int*, list_final_integrate)
MPDEM_EXPOSE(Variable, char***, data)
MPDEM_EXPOSE(Input, CommandStyles*, command_map)
MPDEM_EXPOSE(Dump, char*, filename)
MPDEM_EXPOSE(Comm, int, bordergroup)
MPDEM_EXPOSE(Output, bool, restart_flag)
MPDEM_EXPOSE(Output, bigint, next_restart_single)
MPDEM_EXPOSE(Output, bigint, next_restart_double)
MPDEM_EXPOSE(PairGranProxy, ContactModel*, impl)
MPDEM_EXPOSE(FixMove, int, mstyle)
MPDEM_EXPOSE(FixMove, int, vxflag)
MPDEM_EXPOSE(FixMove, int, vyflag)
MPDEM_EXPOSE(FixMove, int, vzflag)
MPDEM_EXPOSE(FixMove, int, axflag)
MPDEM_EXPOSE(FixMove, int, ayflag)
MPDEM_EXPOSE(FixMove, int, azflag)
MPDEM_EXPOSE(FixMove, char*, xvarstr)
MPDEM_EXPOSE(FixMove, char*, yvarstr)
MPDEM_EXPOSE(FixMove, char*, zvarstr)
MPDEM_EXPOSE(FixMove, char*, vxvarstr)
MPDEM_EXPOSE(FixMove, char*, vyvarstr)
MPDEM_EXPOSE(FixMove, char*, vzvarstr)
MPDEM_EXPOSE(FixGravity, char*, mstr)
MPDEM_EXPOSE(FixGravity, char*, vstr)
MPDEM_EXPOSE(FixGravity, char*, pstr)
MPDEM_EXPOSE(FixGravity, char*, tstr)
MPDEM_EXPOSE(FixGravity, char*, xstr)
MPDEM_EXPOSE(FixGravity, char*, ystr)
MPDEM_EXPOSE(FixGravity, char*, zstr)
MPDEM_EXPOSE(FixSetForce, int, xstyle)
MPDEM_EXPOSE(FixSetForce, int, ystyle)
MPDEM_EXPOSE(FixSetForce, int, zstyle)
MPDEM_EXPOSE(FixSetForce, int, iregion)
MPDEM_EXPOSE(FixSetForce, char*, xstr)
MPDEM_EXPOSE(FixSetForce, char*, ystr)
MPDEM_EXPOSE(FixSetForce, char*, zstr)
#undef MPDEM_EXPOSE

FixStyles& fix_styles(Modify* modify) { return *(modify->*pointer(Modify_fix_map())); }
ComputeStyles& compute_styles(Modify* modify) { return *(modify->*pointer(Modify_compute_map())); }
CommandStyles& command_styles(Input* input) { return *(input->*pointer(Input_command_map())); }

const char* file_of(const Dump* dump) { return dump->*pointer(Dump_filename()); }

ContactModel*& model_of(PairGranProxy* contacts) { return contacts->*pointer(PairGranProxy_impl()); }

int ghost_group(const Comm* comm) { return comm->*pointer(Comm_bordergroup()); }

RestartSchedule restart_schedule(Output* o) {
  return {o->*pointer(Output_restart_flag()), o->*pointer(Output_next_restart_single()), o->*pointer(Output_next_restart_double())};
}

MoveMembers members_of(const FixMove* m) {
  return {m->*pointer(FixMove_mstyle()),
          {m->*pointer(FixMove_vxflag()), m->*pointer(FixMove_vyflag()), m->*pointer(FixMove_vzflag())},
          {m->*pointer(FixMove_axflag()), m->*pointer(FixMove_ayflag()), m->*pointer(FixMove_azflag())},
          {m->*pointer(FixMove_xvarstr()), m->*pointer(FixMove_yvarstr()), m->*pointer(FixMove_zvarstr())},
          {m->*pointer(FixMove_vxvarstr()), m->*pointer(FixMove_vyvarstr()), m->*pointer(FixMove_vzvarstr())}};
}

SetForceMembers members_of(const FixSetForce* f) {
  return {{f->*pointer(FixSetForce_xstyle()), f->*pointer(FixSetForce_ystyle()), f->*pointer(FixSetForce_zstyle())},
          {f->*pointer(FixSetForce_xstr()), f->*pointer(FixSetForce_ystr()), f->*pointer(FixSetForce_zstr())},
          f->*pointer(FixSetForce_iregion()) >= 0};
}

bool is_variable(const FixGravity* g) {
  return g->*pointer(FixGravity_mstr()) || g->*pointer(FixGravity_vstr()) || g->*pointer(FixGravity_pstr()) ||
         g->*pointer(FixGravity_tstr()) || g->*pointer(FixGravity_xstr()) || g->*pointer(FixGravity_ystr()) ||
         g->*pointer(FixGravity_zstr());
}

const char* formula_of(Variable* variables, int place) { return (variables->*pointer(Variable_data()))[place][0]; }

namespace {
void move_to_the_end(Modify* modify, const Fix* fix, int* list, int count) {
  const auto at = std::find_if(list, list + count, [&](int i) { return modify->fix[i] == fix; });
  if (at != list + count) std::rotate(at, at + 1, list + count);
}
}  // namespace

void act_last(Modify* modify, const Fix* fix) {
  move_to_the_end(modify, fix, modify->*pointer(Modify_list_initial_integrate()), modify->n_initial_integrate);
  move_to_the_end(modify, fix, modify->*pointer(Modify_list_pre_final_integrate()), modify->n_pre_final_integrate);
  move_to_the_end(modify, fix, modify->*pointer(Modify_list_final_integrate()), modify->n_final_integrate);
}

void exchange_last(Modify* modify, const Fix* fix) {
  move_to_the_end(modify, fix, modify->*pointer(Modify_list_pre_exchange()), modify->n_pre_exchange);
}

}  // namespace mpdem
