#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "studies/planner.h"

namespace powdercal {

/// Which conditions a collapse analysis simulates.
struct CollapseOptions {
  std::vector<double> kappas = {250, 500, 1000, 2000, 4000};  ///< floors of rigid_limit, ascending
  int replicates = 3;                    ///< particle seeds, the same ones at every point
  std::vector<std::size_t> experiments;  ///< of the study
  std::vector<double> parameters;        ///< [SI] free parameters, cohesion excepted
};

/// One experiment under one scaling.
struct CollapsePoint {
  std::string mode;  ///< "rigid_limit", "sigma_over_e", the study's own
  std::size_t experiment = 0;
  double kappa_floor = 0;                ///< of "rigid_limit", under the study's largest stress
  double young_modulus = 0;              ///< [Pa]
  std::map<std::string, double> groups;  ///< of the simulation
  std::vector<PlannedRun> runs;
  std::map<std::string, std::vector<double>> responses;  ///< SI, a value for each run that gave one
  std::vector<std::string> failures;
};

/// The same powder under several scalings: rigid_limit at each kappa; sigma_over_e and the study's
/// own mode at their moduli. A cohesion that is a free parameter follows the powder's surface
/// energy, which the study must state: so that the pull-off force is the powder's, or in exact
/// proportion to it where the mode scales it.
class Collapse {
 public:
  /// The study must outlive it. Throws InputError where there is no surface energy for a cohesion
  /// that is sought, or rigid_limit is not possible.
  Collapse(const Study& study, CollapseOptions options);

  std::vector<CollapsePoint>& points() { return points_; }
  const std::vector<CollapsePoint>& points() const { return points_; }

 private:
  void AddPoints(const std::string& mode, std::unique_ptr<Scaling> scaling);
  void AddPoints(const std::string& mode, const Scaling& scaling);

  const Study& study_;
  CollapseOptions options_;
  std::vector<std::unique_ptr<Scaling>> scalings_;
  std::vector<CollapsePoint> points_;
};

/// How one response of one experiment goes with one group over all points.
struct GroupTrend {
  std::string experiment;
  std::string response;
  std::string group;
  /// [-] 1 − (variance about the straight lines between neighbours in the order of the group) /
  /// variance: near 1 the response is a smooth function of this group alone, near 0 or below the
  /// group says nothing of it.
  double collapse = 0;
  double slope = 0;        ///< d response/d ln(group), least squares
  double slope_error = 0;  ///< its standard error
  int points = 0;
};

/// From which stiffness on a response no longer changes, of rigid_limit.
struct Plateau {
  std::string experiment;
  std::string response;
  double seed_sd = 0;  ///< of a single run, pooled over the points
  /// The least kappa from which on every mean is within two standard errors of the one at the
  /// largest; 0: none is.
  double kappa = 0;
  double largest_kappa = 0;
  double change = 0;  ///< mean at `kappa`, or at the least one simulated, less that at the largest
  double error = 0;   ///< standard error of the change
};

/// Adds what one of its runs gave to a point.
void Keep(const LedgerRun& run, CollapsePoint* point);

std::vector<GroupTrend> FindTrends(const Study& study, const std::vector<CollapsePoint>& points);
std::vector<Plateau> FindPlateaus(const Study& study, const std::vector<CollapsePoint>& points);

}  // namespace powdercal
