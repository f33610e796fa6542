#include "solver/forked_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <new>
#include <string>
#include <vector>

#include "tests/sanitizer_util.h"

namespace darboux {
namespace {

// AddressSanitizer keeps a byte for every eight.
constexpr double kBytesPerByte = kAddressSanitizer ? 1.125 : 1.0;

using Status = ForkedOutcome::Status;

TEST(ForkedRunTest, BringsBackWhatTheWorkReturns) {
  // More than a pipe holds.
  const std::string text(1 << 20, 'x');
  const ForkedOutcome outcome = RunForked([&] { return text; }, 0.0, nullptr);
  EXPECT_EQ(outcome.status, Status::kDone) << outcome.message;
  EXPECT_EQ(outcome.output, text);
}

TEST(ForkedRunTest, WhatTheWorkChangesStaysInItsProcess) {
  int value = 1;
  const ForkedOutcome outcome = RunForked([&] { return std::to_string(++value); }, 0.0, nullptr);
  EXPECT_EQ(outcome.output, "2");
  EXPECT_EQ(value, 1);
}

TEST(ForkedRunTest, ACrashIsAnOutcome) {
  const ForkedOutcome killed = RunForked(
      [] {
        raise(SIGKILL);
        return std::string();
      },
      0.0,
      nullptr);
  EXPECT_EQ(killed.status, Status::kCrashed);
  EXPECT_THAT(killed.message, ::testing::HasSubstr("signal"));
  const ForkedOutcome thrown =
      RunForked([]() -> std::string { throw std::bad_alloc(); }, 0.0, nullptr);
  EXPECT_EQ(thrown.status, Status::kCrashed);
  EXPECT_EQ(thrown.message, "out of memory");
}

TEST(ForkedRunTest, TellsThePeakOfMemory) {
  const auto work_with = [](size_t megabytes) {
    return [megabytes] {
      std::vector<char> block(megabytes << 20, 1);
      volatile char* const touched = block.data();
      size_t sum = 0;
      for (size_t i = 0; i < block.size(); i += 4096) sum += static_cast<size_t>(touched[i]);
      return std::to_string(sum);
    };
  };
  const ForkedOutcome little = RunForked(work_with(1), 0.0, nullptr);
  const ForkedOutcome much = RunForked(work_with(101), 0.0, nullptr);
  EXPECT_GT(little.memory_mb, 0.0);
  EXPECT_NEAR(much.memory_mb - little.memory_mb, 100.0 * kBytesPerByte, 10.0);
}

TEST(ForkedRunTest, EndsAtTheLimitAndWhenStopped) {
  const auto endless = [] {
    while (true) pause();
    return std::string();
  };
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(RunForked(endless, 0.2, nullptr).status, Status::kTimeLimit);
  const std::atomic<bool> stop(true);
  EXPECT_EQ(RunForked(endless, 0.0, &stop).status, Status::kStopped);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  EXPECT_LT(seconds.count(), 30.0);
}

}  // namespace
}  // namespace darboux
