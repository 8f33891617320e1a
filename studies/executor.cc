#include "studies/executor.h"

namespace powdercal {

LocalExecutor::LocalExecutor(int threads) {
  for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { Work(); });
}

LocalExecutor::~LocalExecutor() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
    queue_.clear();
  }
  stop_.request_stop();
  work_available_.notify_all();
}

void LocalExecutor::Submit(std::int64_t ticket, Job job) {
  {
    const std::lock_guard lock(mutex_);
    queue_.emplace_back(ticket, std::move(job));
  }
  work_available_.notify_one();
}

std::optional<Executor::Finished> LocalExecutor::Wait(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  if (!result_available_.wait_for(lock, timeout, [this] { return !finished_.empty(); })) {
    return std::nullopt;
  }
  Finished result = std::move(finished_.front());
  finished_.pop_front();
  return result;
}

void LocalExecutor::Cancel() { stop_.request_stop(); }

void LocalExecutor::Work() {
  for (;;) {
    std::pair<std::int64_t, Job> item;
    {
      std::unique_lock lock(mutex_);
      work_available_.wait(lock, [this] { return closing_ || !queue_.empty(); });
      if (closing_) return;
      item = std::move(queue_.front());
      queue_.pop_front();
    }
    Finished result{item.first, item.second(stop_.get_token())};
    {
      const std::lock_guard lock(mutex_);
      finished_.push_back(std::move(result));
    }
    result_available_.notify_one();
  }
}

}  // namespace powdercal
