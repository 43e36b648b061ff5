// SPDX-License-Identifier: GPL-2.0-or-later
// Part of USER-MPDEM, a LIGGGHTS package for cemented grains.
#include "mpm/point_state.h"

#include <gtest/gtest.h>

#include <vector>

#include "material/laws.h"

namespace mpdem {
namespace {

constexpr double kWidth = 0.2;  // of a cell

// A store of `count` points without damage, all in one cell.
PointStore intact(int count) {
  PointStore s;
  for (int i = 0; i < count; ++i) {
    PointRecord r;
    r.volume = 1.0;
    for (double& x : r.X) x = 0.7 * kWidth;
    s.add(r, i + 1);
  }
  s.arrange(kWidth);
  return s;
}

TEST(PointState, TakesMemoryFromTheFirstDamageOn) {
  PointStore s = intact(20), whole = intact(20);
  const auto law = std::make_shared<TensorDamage>(VtiElasticity(VtiConstants::isotropic(1.0, 0.2)), DamageParameters());
  s.set_law(law);
  whole.set_law(law);
  EXPECT_TRUE(s.states().empty());
  EXPECT_EQ(s.record(3).damage[0], 0.0);
  const double none[6] = {}, numbers[6] = {0.1, 0.2, 0.3, 0.01, 0.02, 0.03};
  s.set_state(3, none);
  EXPECT_TRUE(s.states().empty());
  s.set_state(11, numbers);
  EXPECT_EQ(s.states().size(), 6 * s.blocks.size());
  EXPECT_EQ(s.memory_usage(), whole.memory_usage() + s.states().capacity() * sizeof(vd));
  for (int slot = 0; slot < 20; ++slot) {
    const PointRecord r = s.record(slot);
    for (int i = 0; i < 6; ++i) EXPECT_EQ(r.damage[i], slot == 11 ? numbers[i] : 0.0);
  }
  s.set_law(std::make_shared<NoDamage>(law->elasticity()));
  EXPECT_TRUE(s.states().empty());
}

TEST(PointState, MovesWithItsPoint) {
  PointStore s = intact(8);
  const double numbers[6] = {0.1, 0.2, 0.3, 0.01, 0.02, 0.03};
  s.set_state(5, numbers);
  PointStore hold;
  const int nowhere[3] = {0, 0, 0};
  hold.add_block(0, 0, nowhere, kWidth, Basis::quadratic);
  hold.take(s, 4, 0);
  EXPECT_TRUE(hold.states().empty());
  hold.take(s, 5, 1);
  s.empty_lane(5, kWidth, Basis::quadratic);
  EXPECT_EQ(s.record(5).damage[0], 0.0);
  EXPECT_EQ(hold.record(0).damage[0], 0.0);
  s.add_block(0, 0, nowhere, kWidth, Basis::quadratic);
  s.take(hold, 1, kLanes + 2);
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(hold.record(1).damage[i], numbers[i]);
    EXPECT_EQ(s.record(kLanes + 2).damage[i], numbers[i]);
  }
  EXPECT_TRUE(s.meta[1].damaged);
}

TEST(PointState, OfAFileIsTakenUpByTheLaw) {
  DamageParameters p;
  p.B0 = 1.0;
  p.Dcut = 0.7;
  const VtiElasticity elasticity(VtiConstants::isotropic(1.0, 0.2));
  const auto law = std::make_shared<TensorDamage>(elasticity, p);
  const auto none = std::make_shared<NoDamage>(elasticity);
  const auto with = [](double d, bool failed) {
    PointStore s = intact(3);
    const double numbers[6] = {0.0, d, 0.0, 0.0, 0.0, 0.0};
    s.set_state(2, numbers);
    s.meta[0].damaged = d != 0.0 || failed;
    s.meta[0].failed = failed ? 4 : 0;
    return s;
  };
  PointStore good = with(0.5, false), over = with(0.8, false), gone = with(0.8, true), whole = intact(3), failed = with(0.0, true);
  EXPECT_EQ(read_point_states(good, law), "");
  EXPECT_STREQ(good.law()->name(), "tensor");
  EXPECT_EQ(read_point_states(gone, law), "");
  EXPECT_EQ(read_point_states(whole, none), "");
  EXPECT_NE(read_point_states(over, law).find("point 3 has damage 0.8, above the cut-off 0.7; raise 'cutoff'"), std::string::npos);
  over = with(0.8, false);
  EXPECT_EQ(read_point_states(over, none), "material point 3 has damage 0.8, which needs a law of damage, 'damage tensor' for instance");
  EXPECT_EQ(read_point_states(failed, none),
            "material point 3 has damage 0, and has failed, which needs a law of damage, 'damage tensor' for instance");
  EXPECT_EQ(read_point_states(failed, law), "");
  for (PointStore* s : {&good, &failed}) {
    const std::string other = read_point_states(*s, none);
    EXPECT_NE(other.find("has a state of 'damage tensor', from which 'damage none' cannot go on"), std::string::npos) << other;
  }
  EXPECT_EQ(read_point_states(whole, law), "") << "nothing that 'damage none' would have left";
}

std::shared_ptr<const Law> mazars() {
  LawValues values;
  values.set("kappa0", 2.0);
  values.set("Bt", 0.5);
  return std::make_shared<MazarsDamage>(VtiElasticity(VtiConstants::isotropic(1.0, 0.2)), values);
}

// Another rank, or a program that reads a restart file, is told of which law the numbers are.
TEST(PointState, GoesFromStoreToStoreWithItsLaw) {
  PointStore from = intact(3);
  from.set_law(mazars());
  const double kappa[kMostStateFields] = {2.5};
  from.set_state(1, kappa);
  from.meta[0].damaged = true;
  PointRecord r = from.record(1);
  EXPECT_EQ(r.law, kLawNumber<MazarsDamage>);
  std::vector<double> packed(numbers_of(r));
  pack(r, packed.data());
  RecordReader in(packed.data(), packed.data() + packed.size());
  PointRecord back;
  in.read(back);
  EXPECT_EQ(in.trouble(), "");
  EXPECT_EQ(back.law, r.law);
  EXPECT_EQ(back.damage[0], 2.5);

  PointStore to;
  to.add(back, 7);
  to.arrange(kWidth);
  EXPECT_EQ(to.record(0).law, r.law);
  EXPECT_THROW(damage_tensor_of(to, 0), std::domain_error);
  const auto tensor = std::make_shared<TensorDamage>(mazars()->elasticity(), DamageParameters());
  EXPECT_NE(read_point_states(to, tensor).find("point 7 has a state of 'damage mazars', from which 'damage tensor' cannot go on"),
            std::string::npos);
  EXPECT_EQ(read_point_states(to, mazars()), "");
  EXPECT_EQ(to.record(0).damage[0], 2.5);
  EXPECT_EQ(to.state_fields(), MazarsDamage::kFields);
  EXPECT_EQ(damage_tensor_of(to, 0), damage_tensor_of(from, 1));
}

TEST(PointState, TensorWithOneComponentIsNoStateOfOneNumber) {
  PointStore s = intact(1);
  const double D[kMostStateFields] = {0.5};
  s.set_state(0, D);
  s.meta[0].damaged = true;
  EXPECT_NE(read_point_states(s, mazars()).find("not the same in all directions"), std::string::npos);
}

TEST(PointState, OfATensorHasComponentsUpToOne) {
  BondRecord record;
  record.spacing = record.volume = 1.0;
  PointRecord r;
  r.volume = 0.5;
  r.damage[1] = 1.5;
  for (int law : {0, kLawNumber<TensorDamage>}) {
    r.law = law;
    EXPECT_NE(trouble_of(r, {record}).find("its damage is 1.5"), std::string::npos) << law;
  }
  r.law = kLawNumber<MazarsDamage>;
  EXPECT_EQ(trouble_of(r, {record}), "");
  r.law = 100;
  EXPECT_NE(trouble_of(r, {record}).find("law of damage is 100"), std::string::npos);
}

}  // namespace
}  // namespace mpdem
