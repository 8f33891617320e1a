#include "optimizers/blocking_solver.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>

#include "tests/optimizers/problems.h"

namespace powdercal {
namespace {

using Channel = BlockingSolver::Channel;

BlockingSolver::Request At(double x) { return {.point = Scalar(x), .origin = "test"}; }

BlockingSolver::Answer Value(double value) { return {.values = Scalar(value), .variances = {}}; }

// Twice the sum of what it is told of 1, 2, 3 goes into a second batch.
void AskTwice(Channel& channel, double* result) {
  const auto first = channel.Evaluate({At(1), At(2), At(3)});
  if (!first) return;
  double sum = 0;
  for (const BlockingSolver::Answer& answer : *first) sum = 10 * sum + answer.values[0];
  const auto second = channel.Evaluate({At(2 * sum)});
  if (second) *result = (*second)[0].failed ? -1 : (*second)[0].values[0];
}

TEST(BlockingSolverTest, AnswersAreInTheOrderOfTheRequestsHoweverTheyCome) {
  double result = 0;
  BlockingSolver solver([&](Channel& channel) { AskTwice(channel, &result); });
  std::vector<BlockingSolver::Ticket> tickets;
  while (auto ticket = solver.Take()) tickets.push_back(*ticket);
  ASSERT_EQ(tickets.size(), 3);
  EXPECT_EQ(tickets[2].number, 2);
  EXPECT_EQ(tickets[2].request.point, Scalar(3));
  EXPECT_FALSE(solver.ready());
  EXPECT_FALSE(solver.finished());
  solver.Give(2, Value(3));
  solver.Give(0, Value(1));
  EXPECT_FALSE(solver.Take());
  solver.Give(1, Value(2));
  ASSERT_TRUE(solver.ready());
  const auto last = solver.Take();
  EXPECT_EQ(last->number, 3);
  EXPECT_EQ(last->request.point, Scalar(246));
  solver.Give(3, Value(7));
  EXPECT_TRUE(solver.finished());
  EXPECT_FALSE(solver.ready());
  EXPECT_EQ(result, 7);
}

TEST(BlockingSolverTest, FailuresArrive) {
  double result = 0;
  BlockingSolver solver([&](Channel& channel) { AskTwice(channel, &result); });
  for (double i = 1; auto ticket = solver.Take(); ++i) {
    if (i > 3) break;
    solver.Give(ticket->number, Value(i));
  }
  solver.Give(3, {.failed = true, .values = {}, .variances = {}});
  EXPECT_EQ(result, -1);
}

TEST(BlockingSolverTest, IgnoresAnswersThatNobodyWaitsFor) {
  double result = 0;
  BlockingSolver solver([&](Channel& channel) { AskTwice(channel, &result); });
  for (int i = 0; i < 3; ++i) solver.Give(i, Value(9));  // not taken yet
  for (int i = 0; i < 3; ++i) solver.Take();
  solver.Give(0, Value(1));
  solver.Give(0, Value(5));
  solver.Give(-1, Value(5));
  solver.Give(17, Value(5));
  solver.Give(1, Value(2));
  solver.Give(2, Value(3));
  EXPECT_EQ(solver.Take()->request.point, Scalar(246));
}

TEST(BlockingSolverTest, DestructionEndsTheAlgorithmAtAnyMoment) {
  for (int given = 0; given <= 4; ++given) {
    std::atomic<bool> returned = false;
    double result = 0;
    {
      BlockingSolver solver([&](Channel& channel) {
        AskTwice(channel, &result);
        // Whatever an algorithm still asks once it is cancelled is refused at once.
        if (channel.cancelled()) {
          EXPECT_FALSE(channel.Evaluate({At(0)}));
        }
        returned = true;
      });
      for (int i = 0; i < given; ++i) {
        if (const auto ticket = solver.Take()) solver.Give(ticket->number, Value(1));
      }
    }
    EXPECT_TRUE(returned) << given;
    EXPECT_EQ(result, given == 4 ? 1 : 0);
  }
}

TEST(BlockingSolverTest, WhatTheAlgorithmThrowsReachesTheOwnerOnce) {
  EXPECT_THROW(BlockingSolver([](Channel&) { throw std::runtime_error("at once"); }),
               std::runtime_error);
  BlockingSolver solver([](Channel& channel) {
    channel.Evaluate({At(1)});
    throw std::runtime_error("later");
  });
  solver.Take();
  EXPECT_THROW(solver.Give(0, Value(1)), std::runtime_error);
  EXPECT_TRUE(solver.finished());
  EXPECT_NO_THROW(solver.Give(0, Value(1)));
}

TEST(BlockingSolverTest, AnAlgorithmThatAsksNothingHasFinished) {
  const BlockingSolver solver([](Channel&) {});
  EXPECT_TRUE(solver.finished());
}

}  // namespace
}  // namespace powdercal
