#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/archive.h"

namespace powdercal {

/// A parameter to be found.
struct Parameter {
  enum class Kind {
    continuous,
    integer,      ///< lower, lower + 1, …, upper
    categorical,  ///< an index into `categories`, which have no order; lower = 0
  };

  std::string name;          ///< canonical, "cohesion_energy_density"
  std::string symbol;        ///< "k"; the name if the study gives none
  std::string unit;          ///< SI unit, "1" for pure numbers
  double lower = 0;          ///< SI
  double upper = 1;          ///< SI
  bool logarithmic = false;  ///< searched on a log scale; then lower > 0; continuous only
  Kind kind = Kind::continuous;
  std::vector<std::string> categories;  ///< categorical: at least 2; upper = their number − 1

  /// Number of values that a discrete parameter can take; 0: continuous.
  int levels() const;
  bool categorical() const { return kind == Kind::categorical; }
  /// categorical: the name of the category that an index stands for, the nearest valid one.
  const std::string& CategoryAt(double index) const;
};

/// The box that is searched. Optimizers see the unit box only. A discrete parameter with n levels
/// divides its side of the box into n equal parts; the middle of a part stands for the level.
struct SearchSpace {
  std::vector<Parameter> parameters;

  int dimension() const { return static_cast<int>(parameters.size()); }
  /// Whether a parameter is an integer or categorical.
  bool discrete() const;
  /// Unit box → SI (discrete: the level), and back. Points slightly outside the box are clamped.
  Eigen::VectorXd FromUnit(const Eigen::VectorXd& point) const;
  Eigen::VectorXd ToUnit(const Eigen::VectorXd& values) const;
  /// The point that stands for the same values: clamped, discrete entries moved to the middle of
  /// their part. Optimizers ask for such points only.
  Eigen::VectorXd Snap(const Eigen::VectorXd& point) const;
};

/// A response with the value it should take, or that is to be as low as possible.
struct Target {
  std::string response;  ///< "consolidation.void_ratio"
  std::string unit;      ///< SI unit
  double value = 0;      ///< SI
  double sd = 0;         ///< SI, experimental standard deviation, > 0
  int objective = 0;     ///< pareto: index of the objective it belongs to
  /// The objective is the response itself, (response − value)/sd, and has no other target.
  bool minimise = false;
};

/// What is to be minimised: joint: chi² = Σ ((response − value)²/sd²) over all targets; pareto: one
/// such sum for each objective.
struct Objectives {
  enum class Kind { joint, pareto };
  Kind kind = Kind::joint;
  std::vector<Target> targets;
  /// pareto: value of each objective beyond which it is of no use, from which hypervolumes are
  /// measured; empty: not known.
  std::vector<double> reference;
};

/// joint: 1; pareto: 1 + the highest objective of a target.
int ObjectiveCount(const Objectives& objectives);

/// The same with objectives numbered 0, 1, … without gaps; all 0 where they are joint.
Objectives Numbered(Objectives objectives);

/// A point that the optimizer wants evaluated.
struct Candidate {
  std::int64_t id = 0;    ///< 0, 1, 2, … in the order of asking
  Eigen::VectorXd point;  ///< in the unit box
  std::string origin;     ///< for people: "initial design: corner 3", "composite_log_ei"
  double fidelity = 1;    ///< at which to evaluate it, of OptimizerFactory::fidelities()
};

/// What came of a candidate. A candidate may be told again when more replicates are known; the
/// later observation replaces the earlier one.
struct Observation {
  std::int64_t id = 0;
  Eigen::VectorXd point;      ///< in the unit box
  Eigen::VectorXd responses;  ///< in the order of Objectives::targets; NaN where one failed
  Eigen::VectorXd variances;  ///< of those means, from seed scatter; 0: unknown or none
  bool failed = false;        ///< no response at all; never turned into a number
  std::string failure;        ///< reason, when failed
  double fidelity = 1;        ///< in (0, 1], at which it was evaluated; 1: the target
};

struct Status {
  enum class Phase {
    ready,     ///< Ask will give candidates
    waiting,   ///< needs to be told of pending candidates first
    finished,  ///< will ask no more; `message` says why
  };
  Phase phase = Phase::ready;
  std::string message;
};

struct Capabilities {
  bool noise = false;         ///< uses the variances
  bool asynchronous = false;  ///< can be asked while candidates are pending
  bool pareto = false;        ///< more than one objective
  bool failures = false;      ///< learns where evaluations fail
  bool discrete = false;      ///< integer and categorical parameters
};

/// Finds parameters by asking for evaluations and being told of their outcome.
///
/// Life cycle: Make → {Ask, Tell}* until status().phase == finished or the study's budget ends. The
/// sequence of candidates is a function of the options, the seed and the sequence of calls alone,
/// on which resuming by replay depends.
class Optimizer {
 public:
  virtual ~Optimizer() = default;

  /// At most `max_count` new candidates. Empty: waiting, or done; see status().
  virtual std::vector<Candidate> Ask(int max_count) = 0;
  /// Any order, partial batches, failures included; points that were never asked (from an earlier
  /// run or the user's list) may be told with negative ids.
  virtual void Tell(std::span<const Observation> observations) = 0;
  virtual Status status() const = 0;
  virtual Capabilities capabilities() const = 0;
  /// "" if it can treat this problem, else the reason, with alternatives.
  virtual std::string ExplainUnsupported(const SearchSpace& space,
                                         const Objectives& objectives) const = 0;
};

struct DesignOptions;

/// A fidelity at which evaluations can be made.
struct FidelityLevel {
  double fidelity = 1;  ///< in (0, 1]; 1: the target, which alone counts in the end
  double cost = 1;      ///< of an evaluation, > 0, in units of one at the target
};

/// An optimizer's own section of the study file. Created by name; holds the options; makes
/// optimizers.
class OptimizerFactory {
 public:
  virtual ~OptimizerFactory() = default;
  virtual const std::string& name() const = 0;
  virtual std::string Describe() const = 0;  ///< one line
  virtual void Serialize(Archive& archive, const SearchSpace& space) = 0;
  virtual std::unique_ptr<Optimizer> Make(const SearchSpace& space, const Objectives& objectives,
                                          std::uint64_t seed) const = 0;
  /// What its optimizers begin with, to be changed at will; null: they begin with nothing of the
  /// kind.
  virtual DesignOptions* initial_design() { return nullptr; }
  /// From which its optimizers choose for each candidate, to be changed at will; empty: everything
  /// is evaluated at the target. Null: they cannot choose.
  virtual std::vector<FidelityLevel>* fidelities() { return nullptr; }
};

/// Names of all optimizers, sorted. The designs (corners_and_centre, grid, latin_hypercube, list,
/// orthogonal_array, sobol) are optimizers of their own: they ask for their points and are done.
std::span<const std::string> OptimizerNames();
/// Throws InputError for an unknown name.
std::unique_ptr<OptimizerFactory> MakeOptimizerFactory(const std::string& name);

/// chi² of responses against targets with variance sd² + variance of the mean (responses with NaN
/// do not count); of a minimised target (response − value)/sd. objective < 0: all targets.
double ChiSquared(const Objectives& objectives, const Eigen::VectorXd& responses,
                  const Eigen::VectorXd& variances, int objective = -1);

}  // namespace powdercal
