#include "optimizers/least_squares/bounded_lm.h"

namespace powdercal {
namespace {

class Cost final : public ceres::CostFunction {
 public:
  Cost(const ResidualFunction& function, int residuals, int parameters) : function_(function) {
    set_num_residuals(residuals);
    mutable_parameter_block_sizes()->push_back(parameters);
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const int d = parameter_block_sizes()[0];
    const Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(parameters[0], d);
    Eigen::VectorXd rho;
    Eigen::MatrixXd jacobian;
    const bool derivatives = jacobians != nullptr && jacobians[0] != nullptr;
    if (!function_(x, &rho, derivatives ? &jacobian : nullptr)) return false;
    Eigen::Map<Eigen::VectorXd>(residuals, rho.size()) = rho;
    if (!derivatives) return true;
    const Eigen::VectorXd gradient = jacobian.transpose() * rho;
    for (int k = 0; k < d; ++k) {
      if ((x[k] <= 0 && gradient[k] > 0) || (x[k] >= 1 && gradient[k] < 0)) {
        jacobian.col(k).setZero();
      }
    }
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    // A column alone is stored alike either way, and Eigen refuses to call it row-major.
    if (d == 1) {
      Eigen::Map<Eigen::VectorXd>(jacobians[0], rho.size()) = jacobian.col(0);
    } else {
      Eigen::Map<RowMajor>(jacobians[0], rho.size(), d) = jacobian;
    }
    return true;
  }

 private:
  const ResidualFunction& function_;
};

class Callback final : public ceres::IterationCallback {
 public:
  explicit Callback(const BoundedLmOptions& options) : options_(options) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    return options_.after_iteration ? options_.after_iteration(summary) : ceres::SOLVER_CONTINUE;
  }

 private:
  const BoundedLmOptions& options_;
};

}  // namespace

void LevenbergMarquardt(const ResidualFunction& function, int count,
                        const BoundedLmOptions& options, Eigen::VectorXd* x) {
  const int d = static_cast<int>(x->size());
  Cost cost(function, count, d);
  Callback callback(options);
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  problem.AddResidualBlock(&cost, nullptr, x->data());
  for (int k = 0; k < d; ++k) {
    problem.SetParameterLowerBound(x->data(), k, 0);
    problem.SetParameterUpperBound(x->data(), k, 1);
  }
  ceres::Solver::Options solver;
  solver.minimizer_type = ceres::TRUST_REGION;
  solver.trust_region_strategy_type = ceres::LEVENBERG_MARQUARDT;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.initial_trust_region_radius = options.initial_radius;
  solver.max_num_iterations = options.max_iterations;
  // Its line search along the bounds would ask for Jacobians at trial points.
  solver.max_num_line_search_step_size_iterations = 0;
  solver.function_tolerance = options.tolerance;
  solver.gradient_tolerance = 1e-14;
  solver.parameter_tolerance = 1e-12;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  solver.callbacks.push_back(&callback);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
}

}  // namespace powdercal
