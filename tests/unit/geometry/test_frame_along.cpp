// SPDX-License-Identifier: GPL-2.0-or-later
#include <gtest/gtest.h>

#include "geometry/frame_along.h"

using Eigen::Vector3d;

TEST(FrameAlong, TakesZToTheAxisAroundTheirNormal) {
  for (const Vector3d& direction :
       {Vector3d(0, 0, 1), Vector3d(1, 0, 0), Vector3d(-3, 2, 0.5), Vector3d(1e-5, 0, -1), Vector3d(0, -1e-9, -1), Vector3d(0, 0, -1)}) {
    const Vector3d axis = direction.normalized();
    const Eigen::Quaterniond q = mpdem::frame_along(axis);
    EXPECT_NEAR(q.norm(), 1.0, 1e-14);
    EXPECT_LT((q * Vector3d::UnitZ() - axis).norm(), 4e-15) << direction.transpose();
    EXPECT_EQ(q.z(), 0.0);
  }
}
