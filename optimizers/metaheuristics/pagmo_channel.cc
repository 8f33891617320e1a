#include "optimizers/metaheuristics/pagmo_channel.h"

#include <utility>

namespace powdercal {

std::vector<double> PagmoChannel::Evaluate(std::vector<double> points) {
  std::unique_lock lock(mutex_);
  if (closed_) throw Closed{};
  payload_ = std::move(points);
  state_ = State::asked;
  changed_.notify_all();
  changed_.wait(lock, [&] { return closed_ || state_ == State::answered; });
  if (closed_) throw Closed{};
  state_ = State::computing;
  return std::move(payload_);
}

void PagmoChannel::End(std::string reason) {
  const std::lock_guard lock(mutex_);
  reason_ = std::move(reason);
  state_ = State::ended;
  changed_.notify_all();
}

std::optional<std::vector<double>> PagmoChannel::Receive() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return state_ == State::asked || state_ == State::ended; });
  if (state_ == State::ended) return std::nullopt;
  state_ = State::received;
  return std::move(payload_);
}

void PagmoChannel::Send(std::vector<double> values) {
  const std::lock_guard lock(mutex_);
  payload_ = std::move(values);
  state_ = State::answered;
  changed_.notify_all();
}

void PagmoChannel::Close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  changed_.notify_all();
}

}  // namespace powdercal
