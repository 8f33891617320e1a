#pragma once

#include <Eigen/Core>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace powdercal {

/// An algorithm that calls its function and waits for the value, turned into ask and tell: it runs
/// in a thread of its own, which blocks in Channel::Evaluate until the values have been given.
///
///   BlockingSolver(algorithm) → { Take, Give }* until finished()
///
/// Thread and owner take turns: the constructor and Give return only when the algorithm is blocked
/// in Evaluate, or has ended. So what the algorithm does is a function of the values given, never
/// of timing, and the algorithm may use what its owner holds, without further locks.
class BlockingSolver {
 public:
  struct Request {
    Eigen::VectorXd point;
    std::string origin;  ///< for people: "stencil of rolling_friction"
  };
  struct Answer {
    bool failed = false;
    Eigen::VectorXd values;     ///< when not failed
    Eigen::VectorXd variances;  ///< of the values; empty: unknown
  };
  /// A request with the number under which its answer is to be given: 0, 1, 2, …
  struct Ticket {
    std::int64_t number = 0;
    Request request;
  };

  /// The algorithm's end.
  class Channel {
   public:
    /// Asks for a batch (not empty) and blocks until all of it has been answered; answers are in
    /// the order of the requests. Empty once the solver is being destroyed: the algorithm is then
    /// to return as soon as it can.
    std::optional<std::vector<Answer>> Evaluate(std::vector<Request> batch);
    bool cancelled() const;

   private:
    friend class BlockingSolver;
    explicit Channel(BlockingSolver* solver) : solver_(solver) {}
    BlockingSolver* solver_;
  };
  using Algorithm = std::function<void(Channel& channel)>;

  /// Runs the algorithm until it asks for its first batch. What the algorithm throws leaves the
  /// constructor or Give, once; the solver has finished then.
  explicit BlockingSolver(Algorithm algorithm);
  /// Cancels and waits for the algorithm to return.
  ~BlockingSolver();
  BlockingSolver(const BlockingSolver&) = delete;
  BlockingSolver& operator=(const BlockingSolver&) = delete;

  /// The next request of the batch; empty: all are taken, or the algorithm has finished.
  std::optional<Ticket> Take();
  /// In any order. Numbers that were not taken, or are answered already, are ignored.
  void Give(std::int64_t number, Answer answer);

  bool ready() const;  ///< Take will give a request
  bool finished() const;

 private:
  void RunUntilBlocked(std::unique_lock<std::mutex>* lock);

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool running_ = true;  // the algorithm's turn
  bool finished_ = false;
  bool cancelled_ = false;
  std::exception_ptr error_;
  std::vector<Request> batch_;
  std::vector<std::optional<Answer>> answers_;
  std::int64_t first_ = 0;  // number of the batch's first request
  std::size_t taken_ = 0;
  std::size_t answered_ = 0;
  std::thread thread_;
};

}  // namespace powdercal
