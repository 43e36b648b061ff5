// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "geometry/shape_styles.h"

#include <set>

#include "bodies.h"

namespace mpdem {
namespace {

const GrainPair kBeads{5e-3, 5e-3, 0.0, test::Vector(0, 0, 1)};

TEST(ShapeStyles, NamesAndWordsAreThereOnce) {
  std::set<std::string> names;
  for (const ShapeStyle& s : shape_styles()) {
    EXPECT_TRUE(names.insert(s.name).second) << s.name;
    EXPECT_EQ(shape_style(s.name), &s);
    std::set<std::string> words = {"content", "shape", "file", "attach", "inner", "spacing", "density", "type", "grid", "overlap"};
    int sizes = 0;
    for (const ShapeOption& w : s.words) {
      EXPECT_TRUE(words.insert(w.name).second) << s.name << " " << w.name;
      EXPECT_EQ(s.word(w.name), &w);
      sizes += w.role == ShapeOption::size;
    }
    EXPECT_GT(sizes, 0) << s.name;
    EXPECT_EQ(s.word("content"), nullptr);
  }
  for (const char* name : {"flat", "meniscus", "coating"}) EXPECT_EQ(names.count(name), 1u) << name;
  EXPECT_EQ(shape_style("disc"), nullptr);
}

// Whatever is in the table: of a content it has that volume, it names itself, and its volume is that of its outline.
TEST(ShapeStyles, EveryShapeIsMadeOfItsContent) {
  for (const ShapeStyle& s : shape_styles())
    for (double inner : {0.0, 5e-4}) {
      const double volume = test::volume_of_content(0.04, 5e-3);
      const std::unique_ptr<Shape> shape = make_shape({&s, {{"content", 0.04}}}, kBeads, volume, inner);
      EXPECT_NEAR(shape->volume() / volume, 1.0, 1e-10) << s.name;
      EXPECT_NEAR(volume_by_quadrature(*shape) / volume, 1.0, 1e-10) << s.name;
      EXPECT_EQ(shape->describe().rfind(s.name, 0), 0u) << shape->describe();
      EXPECT_EQ(shape->inner(), inner);
    }
}

TEST(ShapeStyles, OneSizeIsNeeded) {
  for (const ShapeStyle& s : shape_styles()) {
    std::map<std::string, double> all = {{"content", 0.02}};
    const auto error = [&](const std::map<std::string, double>& given) {
      return test::shape_error([&] { make_shape({&s, given}, kBeads, 1e-8, 0.0); });
    };
    for (const ShapeOption& w : s.words) {
      if (w.role == ShapeOption::detail) {
        EXPECT_NE(error({{w.name, 1.0}}).find("needs one of"), std::string::npos) << s.name;
        continue;
      }
      all[w.name] = 1e-3;
      EXPECT_NE(error({}).find("'" + w.name + "' or "), std::string::npos) << error({});
      EXPECT_NE(error({{"content", 0.02}, {w.name, 1e-3}}).find("needs one of"), std::string::npos) << s.name;
    }
    EXPECT_NE(error({}).find("'shape " + s.name + "' needs one of '"), std::string::npos) << error({});
    EXPECT_NE(error({}).find(" or 'content' to give its size"), std::string::npos) << error({});
    EXPECT_NE(error(all).find("needs one of"), std::string::npos) << s.name;
  }
}

}  // namespace
}  // namespace mpdem
