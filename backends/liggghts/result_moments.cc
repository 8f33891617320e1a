#include "backends/liggghts/result_moments.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "backends/liggghts/deck.h"
#include "backends/liggghts/stage_states.h"

namespace powdercal::liggghts {
namespace {

// Into the domain along its periodic axes: LIGGGHTS wraps particles only when it sorts them, and
// deletes those beyond outflow sides only then, too.
void Tidy(const Domain& domain, Packing& packing) {
  const Vector3 lengths = domain.Lengths();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double lower = domain.lower[axis];
    const double upper = domain.upper[axis];
    if (domain.boundaries[axis] == Boundary::periodic) {
      for (Sphere& sphere : packing) {
        double& x = sphere.position[axis];
        if (x < lower) x += lengths[axis];
        if (x >= upper) x -= lengths[axis];
      }
    } else if (domain.boundaries[axis] == Boundary::outflow) {
      std::erase_if(packing, [&](const Sphere& sphere) {
        return sphere.position[axis] < lower || sphere.position[axis] > upper;
      });
    }
  }
}

int CountLost(const Domain& domain, const Packing& packing) {
  return static_cast<int>(std::count_if(packing.begin(), packing.end(), [&](const Sphere& sphere) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double x = sphere.position[axis];
      const bool beyond = x < domain.lower[axis] || x > domain.upper[axis];
      if (domain.boundaries[axis] == Boundary::open && beyond) return true;
    }
    return false;
  }));
}

// Steps at which stages end; of those that take no time, where the one before ended.
std::vector<double> EndsOf(const Program& program, const std::vector<Record>& records) {
  std::vector<double> ends;
  double now = 0;
  for (std::size_t i = 0; i < program.stages.size(); ++i) {
    if (LeavesMoment(program.stages[i]) || std::holds_alternative<Save>(program.stages[i])) {
      const Record* end = EndOf(records, i);
      if (end == nullptr) throw std::runtime_error(fmt::format("stage {} did not end", i));
      now = Value(*end, "step");
    }
    ends.push_back(now);
  }
  return ends;
}

class MomentReader {
 public:
  MomentReader(const Program& program, const std::filesystem::path& folder,
               const std::vector<Record>& records, Trace& trace)
      : program_(program),
        folder_(folder),
        trace_(trace),
        shifts_(ShiftsOf(records)),
        ends_(EndsOf(program, records)),
        states_(StatesOf(program, ends_)) {}

  void Read(std::size_t stage, const Record& end) {
    stage_ = stage;
    const std::size_t restores = static_cast<std::size_t>(
        std::count_if(program_.stages.begin(), program_.stages.begin() + static_cast<long>(stage),
                      [](const Stage& s) { return std::holds_alternative<Restore>(s); }));
    shift_ = shifts_.at(restores);
    from_ = states_[stage].begin;
    const auto* advance = std::get_if<Advance>(&program_.stages[stage]);
    if (advance != nullptr && advance->packing_every > 0) {
      for (Frame& frame : ReadDump(folder_ / FramesFile(program_, stage))) {
        if (static_cast<double>(frame.step) + shift_ < Value(end, "step"))
          Append(std::move(frame), end);
      }
    }
    std::vector<Frame> frames = ReadDump(folder_ / DumpFile(program_, stage));
    if (frames.size() != 1) throw std::runtime_error("a dump holds more than one packing");
    Append(std::move(frames.front()), end);
    if (const Servo* servo = states_[stage].servo) EndServo(end, *servo);
  }

  // Where meshes and groups were in the middle of each window.
  void FillHeights() {
    for (WallSeries& series : trace_.series) {
      if (!series.height.empty()) continue;
      for (const double time : series.time) {
        const double middle = time / program_.time_step - 0.5 * (kSeriesSteps - 1);
        series.height.push_back(HeightAt(series.wall, middle));
      }
    }
  }

  int lost() const { return lost_; }

 private:
  void Append(Frame frame, const Record& end) {
    Tidy(program_.domain, frame.packing);
    lost_ = std::max(lost_, CountLost(program_.domain, frame.packing));
    const double step = static_cast<double>(frame.step) + shift_;
    trace_.moments.push_back({.name = MomentName(program_.stages[stage_]),
                              .time = step * program_.time_step,
                              .packing = std::move(frame.packing),
                              .walls = WallsAt(step, end)});
    from_ = step;
  }

  std::map<std::string, WallState> WallsAt(double step, const Record& end) const {
    std::map<std::string, WallState> walls;
    const StageState& state = states_[stage_];
    const double duration = (step - state.begin) * program_.time_step;
    for (const auto& [name, body] : state.bodies) {
      WallState& wall = walls[name];
      wall.velocity = body.velocity[2];
      wall.height = body.height + body.velocity[2] * duration;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        wall.displacement[axis] = body.displacement[axis] + body.velocity[axis] * duration;
      }
      wall.force = MeanForce(name, step);
    }
    if (state.servo != nullptr) {
      const WallSeries& series = *trace_.FindSeries(state.servo->wall);
      const std::size_t count = WindowsUntil(series, step);
      if (count > 0) {
        WallState& wall = walls[state.servo->wall];
        wall.force = MeanForce(series.wall, step);
        wall.height = series.height[count - 1];
        wall.displacement[2] = wall.height - (Value(end, "h") - Value(end, "rise"));
        if (count > 1) {
          wall.velocity = (series.height[count - 1] - series.height[count - 2]) /
                          (series.time[count - 1] - series.time[count - 2]);
        }
      }
    }
    return walls;
  }

  // The servo's wall at the end of a stage: where it is then, and of a Hold means over its last
  // window.
  void EndServo(const Record& end, const Servo& servo) {
    WallState& state = trace_.moments.back().walls[servo.wall];
    state.height = Value(end, "h");
    state.displacement = {0, 0, Value(end, "rise")};
    if (!end.values.contains("p")) return;
    state.force[2] = -Value(end, "p") * program_.domain.BaseArea();
    state.velocity = Value(end, "velocity");
  }

  std::size_t WindowsUntil(const WallSeries& series, double step) const {
    const double time = (step + 0.5) * program_.time_step;
    const auto next = std::upper_bound(series.time.begin(), series.time.end(), time);
    return static_cast<std::size_t>(next - series.time.begin());
  }

  // Mean over the windows since the moment before in an Advance, over the last one else.
  Vector3 MeanForce(const std::string& body, double step) const {
    const WallSeries* series = trace_.FindSeries(body);
    if (series == nullptr) return {};
    const std::size_t last = WindowsUntil(*series, step);
    if (last == 0) return {};
    std::size_t first = last - 1;
    if (std::holds_alternative<Advance>(program_.stages[stage_])) {
      first = std::min(first, WindowsUntil(*series, from_ + kSeriesSteps - 1));
    }
    Vector3 sum{};
    for (std::size_t n = first; n < last; ++n) {
      for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += series->force[n][axis];
    }
    for (double& component : sum) component /= static_cast<double>(last - first);
    return sum;
  }

  double HeightAt(const std::string& body, double step) const {
    const auto next = std::lower_bound(ends_.begin(), ends_.end(), step);
    const auto stage = std::min(static_cast<std::size_t>(next - ends_.begin()), ends_.size() - 1);
    const auto found = states_[stage].bodies.find(body);
    if (found == states_[stage].bodies.end()) return 0;
    const double duration = (step - states_[stage].begin) * program_.time_step;
    return found->second.height + found->second.velocity[2] * duration;
  }

  const Program& program_;
  const std::filesystem::path& folder_;
  Trace& trace_;
  const std::vector<double> shifts_;
  const std::vector<double> ends_;
  const std::vector<StageState> states_;
  std::size_t stage_ = 0;
  double shift_ = 0;  // [steps] of the stage's files
  double from_ = 0;   // [steps] the moment before, within the stage
  int lost_ = 0;
};

}  // namespace

int ReadMoments(const Program& program, const std::filesystem::path& folder,
                const std::vector<Record>& records, Trace& trace) {
  trace.series = ReadForces(program, folder, ShiftsOf(records));
  trace.slab = ReadSlab(program, folder, ShiftsOf(records));
  MomentReader reader(program, folder, records, trace);
  reader.FillHeights();
  for (std::size_t i = 0; i < program.stages.size(); ++i) {
    if (LeavesMoment(program.stages[i])) reader.Read(i, *EndOf(records, i));
  }
  return reader.lost();
}

}  // namespace powdercal::liggghts
