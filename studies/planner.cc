#include "studies/planner.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>

#include "core/hash.h"
#include "core/random.h"

namespace powdercal {
namespace {

// Replicates of different points use different particles, so that a lucky arrangement cannot favour
// a whole region; the same point always gets the same ones, so that the ledger can serve it again.
std::uint64_t ParticleSeed(const Study& study, const std::vector<double>& parameters,
                           int replicate) {
  RandomStream stream = RandomStream(study.seed).Split("particles");
  for (const double value : parameters) stream = stream.Split(std::bit_cast<std::uint64_t>(value));
  // 31 bits suit every simulator.
  return stream.Split(static_cast<std::uint64_t>(replicate)).Bits() >> 33;
}

}  // namespace

Planner::Planner(const Study& study)
    : study_(study), availability_(study.backend.backend->availability()) {}

Conditions Planner::Laboratory(std::size_t experiment) const {
  const PowderSpecification& powder = study_.powder;
  Conditions conditions{.young_modulus = powder.young_modulus,
                        .poisson_ratio = powder.poisson_ratio,
                        .density = powder.density,
                        .diameter = powder.sizes.Moment(1),
                        .gravity = 9.81,
                        .surface_energy = powder.surface_energy,
                        .restitution = powder.restitution,
                        .friction = powder.particle_friction};
  study_.experiments[experiment].experiment->DescribeConditions(study_.backend.fidelity,
                                                                conditions);
  return conditions;
}

Conditions Planner::Simulation(std::size_t experiment,
                               const std::vector<double>& parameters) const {
  Conditions simulation = study_.scaling->ToSimulation(Laboratory(experiment));
  const SimulatedPowder powder = MakePowder(simulation, parameters);
  const ContactParameters& contact = powder.materials.particle_particle;
  simulation.cohesion_energy_density.reset();
  simulation.surface_energy.reset();
  if (study_.law.cohesion == ContactLaw::Cohesion::sjkr2) {
    simulation.cohesion_energy_density = contact.cohesion_energy_density;
  } else if (study_.law.cohesion == ContactLaw::Cohesion::dmt) {
    simulation.surface_energy = contact.surface_energy;
  } else {
    simulation.cohesion_energy_density = 0;
  }
  simulation.restitution = contact.restitution;
  simulation.friction = contact.friction;
  simulation.rolling_friction = contact.rolling_friction;
  simulation.time_step = study_.numerics.TimeStep(powder);
  study_.experiments[experiment].experiment->DescribeSimulation(powder, study_.backend.fidelity,
                                                                simulation);
  return simulation;
}

SimulatedPowder Planner::MakePowder(const Conditions& simulation,
                                    const std::vector<double>& parameters) const {
  const PowderSpecification& known = study_.powder;
  SimulatedPowder powder{.sizes = known.sizes, .materials = {}, .law = study_.law};
  Materials& materials = powder.materials;
  materials.density = *simulation.density;
  materials.young_modulus = *simulation.young_modulus;
  materials.poisson_ratio = *simulation.poisson_ratio;
  materials.particle_particle = {.restitution = known.restitution,
                                 .friction = known.particle_friction,
                                 .rolling_friction = known.rolling_friction,
                                 .cohesion_energy_density = known.cohesion_energy_density,
                                 .surface_energy = known.surface_energy.value_or(0)};
  materials.particle_wall = materials.particle_particle;
  materials.particle_wall.friction = known.wall_friction;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    ApplyParameter(study_.space.parameters[i].name, parameters[i], powder);
  }
  return powder;
}

std::vector<PlannedRun> Planner::Plan(const std::vector<double>& parameters, int replicate,
                                      std::optional<std::uint64_t> seed) const {
  std::vector<PlannedRun> runs;
  for (std::size_t i = 0; i < study_.experiments.size(); ++i) {
    const Conditions simulation = Simulation(i, parameters);
    PlannedRun run{.experiment = i, .replicate = replicate};
    run.seed = seed.value_or(ParticleSeed(study_, parameters, replicate));
    run.program =
        study_.experiments[i].experiment->Plan(MakePowder(simulation, parameters), simulation,
                                               study_.numerics, study_.backend.fidelity, run.seed);
    run.program.experiment = study_.experiments[i].experiment->name();
    for (std::size_t p = 0; p < parameters.size(); ++p) {
      run.program.parameters[study_.space.parameters[p].name] = parameters[p];
    }
    run.program_hash = run.program.Hash();
    const Backend& backend = *study_.backend.backend;
    run.key = Sha256(fmt::format("{}\n{}\n{}\n{}", run.program_hash, backend.name(),
                                 availability_.version, backend.Fingerprint()));
    runs.push_back(std::move(run));
  }
  return runs;
}

std::vector<double> Planner::Centre() const {
  const Eigen::VectorXd middle = Eigen::VectorXd::Constant(study_.space.dimension(), 0.5);
  const Eigen::VectorXd values = study_.space.FromUnit(middle);
  return {values.begin(), values.end()};
}

std::vector<std::string> Planner::Warnings() const {
  std::vector<std::string> warnings = study_.warnings;
  if (!study_.backend.backend->simulates() || !ExplainUnsupported().empty()) return warnings;
  for (const PlannedRun& run : Plan(Centre(), 0)) {
    const Materials& m = run.program.materials;
    const double fraction =
        run.program.time_step / RayleighTime(study_.powder.sizes.Quantile(0) / 2, m.density,
                                             m.young_modulus, m.poisson_ratio);
    if (fraction <= 0.4) continue;
    warnings.push_back(
        fmt::format("{}: the time step is {:.2g} Rayleigh times of the smallest "
                    "particle; beyond 0.4 runs blow up",
                    run.program.experiment, fraction));
  }
  // What experiments warn of, chatter of rolling friction, is worst where that is largest.
  std::vector<double> parameters = Centre();
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const Parameter& parameter = study_.space.parameters[i];
    if (parameter.name == "rolling_friction") parameters[i] = parameter.upper;
  }
  for (const PlannedRun& run : Plan(parameters, 0)) {
    for (std::string& text : study_.experiments[run.experiment].experiment->Warnings(run.program)) {
      warnings.push_back(std::move(text));
    }
  }
  return warnings;
}

std::string Planner::ExplainUnsupported() const {
  for (std::size_t i = 0; i < study_.experiments.size(); ++i) {
    const std::string reason = study_.scaling->ExplainUnsupported(Laboratory(i));
    if (!reason.empty()) {
      return fmt::format("scaling '{}' of {}: {}", study_.scaling->name(),
                         study_.experiments[i].experiment->name(), reason);
    }
    const Experiment& experiment = *study_.experiments[i].experiment;
    const std::string refusal =
        experiment.ExplainUnsupported(MakePowder(Simulation(i, Centre()), Centre()));
    if (!refusal.empty()) return fmt::format("{}: {}", experiment.name(), refusal);
  }
  for (const PlannedRun& run : Plan(Centre(), 0)) {
    const std::string reason = study_.backend.backend->ExplainUnsupported(run.program);
    if (!reason.empty()) {
      return fmt::format("backend '{}' cannot run {}: {}", study_.backend.backend->name(),
                         run.program.experiment, reason);
    }
  }
  return "";
}

LedgerRun Planner::Execute(const PlannedRun& run, const RunContext& context) const {
  const auto elapsed = [start = std::chrono::steady_clock::now()] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  LedgerRun result{.key = run.key,
                   .experiment = run.program.experiment,
                   .program_hash = run.program_hash,
                   .seed = run.seed,
                   .backend = study_.backend.backend->name(),
                   .backend_version = availability_.version,
                   .fidelity = FidelityNames()[static_cast<std::size_t>(run.program.fidelity)]};
  try {
    const Trace trace = study_.backend.backend->Run(run.program, context);
    result.outcome = trace.outcome;
    result.diagnostics = trace.diagnostics;
    if (trace.outcome.ok()) {
      Measurement measurement = study_.experiments[run.experiment].experiment->Measure(
          run.program, trace, &result.outcome);
      if (result.outcome.ok())
        result.measurement = std::move(measurement);
      else
        result.measurement.diagnostics = std::move(measurement.diagnostics);
    }
  } catch (const std::exception& error) {
    // Memory or a disk that ran out, a folder that vanished: the run failed, the study goes on.
    result.outcome = {Reason::crashed, error.what()};
    if (result.diagnostics.wall_seconds == 0) result.diagnostics.wall_seconds = elapsed();
  }
  for (const auto& [name, response] : result.measurement.responses) {
    if (!std::isfinite(response.value)) {
      result.outcome = {Reason::unstable, fmt::format("response {} is not finite", name)};
      result.measurement.responses.clear();
      break;
    }
  }
  result.total_seconds = elapsed();
  return result;
}

Planner::Cost Planner::EstimateCost() const {
  const BackendSpecification& backend = study_.backend;
  const auto experiments = static_cast<int>(study_.experiments.size());
  Cost cost{.runs = experiments * (study_.budget.evaluations * backend.replicates +
                                   backend.confirm_replicates - backend.replicates)};
  for (const PlannedRun& run : Plan(Centre(), 0)) {
    const double duration =
        study_.experiments[run.experiment].experiment->ExpectedDuration(run.program);
    const double steps = duration / run.program.time_step;
    const double throughput = backend.backend->Throughput(run.program);
    cost.steps_per_run += steps / experiments;
    if (throughput > 0) {
      cost.seconds_per_run += steps * run.program.particles.count / throughput / experiments;
    }
  }
  cost.seconds = cost.seconds_per_run * cost.runs / study_.parallel();
  return cost;
}

std::vector<ScalingTable> Planner::ScalingTables(const std::vector<double>& parameters) const {
  std::vector<ScalingTable> tables;
  for (std::size_t i = 0; i < study_.experiments.size(); ++i) {
    tables.push_back({study_.experiments[i].experiment->name(),
                      CompareGroups(Laboratory(i), Simulation(i, parameters))});
  }
  return tables;
}

}  // namespace powdercal
