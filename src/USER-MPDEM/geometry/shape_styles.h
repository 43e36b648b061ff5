// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
//
// Table of the shapes that a script can name: name, options, factory. A new shape has one file in this folder with its
// class and a function NAME_style(), and one line in the table of shape_styles.cpp. Readers of scripts take options,
// ranges, defaults and messages from this table.
#ifndef MPDEM_GEOMETRY_SHAPE_STYLES_H
#define MPDEM_GEOMETRY_SHAPE_STYLES_H

#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "shape.h"

namespace mpdem {

constexpr double kDegree = M_PI / 180.0;  // scripts give angles in degrees

// An option of a shape that a number follows.
struct ShapeOption {
  enum Role { size, detail };  // exactly one of the sizes and `content` is given; a detail has a default
  enum Range { positive, not_negative };
  std::string name;
  Role role = size;
  double otherwise = 0.0;  // default of a detail
  Range range = positive;
};

// The data from which a shape is made.
struct ShapeRequest {
  const GrainPair& pair;
  double inner;                                 // inner radius
  double volume;                                // volume outside `inner`, if `content` was given
  const std::map<std::string, double>& values;  // values of all details and of the size that was given

  bool has(const std::string& word) const { return values.count(word) != 0; }
  double operator[](const std::string& word) const { return values.at(word); }
};

struct ShapeStyle {
  std::string name;
  std::vector<ShapeOption> words;                               // options besides `content`, which every shape has
  std::unique_ptr<Shape> (*make)(const ShapeRequest& request);  // throws ShapeError

  const ShapeOption* word(const std::string& key) const;  // null if it has no option of that name
};

// All styles, in the order of the table.
const std::vector<ShapeStyle>& shape_styles();
// Style of this name; null if there is none.
const ShapeStyle* shape_style(const std::string& name);

// One `shape` of a script: its style, and the values of the given options (`content` among them).
struct ShapeWords {
  const ShapeStyle* style = nullptr;
  std::map<std::string, double> given;
};

// volume: volume of the cement, used if `content` is given. Throws ShapeError, also if not exactly one size is given.
std::unique_ptr<Shape> make_shape(const ShapeWords& words, const GrainPair& pair, double volume, double inner);

}  // namespace mpdem

#endif
