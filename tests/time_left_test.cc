#include "solver/time_left.h"

#include <gtest/gtest.h>

#include <cmath>

namespace darboux {
namespace {

constexpr double kTolerance = 1e-7;

IterationReport Report(int total, double seconds, double load_factor, double gradient) {
  IterationReport report;
  report.total = total;
  report.seconds = seconds;
  report.load_factor = load_factor;
  report.relative_gradient = gradient;
  return report;
}

TEST(TimeLeftTest, LoadStepsThatTakeAlikeAreForeseen) {
  // Ten steps of 2 s, of four iterations each.
  TimeLeft time_left(kTolerance);
  int total = 0;
  for (int step = 0; step < 10; ++step) {
    for (int iteration = 0; iteration <= 4; ++iteration, ++total) {
      const double seconds = 2.0 * (step + 0.25 * iteration);
      const std::optional<double> left = time_left.Update(
          Report(total, seconds, 0.1 * (step + 1), std::pow(kTolerance, 0.25 * iteration)));
      if (seconds < 3.0) continue;
      ASSERT_TRUE(left);
      EXPECT_NEAR(*left, 20.0 - seconds, 0.2 * (20.0 - seconds) + 0.1) << step;
    }
  }
  EXPECT_NEAR(time_left.part(), 1.0, 1e-12);
}

TEST(TimeLeftTest, NothingIsSaidAtTheBeginning) {
  TimeLeft time_left(kTolerance);
  EXPECT_FALSE(time_left.Update(Report(0, 0.5, 1.0, 1.0)));
  EXPECT_FALSE(time_left.Update(Report(1, 5.0, 1.0, 1.0)));  // nothing gained
  EXPECT_TRUE(time_left.Update(Report(2, 6.0, 1.0, 1e-3)));
}

TEST(TimeLeftTest, CutStepsAndRisingGradientsLeaveThePartAsItWas) {
  TimeLeft time_left(kTolerance);
  time_left.Update(Report(0, 1.0, 0.5, 1.0));
  time_left.Update(Report(1, 2.0, 0.5, 1e-8));
  time_left.Update(Report(2, 3.0, 1.0, 1.0));
  const double part = time_left.part();
  EXPECT_NEAR(part, 0.5, 1e-12);
  time_left.Update(Report(3, 4.0, 1.0, 50.0));
  EXPECT_EQ(time_left.part(), part);
  time_left.Update(Report(4, 5.0, 0.625, 1.0));  // the step was cut
  EXPECT_EQ(time_left.part(), part);
  time_left.Update(Report(5, 6.0, 0.625, 1e-8));
  EXPECT_NEAR(time_left.part(), 0.625, 1e-12);
}

TEST(TimeLeftTest, AlongAPathStepsCount) {
  TimeLeft time_left(kTolerance);
  IterationReport report = Report(0, 4.0, 2.5, 1.0);  // beyond full load
  report.method = IterationReport::Method::kPath;
  report.steps = 20;
  report.step = 6;
  const std::optional<double> left = time_left.Update(report);
  ASSERT_TRUE(left);
  EXPECT_NEAR(*left, 12.0, 1e-9);
}

TEST(TimeLeftTest, AnotherSolveBeginsAnew) {
  TimeLeft time_left(kTolerance);
  time_left.Update(Report(0, 1.0, 1.0, 1.0));
  time_left.Update(Report(1, 2.0, 1.0, 1e-8));
  EXPECT_EQ(time_left.part(), 1.0);
  EXPECT_FALSE(time_left.Update(Report(0, 0.1, 1.0, 1.0)));
  EXPECT_EQ(time_left.part(), 0.0);
}

}  // namespace
}  // namespace darboux
