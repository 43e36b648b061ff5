// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Keywords of create_cement for contents over contacts (cement/creation/contact_contents.h).
#ifndef MPDEM_STYLES_COMMANDS_CONTENT_WORDS_H
#define MPDEM_STYLES_COMMANDS_CONTENT_WORDS_H

#include <string>
#include <vector>

#include "../../cement/creation/cement_plan.h"
#include "../words/arguments.h"

namespace mpdem {

// The keywords besides `content`.
std::vector<std::string> content_words();
// Reads a distribution after `content`. Returns whether there is one.
bool read_spread(Arguments& args, ContentWish& wish);
// Reads the values of a keyword. Returns whether it is one of content_words().
bool read_content_word(const std::string& key, Arguments& args, ContentWish& wish);
// Stops if keywords do not go together, once all are read. Gives the shape its size by `calcite`. several: the command is
// for all contacts.
void check_contents(const Arguments& args, CementRequest& wish, bool several);

}  // namespace mpdem

#endif
