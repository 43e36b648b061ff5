// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "shape_styles.h"

#include <algorithm>

// The table has a line for each shape. shape(NAME) is `shape NAME` of a script, and NAME_style() is in the file of the
// shape.
// clang-format off
#define MPDEM_SHAPES(shape) \
  shape(flat)               \
  shape(meniscus)           \
  shape(coating)            \
  shape(hourglass)
// clang-format on

namespace mpdem {

#define MPDEM_DECLARE(name) ShapeStyle name##_style();
MPDEM_SHAPES(MPDEM_DECLARE)
#undef MPDEM_DECLARE

const std::vector<ShapeStyle>& shape_styles() {
#define MPDEM_ENTRY(name) name##_style(),
  static const std::vector<ShapeStyle> all = {MPDEM_SHAPES(MPDEM_ENTRY)};
#undef MPDEM_ENTRY
  return all;
}

const ShapeStyle* shape_style(const std::string& name) {
  for (const ShapeStyle& s : shape_styles())
    if (s.name == name) return &s;
  return nullptr;
}

const ShapeOption* ShapeStyle::word(const std::string& key) const {
  const auto found = std::find_if(words.begin(), words.end(), [&](const ShapeOption& w) { return w.name == key; });
  return found == words.end() ? nullptr : &*found;
}

std::unique_ptr<Shape> make_shape(const ShapeWords& words, const GrainPair& pair, double volume, double inner) {
  std::map<std::string, double> values = words.given;
  std::string sizes;
  std::size_t count = values.count("content");
  for (const ShapeOption& w : words.style->words) {
    if (w.role == ShapeOption::detail) {
      values.emplace(w.name, w.otherwise);
      continue;
    }
    sizes += "'" + w.name + "' or ";
    count += values.count(w.name);
  }
  if (count != 1)
    throw ShapeError("'shape " + words.style->name + "' " + (count == 0 ? "" : "has " + std::to_string(count) + " sizes and ") +
                     "needs one of " + sizes + "'content' to give its size");
  return words.style->make({pair, inner, volume, values});
}

}  // namespace mpdem
