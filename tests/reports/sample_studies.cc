#include "tests/reports/sample_studies.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "optimizers/pareto.h"

namespace powdercal {
namespace {

const Parameter kCohesion{
    .name = "cohesion_energy_density", .symbol = "k", .unit = "J/m3", .lower = 1e2, .upper = 1e5};
const Parameter kRolling{
    .name = "rolling_friction", .symbol = "mu_r", .unit = "1", .lower = 0.05, .upper = 0.7};
const Parameter kModulus{.name = "young_modulus",
                         .symbol = "E",
                         .unit = "Pa",
                         .lower = 1e6,
                         .upper = 1e9,
                         .logarithmic = true};

double VoidRatio(double k, double mu_r) {
  return 0.565 + 0.9 * std::pow(k / 1e5, 2.4) * (0.6 + 0.55 * mu_r) + 0.004 * std::sin(40 * mu_r);
}

StudyResults Frame() {
  StudyResults results;
  results.study = "quickstart";
  results.description = "Hastelloy X, consolidation at 9 kPa";
  results.powder = "Hastelloy X";
  results.fingerprint = "9f36d4c137efa2518d1c0f3a5be27c41d5e0a7c3b2918f6e4d7a0b9c8e1f2a3d";
  results.program_version = "0.1.0";
  results.seed = 1;
  results.parameters = {kCohesion, kRolling};
  results.optimizer = "bayesian";
  results.optimizer_description = "Gaussian processes, composite_log_ei, corners_and_centre first";
  results.backend = "liggghts";
  results.backend_version = "3.8.0";
  results.fidelity = "quick";
  results.replicates = 2;
  results.law = "hertz, tangential history, cohesion sjkr2, rolling epsd2";
  results.law_as_run = "gran model hertz tangential history cohesion sjkr2 rolling_friction epsd2";
  results.scaling = "given";
  results.scaling_description = "the study states the simulation's own modulus and stress";
  results.study_yaml = "study: quickstart\nmaterial:\n  name: \"Hastelloy X\"\n";
  results.state = "finished";
  results.stop_reason = "every response is within its tolerance";
  results.wall_seconds = 412.6;
  results.simulation_seconds = 803.4;
  results.overhead_seconds = 3.1;
  results.parallel = 2;
  return results;
}

ResponseResult VoidRatioTarget() {
  return {.name = "consolidation.void_ratio",
          .unit = "1",
          .observed = 0.783,
          .sd = 0.01,
          .tolerance = 0.007,
          .source = "paper, section 3.1, one trial; sd assumed"};
}

void AddRuns(EvaluationResult& evaluation, const std::string& experiment, int replicates) {
  for (int r = 0; r < replicates; ++r) {
    RunResult run{.id = evaluation.id * 10 + r,
                  .experiment = experiment,
                  .replicate = r,
                  .seed = 1000u + static_cast<std::uint64_t>(r),
                  .program_hash = "a3f1c2d4e5b6978812345678",
                  .reason = evaluation.outcome,
                  .message = evaluation.message,
                  .wall_seconds = 28.4 + 0.7 * static_cast<double>(evaluation.id) + r};
    if (evaluation.outcome == "ok") {
      run.responses = {{"void_ratio", *evaluation.responses[0].simulated}};
      run.diagnostics = {{"coordination_number", 5.31}, {"kappa", 334.2}, {"stress", 901.3}};
    }
    run.law = "gran model hertz tangential history cohesion sjkr2 rolling_friction epsd2";
    evaluation.runs.push_back(run);
  }
}

// chi², the running best, counts and the index of the best.
void Finish(StudyResults& results) {
  std::optional<double> lowest;
  for (std::size_t i = 0; i < results.history.size(); ++i) {
    EvaluationResult& evaluation = results.history[i];
    ++results.total;
    if (evaluation.outcome == "ok") {
      ++results.ok;
      evaluation.chi2 = 0;
      for (const ResponseResult& r : evaluation.responses) {
        const double z = (*r.simulated - r.observed) / r.sd;
        *evaluation.chi2 += z * z;
      }
      if (!lowest || *evaluation.chi2 < *lowest) {
        lowest = evaluation.chi2;
        results.best = i;
      }
    } else {
      ++results.failed;
    }
    evaluation.best_chi2 = lowest;
  }
}

void AddVoidRatioEvaluation(StudyResults& results, double k, double mu_r, const std::string& origin,
                            const std::string& outcome = "ok", const std::string& message = "") {
  EvaluationResult evaluation{
      .id = static_cast<std::int64_t>(results.history.size()),
      .parameters = {{"cohesion_energy_density", k}, {"rolling_friction", mu_r}},
      .origin = origin,
      .outcome = outcome,
      .message = message,
      .responses = {VoidRatioTarget()}};
  if (outcome == "ok") {
    evaluation.responses[0].simulated = VoidRatio(k, mu_r);
    evaluation.responses[0].replicates = 2;
    evaluation.responses[0].seed_sd = 0.0031;
  }
  AddRuns(evaluation, "consolidation", 2);
  results.history.push_back(evaluation);
}

ScalingTable PaperGroups() {
  using Verdict = GroupComparison::Verdict;
  return {.experiment = "consolidation",
          .groups = {{.symbol = "sigma/E",
                      .meaning = "applied stress against the particles' stiffness",
                      .experiment = 4.5e-8,
                      .simulation = 1.8e-4,
                      .ratio = 4000,
                      .verdict = Verdict::violated,
                      .remark = "the simulated particles are 4000 times too soft for their load: "
                                "overlaps are not the powder's, and lower the void ratio"},
                     {.symbol = "sigma/(rho_b g h)",
                      .meaning = "applied stress against the weight of the bed",
                      .experiment = 70,
                      .simulation = 12,
                      .ratio = 0.171,
                      .verdict = Verdict::warn,
                      .remark = "the applied stress is 12 times the bed's own weight instead of 70 "
                                "times: gravity counts 5.83 times too much"},
                     {.symbol = "I",
                      .meaning = "inertial number, shear rate d sqrt(rho/sigma)",
                      .verdict = Verdict::unknown},
                     {.symbol = "mu_r",
                      .meaning = "coefficient of rolling friction",
                      .experiment = 0.5,
                      .simulation = 0.5,
                      .ratio = 1,
                      .verdict = Verdict::ok}}};
}

}  // namespace

StudyResults QuickstartSample() {
  StudyResults results = Frame();
  AddVoidRatioEvaluation(results, 1e2, 0.05, "initial design: corner 1");
  AddVoidRatioEvaluation(results, 1e5, 0.7, "initial design: corner 2", "not_quasi_static",
                         "kinetic-energy ratio 0.031 at the end of the hold, above 0.001");
  AddVoidRatioEvaluation(results, 1e2, 0.7, "initial design: corner 3");
  AddVoidRatioEvaluation(results, 1e5, 0.05, "initial design: corner 4");
  AddVoidRatioEvaluation(results, 50050, 0.375, "initial design: centre");
  const double points[][2] = {{70500, 0.37}, {36900, 0.63}, {42800, 0.31}, {55400, 0.66},
                              {62000, 0.12}, {56400, 0.49}, {51800, 0.56}};
  for (const auto& [k, mu_r] : points) {
    AddVoidRatioEvaluation(results, k, mu_r, "composite_log_ei");
  }
  AddVoidRatioEvaluation(results, 91200, 0.44, "composite_log_ei", "timeout",
                         "no result within 600 s; the process group was killed");
  AddVoidRatioEvaluation(results, 58100, 0.484, "composite_log_ei");
  Finish(results);
  EvaluationResult& best = results.history[*results.best];
  best.responses[0].replicates = 3;
  results.converged = true;
  results.scaling_tables = {PaperGroups()};
  return results;
}

StudyResults TableSample() {
  StudyResults results = QuickstartSample();
  results.study = "hastelloy-x-table3";
  results.backend = "table";
  results.backend_version = "";
  results.simulated = false;
  results.law_as_run = "none: no simulation was run";
  for (EvaluationResult& evaluation : results.history) {
    for (RunResult& run : evaluation.runs) run.wall_seconds = 1e-4;
  }
  results.wall_seconds = 0.42;
  results.simulation_seconds = 0;
  results.overhead_seconds = 0.42;
  return results;
}

StudyResults CategoricalSample() {
  StudyResults results = QuickstartSample();
  results.parameters.push_back({.name = "rolling_model",
                                .symbol = "rolling",
                                .unit = "1",
                                .upper = 1,
                                .kind = Parameter::Kind::categorical,
                                .categories = {"cdt", "epsd2"}});
  for (std::size_t i = 0; i < results.history.size(); ++i) {
    results.history[i].parameters["rolling_model"] = i == *results.best || i % 2 == 0 ? 1 : 0;
  }
  return results;
}

StudyResults SeveralFidelitiesSample() {
  StudyResults results = QuickstartSample();
  results.fidelity = "standard";
  for (EvaluationResult& evaluation : results.history) evaluation.fidelity = "standard";
  for (std::int64_t id = 100; id < 105; ++id) {
    EvaluationResult evaluation = results.history[*results.best];
    evaluation.id = id;
    evaluation.fidelity = "quick";
    evaluation.best_chi2.reset();
    results.lower_fidelity.push_back(std::move(evaluation));
  }
  EvaluationResult& failed = results.lower_fidelity.back();
  failed.outcome = "timeout";
  failed.chi2.reset();
  results.total += 5;
  results.ok += 4;
  results.failed += 1;
  return results;
}

StudyResults FailedSample() {
  StudyResults results = Frame();
  for (int i = 0; i < 3; ++i) {
    AddVoidRatioEvaluation(results, 2e4 * (i + 1), 0.2, "initial design: corner", "crashed",
                           "lmp ended with signal 11");
  }
  Finish(results);
  results.stop_reason = "budget of 3 evaluations used";
  results.warnings = {"no evaluation succeeded; runs/ holds the work folders"};
  return results;
}

StudyResults JointSample() {
  StudyResults results = Frame();
  results.study = "hastelloy-x-joint";
  results.description = "consolidation and shear together";
  results.parameters = {kCohesion, kRolling, kModulus};
  results.stop_reason = "budget of 24 evaluations used";
  for (int i = 0; i < 24; ++i) {
    const auto part = [&](double step) { return std::fmod(0.5 + step * (i + 1), 1.0); };
    const double k = 1e2 + (1e5 - 1e2) * part(0.8192);
    const double mu_r = 0.05 + 0.65 * part(0.6711);
    const double modulus = 1e6 * std::pow(1e3, part(0.5497));
    EvaluationResult evaluation{.id = i,
                                .parameters = {{"cohesion_energy_density", k},
                                               {"rolling_friction", mu_r},
                                               {"young_modulus", modulus}},
                                .origin = i < 8 ? "initial design: sobol" : "composite_log_ei",
                                .outcome = i == 5 ? "lost_particles" : "ok",
                                .message = i == 5 ? "3 of 1000 particles lost" : "",
                                .responses = {VoidRatioTarget()}};
    evaluation.responses[0].tolerance.reset();
    const double stresses[] = {3e3, 5e3};
    for (const double stress : stresses) {
      evaluation.responses.push_back({.name = fmt::format("shear.stress_{}kPa", stress / 1e3),
                                      .unit = "Pa",
                                      .observed = 0.55 * stress + 400,
                                      .sd = 90});
    }
    if (evaluation.outcome == "ok") {
      evaluation.responses[0].simulated = VoidRatio(k, mu_r) - 0.02 * std::log10(1e9 / modulus);
      for (int s = 0; s < 2; ++s) {
        evaluation.responses[s + 1].simulated =
            (0.4 + 0.35 * mu_r) * stresses[s] + 0.012 * k - 40 * part(0.3);
        evaluation.responses[s + 1].replicates = 1;
      }
    }
    AddRuns(evaluation, "consolidation", 1);
    results.history.push_back(evaluation);
  }
  Finish(results);
  results.converged = false;
  return results;
}

StudyResults TransferSample() {
  StudyResults results = JointSample();
  results.experiments = {{.name = "consolidation", .fidelity = "quick"},
                         {.name = "shear", .fidelity = "standard"},
                         {.name = "spreading", .fidelity = "quick", .calibrated = false},
                         {.name = "repose", .fidelity = "quick", .calibrated = false}};
  EvaluationResult& partial = results.history[7];
  partial.outcome = kPartial;
  partial.message = "shear: no steady state";
  partial.failures = {{.experiment = "shear",
                       .reason = "not_quasi_static",
                       .message = "no steady state",
                       .failed_runs = 1,
                       .runs = 1}};
  partial.chi2.reset();
  for (std::size_t r = 1; r < partial.responses.size(); ++r) {
    partial.responses[r].simulated.reset();
    partial.responses[r].replicates = 0;
  }
  --results.ok;
  ++results.partial;
  TransferResult& transfer = results.transfer;
  transfer.experiments = {"spreading", "repose"};
  transfer.responses = {
      {.name = "spreading.coverage",
       .unit = "1",
       .simulated = 0.7,
       .seed_sd = 0.03,
       .replicates = 3,
       .observed = 0.9,
       .sd = 0.05,
       .source = "photograph, <3 trials>"},
      {.name = "spreading.layer_thickness", .unit = "m", .simulated = 71e-6, .replicates = 3},
      {.name = "spreading.packing_density",
       .unit = "1",
       .simulated = 0.53,
       .replicates = 3,
       .observed = 0.55,
       .sd = 0.05}};
  transfer.failures = {{.experiment = "repose",
                        .reason = "timeout",
                        .message = "no result within 600 s",
                        .failed_runs = 3,
                        .runs = 3}};
  for (int r = 0; r < 3; ++r) {
    transfer.runs.push_back({.id = 900 + r,
                             .experiment = "spreading",
                             .replicate = r,
                             .reason = "ok",
                             .wall_seconds = 20});
  }
  return results;
}

StudyResults ConfirmationSample() {
  StudyResults results = JointSample();
  EvaluationResult& best = results.history[*results.best];
  for (ResponseResult& response : best.responses) {
    response.simulated = response.observed + 0.5 * response.sd;
    response.replicates = 4;
    response.seed_sd = 0.4 * response.sd;
  }
  ConfirmationResult whole{.backend = "embedded",
                           .version = "1",
                           .outcome = "ok",
                           .law = "hertz + history, <as run>",
                           .responses = best.responses,
                           .chi2 = 17.3};
  *whole.responses[0].simulated += 0.04;
  for (int r = 0; r < 4; ++r) {
    whole.runs.push_back({.id = 900 + r,
                          .experiment = "consolidation",
                          .backend = "embedded",
                          .replicate = r,
                          .reason = "ok",
                          .wall_seconds = 2});
  }
  ConfirmationResult part{.backend = "shearless",
                          .version = "0.9",
                          .outcome = kPartial,
                          .message = "shear: it has no <shear> cell",
                          .failures = {{.experiment = "shear",
                                        .reason = "unsupported",
                                        .message = "it has no <shear> cell",
                                        .failed_runs = 4,
                                        .runs = 4}},
                          .responses = best.responses};
  for (std::size_t r = 1; r < part.responses.size(); ++r) {
    part.responses[r].simulated.reset();
    part.responses[r].replicates = 0;
  }
  ConfirmationResult absent{.backend = "absent",
                            .outcome = kUnavailable,
                            .message = "not available: no program 'absent' on PATH",
                            .responses = part.responses};
  absent.responses[0].simulated.reset();
  results.confirmations = {whole, part, absent};
  return results;
}

StudyResults ApproximationSample() {
  StudyResults results = JointSample();
  results.approximations = {
      {.part = "cohesion", .name = "dmt_pull_off", .text = "SJKR2 is <approximated> by DMT."}};
  ApproximationEffect effect{.backend = "embedded", .version = "1"};
  effect.approximated = results.history[*results.best].responses;
  for (ResponseResult& response : effect.approximated) {
    response.simulated = response.observed;
    response.replicates = 4;
    response.seed_sd = 0.4 * response.sd;
  }
  effect.exact = effect.approximated;
  *effect.exact[0].simulated -= 0.02;
  for (std::size_t r = 1; r < effect.exact.size(); ++r) effect.exact[r].simulated.reset();
  effect.failures = {{.experiment = "shear",
                      .reason = "timeout",
                      .message = "no result within 600 s",
                      .failed_runs = 4,
                      .runs = 4}};
  effect.runs = {{.id = 950, .experiment = "consolidation", .backend = "embedded", .reason = "ok"}};
  results.approximation_effect = effect;
  return results;
}

StudyResults ParetoSample(int objectives) {
  StudyResults results = JointSample();
  results.study = "hastelloy-x-pareto";
  results.objectives = {"consolidation", "shear", "spreading"};
  results.objectives.resize(static_cast<std::size_t>(objectives));
  Eigen::MatrixXd misfits(static_cast<Eigen::Index>(results.history.size()), objectives);
  for (std::size_t i = 0; i < results.history.size(); ++i) {
    EvaluationResult& evaluation = results.history[i];
    if (objectives == 3) evaluation.responses[2].name = "spreading.stress_5kPa";
    evaluation.objectives.resize(results.objectives.size());
    for (std::size_t o = 0; o < results.objectives.size(); ++o) {
      ObjectiveResult& objective = evaluation.objectives[o];
      for (const ResponseResult& response : evaluation.responses) {
        if (!response.simulated || !response.name.starts_with(results.objectives[o])) continue;
        const double z = (*response.simulated - response.observed) / response.sd;
        objective.chi2 = objective.chi2.value_or(0) + z * z / 1.05;
        objective.misfit = objective.misfit.value_or(0) + z * z + 0.05;
      }
      misfits(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(o)) =
          objective.misfit.value_or(std::numeric_limits<double>::quiet_NaN());
    }
  }
  results.pareto = NonDominated(misfits);
  Eigen::Index best = 0;
  misfits.rowwise().sum().array().isNaN().select(1e300, misfits.rowwise().sum()).minCoeff(&best);
  results.best = static_cast<std::size_t>(best);
  return results;
}

StudyResults LineSample() {
  StudyResults results = Frame();
  results.parameters = {kCohesion};
  for (int i = 0; i < 6; ++i) {
    AddVoidRatioEvaluation(results, 1e2 + 19980 * i, 0.3, "grid");
    results.history.back().parameters.erase("rolling_friction");
  }
  Finish(results);
  results.converged = false;
  results.stop_reason = "the design has no more points";
  return results;
}

}  // namespace powdercal
