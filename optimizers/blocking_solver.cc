#include "optimizers/blocking_solver.h"

#include <stdexcept>
#include <utility>

namespace powdercal {

BlockingSolver::BlockingSolver(Algorithm algorithm) {
  thread_ = std::thread([this, run = std::move(algorithm)] {
    Channel channel(this);
    std::exception_ptr error;
    try {
      run(channel);
    } catch (...) {
      error = std::current_exception();
    }
    const std::lock_guard lock(mutex_);
    error_ = error;
    running_ = false;
    finished_ = true;
    changed_.notify_all();
  });
  std::unique_lock lock(mutex_);
  try {
    RunUntilBlocked(&lock);
  } catch (...) {
    lock.unlock();
    thread_.join();
    throw;
  }
}

BlockingSolver::~BlockingSolver() {
  {
    const std::lock_guard lock(mutex_);
    cancelled_ = true;
    changed_.notify_all();
  }
  thread_.join();
}

void BlockingSolver::RunUntilBlocked(std::unique_lock<std::mutex>* lock) {
  changed_.wait(*lock, [&] { return !running_; });
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

std::optional<BlockingSolver::Ticket> BlockingSolver::Take() {
  const std::lock_guard lock(mutex_);
  if (finished_ || taken_ == batch_.size()) return std::nullopt;
  const std::size_t index = taken_++;
  return Ticket{first_ + static_cast<std::int64_t>(index), batch_[index]};
}

void BlockingSolver::Give(std::int64_t number, Answer answer) {
  std::unique_lock lock(mutex_);
  const std::int64_t index = number - first_;
  if (finished_ || index < 0 || index >= static_cast<std::int64_t>(taken_)) return;
  std::optional<Answer>& slot = answers_[static_cast<std::size_t>(index)];
  if (slot) return;
  slot = std::move(answer);
  if (++answered_ < batch_.size()) return;
  running_ = true;
  changed_.notify_all();
  RunUntilBlocked(&lock);
}

bool BlockingSolver::ready() const {
  const std::lock_guard lock(mutex_);
  return !finished_ && taken_ < batch_.size();
}

bool BlockingSolver::finished() const {
  const std::lock_guard lock(mutex_);
  return finished_;
}

std::optional<std::vector<BlockingSolver::Answer>> BlockingSolver::Channel::Evaluate(
    std::vector<Request> batch) {
  if (batch.empty()) throw std::invalid_argument("BlockingSolver: an empty batch");
  BlockingSolver& solver = *solver_;
  std::unique_lock lock(solver.mutex_);
  if (solver.cancelled_) return std::nullopt;
  solver.first_ += static_cast<std::int64_t>(solver.batch_.size());
  solver.batch_ = std::move(batch);
  solver.answers_.assign(solver.batch_.size(), std::nullopt);
  solver.taken_ = 0;
  solver.answered_ = 0;
  solver.running_ = false;
  solver.changed_.notify_all();
  solver.changed_.wait(lock, [&] { return solver.running_ || solver.cancelled_; });
  if (!solver.running_) return std::nullopt;
  std::vector<Answer> answers;
  for (std::optional<Answer>& answer : solver.answers_) answers.push_back(std::move(*answer));
  return answers;
}

bool BlockingSolver::Channel::cancelled() const {
  const std::lock_guard lock(solver_->mutex_);
  return solver_->cancelled_;
}

}  // namespace powdercal
