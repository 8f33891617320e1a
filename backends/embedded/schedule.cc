#include "backends/embedded/schedule.h"

namespace powdercal::embedded {

Schedule MakeSchedule(std::span<const std::size_t> first, bool wrap) {
  const std::size_t slabs = first.back();
  constexpr std::size_t kNever = static_cast<std::size_t>(-1);
  struct Progress {
    std::size_t thread = 0;
    std::size_t pairs = kNever;  // phase in which it was done
    std::size_t finish = kNever;
  };
  std::vector<Progress> progress(slabs);
  for (std::size_t t = 0; t + 1 < first.size(); ++t) {
    for (std::size_t s = first[t]; s < first[t + 1]; ++s) progress[s].thread = t;
  }
  Schedule schedule;
  for (std::size_t left = 2 * slabs; left > 0;) {
    const std::size_t phase = schedule.size();
    schedule.emplace_back(first.size() - 1);
    for (std::size_t t = 0; t + 1 < first.size(); ++t) {
      const auto done = [&](std::size_t s) {
        return progress[s].pairs < phase || (progress[s].pairs == phase && progress[s].thread == t);
      };
      // The slab before or after, if there is one, has had its pairs.
      const auto before = [&](std::size_t s) {
        if (s > 0) return done(s - 1);
        return !wrap || slabs <= 2 || done(slabs - 1);
      };
      const auto after = [&](std::size_t s) {
        if (s + 1 < slabs) return done(s + 1);
        return !wrap || slabs <= 2 || done(0);
      };
      for (std::size_t s = first[t]; s < first[t + 1];) {
        Progress& p = progress[s];
        const auto index = static_cast<std::uint32_t>(s);
        if (p.pairs == kNever && (s % 2 == 0 || (before(s) && after(s)))) {
          schedule[phase][t].push_back({false, index});
          p.pairs = phase;
        } else if (p.finish == kNever && p.pairs != kNever && done(s) && before(s)) {
          schedule[phase][t].push_back({true, index});
          p.finish = phase;
        } else {
          ++s;
          continue;
        }
        --left;
        s = first[t];
      }
    }
  }
  return schedule;
}

}  // namespace powdercal::embedded
