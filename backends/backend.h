#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "backends/program.h"
#include "backends/trace.h"
#include "core/archive.h"

namespace powdercal {

/// Folder for snapshots (vtk_snapshots.h), in a run's work folder.
inline constexpr const char* kSnapshotFolder = "snapshots";

/// Where and how one run takes place.
struct RunContext {
  std::filesystem::path work_folder;  ///< created by the backend where it needs one
  std::optional<std::chrono::duration<double>> time_limit;  ///< wall clock
  std::stop_token stop;     ///< a request ends the run with `cancelled`
  bool keep_files = false;  ///< keep the work folder of a successful run (a failed one's always is)
  /// [s] simulated, between two snapshots; 0: none. Backends that can (`writes_snapshots`) write
  /// them to work_folder / kSnapshotFolder; the result must not depend on it.
  double snapshot_interval = 0;
};

struct Availability {
  bool available = false;
  std::string version;  ///< e.g. "3.8.0"; "" when absent
  std::string why_not;  ///< what is missing and how to get it; "" when available
};

/// What a study wants to know of its backend, told before the first run.
struct BackendProblem {
  struct FreeParameter {
    std::string name;  ///< canonical, a key of Program::parameters
    std::string unit;  ///< SI unit, "1" for pure numbers
    double lower = 0;  ///< SI
    double upper = 0;  ///< SI
  };
  struct Response {
    std::string name;  ///< with the experiment's: "consolidation.void_ratio"
    std::string unit;  ///< SI unit, "1" for pure numbers
  };

  std::filesystem::path base_folder;  ///< where relative paths start: the study file's folder
  std::vector<FreeParameter> parameters;
  std::vector<Response> responses;
};

/// A simulator.
///
/// Life cycle:  MakeBackend(name)            registry.h
///              → Serialize(reading archive)  the study's `backend` section
///              → Prepare(problem)            once, from one thread; input errors come out here
///              → ExplainUnsupported(program), Run(program, …)  any number, from any threads at
///              once
/// name() and availability() may be asked at any moment, also of a backend that is never prepared.
class Backend {
 public:
  virtual ~Backend() = default;

  virtual const std::string& name() const = 0;

  /// Whether it can run on this machine. Never throws; may be asked often.
  virtual Availability availability() const = 0;

  /// Whether runs are simulations. When false (the table backend), every output says so.
  virtual bool simulates() const { return true; }

  /// Whether it heeds RunContext::snapshot_interval.
  virtual bool writes_snapshots() const { return false; }

  /// Reads or writes the backend's own options, which stand in the study's `backend` section beside
  /// `name`. Most have none.
  virtual void Serialize(Archive& /*archive*/) {}

  /// Reads what the options name and checks that it can answer the study. Returns warnings for
  /// people. Throws InputError.
  virtual std::vector<std::string> Prepare(const BackendProblem& /*problem*/) { return {}; }

  /// What else than the program and the version determines the result (a data file's hash, a lane
  /// width); part of the cache key. Requires Prepare().
  virtual std::string Fingerprint() const { return ""; }

  /// How it runs, for people, where that is not plain from name and version: "avx512, 2 threads".
  virtual std::string Describe() const { return ""; }

  /// Cores that one run keeps busy; a study with `parallel: 0` starts as many runs as fit.
  virtual int cores() const { return 1; }

  /// Particle steps per second [1/s] of one run of this program, for estimates of cost (measured;
  /// see docs/backends.md); 0: no simulation, no cost.
  virtual double Throughput(const Program& /*program*/) const { return 0; }

  /// "" if the program can be run, else the reason why not.
  virtual std::string ExplainUnsupported(const Program& program) const = 0;

  /// Runs the program. Failures of the simulation are outcomes of the trace, not exceptions.
  virtual Trace Run(const Program& program, const RunContext& context) const = 0;
};

}  // namespace powdercal
