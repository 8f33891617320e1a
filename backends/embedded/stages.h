#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "backends/backend.h"
#include "backends/embedded/simulation.h"
#include "backends/program.h"
#include "backends/trace.h"
#include "backends/vtk_snapshots.h"

namespace powdercal::embedded {

/// The controller of a servo's body that stands at `height` [m], at the beginning of its stage.
ServoControl ControlOf(const Program& program, const Servo& servo, double height);

/// Takes a simulation through the stages of its program, watches its health on the way, and writes
/// the trace. One object for one run.
class StageRunner {
 public:
  StageRunner(const Program& program, const RunContext& context, const Settings& settings);

  /// Never throws for what happens in the simulation; that is the trace's outcome. Throws
  /// InputError when the particles cannot be placed or snapshots cannot be written.
  Trace Run();

 private:
  // Each returns false when the run has ended, with the outcome in the trace.
  bool Do(const Insert& insert);
  bool Do(const Settle& settle);
  bool Do(const Servo& servo);
  bool Do(const Hold& hold);
  bool Do(const Advance& advance);
  bool Do(const Deform& deform);
  bool Do(const Save& save);
  bool Do(const Restore& restore);
  bool Do(const Remove& remove);

  bool RunSteps(std::int64_t count);
  bool RunPiece(std::int64_t count);
  bool Healthy();
  bool Fail(Reason reason, std::string message);
  bool Interrupted();
  bool FailInterrupted();
  template <typename Visit>
  void ForEachBody(const Visit& visit) const;
  void PrepareSeries();
  void RestartWindows();
  void Record();
  void RecordBodies();
  void RecordCell();
  void RecordSlab();
  void AddMoment(const std::string& name);
  void WriteSnapshot();
  void Finish();
  std::int64_t StepsOf(double duration) const;
  void PlaceServo(double height);
  double EnergyBudget() const;
  void StartMotions(const Advance& advance);
  void SetVelocity(const std::string& body, const Vector3& velocity);

  const Program& program_;
  const RunContext& context_;
  Settings settings_;
  std::chrono::steady_clock::time_point start_;
  bool timed_out_ = false;
  Packing packing_;
  std::optional<Simulation> simulation_;
  Trace trace_;

  const Servo* first_servo_ = nullptr;  // of the program
  const Servo* servo_ = nullptr;        // at work; null before the first
  Body* servo_body_ = nullptr;

  struct Saved {
    Simulation simulation;
    const Servo* servo;
  };
  std::map<std::string, Saved> saved_;

  // Sums over a window.
  struct Window {
    Vector3 force{};    // [N]
    double height = 0;  // [m]
  };
  Window hold_window_;                                   // of the servo's body
  std::vector<std::optional<std::size_t>> body_series_;  // place in the trace, by body
  std::vector<Window> body_windows_;                     // by body
  std::int64_t window_steps_ = 0;
  std::vector<Vector3> body_force_;  // [N] sums over the recording window, by body
  std::int64_t body_steps_ = 0;

  struct CellWindow {
    std::int64_t samples = 0;
    std::array<Vector3, 3> stress{};
  };
  CellWindow cell_window_;

  struct SlabWindow {
    std::int64_t samples = 0;
    double solid_fraction = 0;
    std::array<Vector3, 3> stress{};
  };
  SlabWindow slab_window_;

  // Of the servo's body over the last window of a hold.
  struct Held {
    double force = 0;     // [N]
    double velocity = 0;  // [m/s]
    bool valid = false;
  };
  Held held_;

  double first_energy_ = 0;   // [J] kinetic, at the start
  double first_elastic_ = 0;  // [J]
  double drive_speed_ = 0;    // [m/s] fastest that anything was driven
  double total_mass_ = 0;     // [kg]
  std::optional<SnapshotWriter> snapshots_;
  std::int64_t snapshot_every_ = 0;
};

}  // namespace powdercal::embedded
