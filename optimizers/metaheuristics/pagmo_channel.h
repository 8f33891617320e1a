#pragma once

#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace powdercal {

/// Passes batches of points from an algorithm that calls for values, in a thread of its own, to a
/// loop that asks for points and tells values, one batch at a time:
///
///   algorithm's thread           the other one
///   Evaluate(points) ──────────▶ Receive() → points
///         values     ◀────────── Send(values)
///   End(reason)      ──────────▶ Receive() → nothing
///        Closed      ◀────────── Close()
class PagmoChannel {
 public:
  /// Thrown out of Evaluate when the channel is closed: the algorithm is to end. Deliberately no
  /// std::exception, which algorithms might catch.
  struct Closed {};

  /// Algorithm: blocks until the values are there.
  std::vector<double> Evaluate(std::vector<double> points);
  /// Algorithm: no batch will follow.
  void End(std::string reason);

  /// Blocks until a batch or the end is there; nothing: the end.
  std::optional<std::vector<double>> Receive();
  /// Values of the batch received.
  void Send(std::vector<double> values);
  /// Lets Evaluate throw, now and from now on. At any moment, any number of times.
  void Close();

  /// After Receive gave nothing.
  const std::string& reason() const { return reason_; }

 private:
  enum class State { computing, asked, received, answered, ended };

  std::mutex mutex_;
  std::condition_variable changed_;
  State state_ = State::computing;
  bool closed_ = false;
  std::vector<double> payload_;  // points when asked, values when answered
  std::string reason_;
};

}  // namespace powdercal
