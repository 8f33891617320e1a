#include "optimizers/metaheuristics/pagmo_channel.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

namespace powdercal {
namespace {

using testing::ElementsAre;

TEST(PagmoChannelTest, BatchesGoThereAndBackInOrder) {
  PagmoChannel channel;
  std::vector<double> first;
  std::vector<double> second;
  std::thread algorithm([&] {
    first = channel.Evaluate({1, 2});
    second = channel.Evaluate({first[0]});
    channel.End("enough");
  });
  EXPECT_THAT(channel.Receive().value(), ElementsAre(1, 2));
  channel.Send({10, 20});
  EXPECT_THAT(channel.Receive().value(), ElementsAre(10));
  channel.Send({30});
  EXPECT_FALSE(channel.Receive().has_value());
  EXPECT_FALSE(channel.Receive().has_value());
  EXPECT_EQ(channel.reason(), "enough");
  algorithm.join();
  EXPECT_THAT(first, ElementsAre(10, 20));
  EXPECT_THAT(second, ElementsAre(30));
}

TEST(PagmoChannelTest, ClosingEndsAnAlgorithmThatWaits) {
  PagmoChannel channel;
  bool closed = false;
  std::thread algorithm([&] {
    try {
      channel.Evaluate({1});
    } catch (const PagmoChannel::Closed&) {
      closed = true;
    }
  });
  EXPECT_TRUE(channel.Receive().has_value());
  channel.Close();
  algorithm.join();
  EXPECT_TRUE(closed);
}

TEST(PagmoChannelTest, ClosingEndsAnAlgorithmThatHasNotAskedYet) {
  PagmoChannel channel;
  channel.Close();
  channel.Close();
  EXPECT_THROW(channel.Evaluate({1}), PagmoChannel::Closed);
}

TEST(PagmoChannelTest, ValuesSentBeforeClosingAreTooLate) {
  PagmoChannel channel;
  std::thread algorithm([&] {
    try {
      for (;;) channel.Evaluate({1});
    } catch (const PagmoChannel::Closed&) {
      channel.End("closed");
    }
  });
  EXPECT_TRUE(channel.Receive().has_value());
  channel.Send({2});
  channel.Close();
  algorithm.join();
  // A batch may have been asked for in between; it is not the end that hangs.
  EXPECT_FALSE(channel.Receive().has_value());
}

}  // namespace
}  // namespace powdercal
